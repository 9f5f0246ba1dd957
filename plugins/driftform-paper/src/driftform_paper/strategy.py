"""The paper's genetic algorithm: roulette wheel on raw fitness, no elitism, one population per target."""

from collections.abc import Sequence
from typing import Literal

import numpy as np

from driftform.interfaces import GenerationStrategy, SearchSpace, Table, option
from driftform.types import Candidate, Evaluation, FloatArray, Genome


class PaperOptions(Table):
    """The paper's hyper-parameters (section 3)."""

    population: int = option(10, "individuals in the population of each target", "", ge=2, le=100_000)
    crossover: float = option(0.9, "probability that two parents exchange rules", "", ge=0, le=1)
    mutation: Literal["per_symbol", "per_offspring"] = option(
        "per_symbol",
        "'per_symbol': mutation_rate is the probability that a symbol flips; 'per_offspring': the probability "
        "that one symbol of an offspring flips",
    )
    mutation_rate: float = option(0.1, "probability of mutation", "", ge=0, le=1)


class PaperStrategy(GenerationStrategy[PaperOptions]):
    """The paper's genetic algorithm (section 2.3) for many targets at once.

    Every target has its own population, selected by the fitness for that target only. Each flight still scores every
    target, so the best agent of a run for a target may come from another target's population. 50 evaluations per
    target are the paper's 5 generations of 10.
    """

    name = "paper"
    Options = PaperOptions

    def __init__(self, options: PaperOptions, space: SearchSpace) -> None:
        super().__init__(options, space)
        # Evaluations of each target with their indices in the run.
        self._populations: list[list[tuple[int, Evaluation]]] = [[] for _ in space.targets]

    def begin_generation(self) -> list[Candidate]:
        """Return the next generation of every population."""
        targets = enumerate(self.space.targets)
        return [candidate for number, target in targets for candidate in self._next_population(number, target)]

    def end_generation(self, first: int, evaluations: Sequence[Evaluation]) -> None:
        """Replace the parents by the generation just evaluated: constant size, no elitism."""
        told = list(enumerate(evaluations, first))
        size = self.options.population
        self._populations = [told[k : k + size] for k in range(0, len(told), size)]

    def _next_population(self, number: int, target: str) -> list[Candidate]:
        rng, grammar, size = self.space.rng, self.space.grammar, self.options.population
        parents = self._populations[number]
        if not parents:
            return [Candidate(grammar.random(rng), (), self.generation, target) for _ in range(size)]
        chance = roulette_probabilities([parent.fitness[number] for _, parent in parents])
        offspring: list[Candidate] = []
        while len(offspring) < size:
            (i, a), (j, b) = (parents[at] for at in rng.choice(len(parents), size=2, p=chance))
            genomes = (a.genome, b.genome)
            lineage: list[tuple[int, ...]] = [(i,), (j,)]
            if rng.random() < self.options.crossover:
                genomes, lineage = grammar.crossover(*genomes, rng), [(i, j)] * 2
            for genome, of in zip(genomes, lineage, strict=True):
                offspring.append(Candidate(self._mutate(genome), of, self.generation, target))
        return offspring[:size]

    def _mutate(self, genome: Genome) -> Genome:
        rng, grammar, rate = self.space.rng, self.space.grammar, self.options.mutation_rate
        if self.options.mutation == "per_symbol":
            return grammar.mutate(genome, rng, rate)
        if genome.symbols and rng.random() < rate:
            return grammar.flip(genome, int(rng.integers(len(genome.symbols))), rng)
        return genome


def roulette_probabilities(fitness: Sequence[float] | FloatArray) -> FloatArray:
    """Return probabilities proportional to fitness, uniform if all fitness is zero, (n,).

    >>> roulette_probabilities([1.0, 3.0])
    array([0.25, 0.75])
    """
    weights = np.asarray(fitness, dtype=np.float64)
    total = float(weights.sum())
    return np.asarray(weights / total if total > 0 else np.full(len(weights), 1 / len(weights)))
