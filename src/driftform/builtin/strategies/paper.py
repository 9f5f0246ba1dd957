"""The paper's genetic algorithm: roulette wheel on raw fitness, no elitism, one population for each target."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from driftform.interfaces import SearchSpace, Strategy
from driftform.options import Table, option
from driftform.types import Candidate, Evaluation, FloatArray, Genome


class PaperOptions(Table):
    """The paper's hyper-parameters (section 3)."""

    population: int = option(10, "size of each target's population", "", ge=2)
    crossover: float = option(0.9, "probability that two parents exchange rules", "", ge=0, le=1)
    mutation: Literal["per_symbol", "per_offspring"] = option(
        "per_symbol",
        "'per_symbol': mutation_rate is the probability of each symbol to flip; 'per_offspring': that of an "
        "offspring to have one symbol flipped",
    )
    mutation_rate: float = option(0.1, "probability of mutation", "", ge=0, le=1)


@dataclass(frozen=True, eq=False)
class _Individual:
    index: int
    genome: Genome
    fitness: FloatArray


class PaperStrategy(Strategy[PaperOptions]):
    """Section 2.3 for many targets at once.

    Every target has a population of its own, selected by the fitness for that target alone. Each flight still
    scores every target, so the run's best for a target may come from another one's population. 50 evaluations
    for each target are the paper's 5 generations of 10.
    """

    name = "paper"
    Options = PaperOptions

    def __init__(self, options: PaperOptions, space: SearchSpace) -> None:
        super().__init__(options, space)
        self._generation = 0
        self._asked: list[Candidate] = []
        self._populations: list[list[_Individual]] = [[] for _ in space.targets]

    def ask(self, limit: int) -> list[Candidate]:
        """Return the next generation of every population, cut at ``limit``."""
        candidates = [
            candidate
            for number, target in enumerate(self.space.targets)
            for candidate in self._next_population(number, target)
        ]
        self._asked = candidates[:limit]
        return list(self._asked)

    def tell(self, first: int, evaluations: Sequence[Evaluation]) -> None:
        """Let the generation just evaluated replace its parents: constant size, no elitism."""
        populations: dict[str, list[_Individual]] = {target: [] for target in self.space.targets}
        for offset, (candidate, evaluation) in enumerate(zip(self._asked, evaluations, strict=True)):
            individual = _Individual(first + offset, evaluation.genome, evaluation.fitness)
            populations[candidate.target].append(individual)
        # A generation that the budget cut short leaves some populations unasked: they stay as they were.
        for number, target in enumerate(self.space.targets):
            self._populations[number] = populations[target] or self._populations[number]
        self._generation += 1

    def _next_population(self, number: int, target: str) -> list[Candidate]:
        rng, grammar, size = self.space.rng, self.space.grammar, self.options.population
        parents = self._populations[number]
        if not parents:
            return [Candidate(grammar.random(rng), (), self._generation, target) for _ in range(size)]
        chance = roulette([parent.fitness[number] for parent in parents])
        offspring: list[Candidate] = []
        while len(offspring) < size:
            i, j = rng.choice(len(parents), size=2, p=chance)
            a, b = parents[i], parents[j]
            genomes = (a.genome, b.genome)
            lineage: list[tuple[int, ...]] = [(a.index,), (b.index,)]
            if rng.random() < self.options.crossover:
                genomes = grammar.crossover(*genomes, rng)
                lineage = [(a.index, b.index)] * 2
            for genome, of in zip(genomes, lineage, strict=True):
                offspring.append(Candidate(self._mutate(genome), of, self._generation, target))
        return offspring[:size]

    def _mutate(self, genome: Genome) -> Genome:
        rng, grammar, rate = self.space.rng, self.space.grammar, self.options.mutation_rate
        if self.options.mutation == "per_symbol":
            return grammar.mutate(genome, rng, rate)
        if genome.symbols and rng.random() < rate:
            return grammar.flip(genome, int(rng.integers(len(genome.symbols))), rng)
        return genome


def roulette(fitness: Sequence[float] | FloatArray) -> FloatArray:
    """Return probabilities proportional to fitness, uniform where there is none, (n,).

    >>> roulette([1.0, 3.0])
    array([0.25, 0.75])
    """
    weights = np.asarray(fitness, dtype=np.float64)
    total = float(weights.sum())
    return np.asarray(weights / total if total > 0 else np.full(len(weights), 1 / len(weights)))
