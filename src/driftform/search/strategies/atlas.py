"""MAP-Elites: a map of the pipe that keeps, for each cell, the agent that comes closest to its centre."""

from collections.abc import Sequence

import numpy as np

from driftform.interfaces import SearchSpace, Strategy
from driftform.options import Table, option
from driftform.runs.coverage import CoverageMap, IntArray, PipeGrid
from driftform.types import Candidate, Evaluation, FloatArray, Genome


class AtlasOptions(Table):
    """Options of the map and of the breeding of its elites."""

    cell: float | None = option(
        None,
        "side of the cells of the map (default: a tenth of the pipe's radius)",
        "m",
        ge=0.001,
        le=100,
        strict=True,
    )
    random: int = option(200, "random genomes at the start", "", gt=0, le=10_000_000)
    batch: int = option(50, "candidates per batch", "", gt=0, le=100_000)
    novelty: float = option(
        1.0,
        "preference for rarely crossed cells: the probability that a cell breeds is proportional to the number of "
        "flights across it to the power of minus this value",
        "",
        ge=0,
        le=4,
    )
    crossover: float = option(0.3, "probability that an offspring has two parents", "", ge=0, le=1)
    mutation_rate: float = option(0.03, "probability of each symbol to flip", "", ge=0, le=1)


class AtlasStrategy(Strategy[AtlasOptions]):
    """MAP-Elites: a map of the pipe's section in the vertical plane through its axis; ignores the targets.

    Every flight counts for every cell that it crosses, and each cell keeps the agent whose flight comes closest to its
    centre. After some random genomes, parents are the agents of randomly drawn cells, preferably of cells that few
    flights cross; the offspring always differs from them. The map so fills in places that are hard to reach, and
    `driftform pick` finds an agent that passes a given point, even if that point was not a target. (Mouret and Clune
    2015, arXiv:1504.04909; there each solution belongs to one cell.)
    """

    name = "atlas"
    Options = AtlasOptions

    def __init__(self, options: AtlasOptions, space: SearchSpace) -> None:
        super().__init__(options, space)
        self._coverage = CoverageMap(PipeGrid.of_scenario(space.scenario, options.cell))
        # One genome per cell: a genome that is replaced in all its cells is forgotten.
        self._elites: dict[int, Genome] = {}
        self._evaluated = 0
        self._generation = 0

    def ask(self, limit: int) -> list[Candidate]:
        """Return the next batch, at most ``limit`` candidates."""
        size, rng = self.options.batch, self.space.rng
        remaining = self.options.random - self._evaluated
        if remaining > 0 or not self._elites:
            genomes = [
                self.space.grammar.random(rng) for _ in range(min(size, remaining) if remaining > 0 else size)
            ]
            return [Candidate(genome, (), self._generation) for genome in genomes][:limit]
        cells = np.flatnonzero(self._coverage.reached)
        chance = breeding_probabilities(self._coverage.visits[cells], self.options.novelty)
        pairs = rng.choice(cells, size=(size, 2), p=chance)
        return [self._breed(int(a), int(b)) for a, b in pairs][:limit]

    def tell(self, first: int, evaluations: Sequence[Evaluation]) -> None:
        """Add the flights to the map."""
        for index, evaluation in enumerate(evaluations, first):
            if evaluation.failure is None and evaluation.trajectory is not None:
                for cell in self._coverage.add(index, evaluation.trajectory).tolist():
                    self._elites[cell] = evaluation.genome
        self._evaluated += len(evaluations)
        self._generation += 1

    def _breed(self, a: int, b: int) -> Candidate:
        """Breed the agent of cell ``a``, and that of ``b`` if there is a crossover."""
        options = self.options
        child, crossed = self.space.grammar.breed(
            self._elites[a],
            self._elites[b],
            self.space.rng,
            crossover=options.crossover,
            mutation_rate=options.mutation_rate,
        )
        parents = self._coverage.evaluation[[a, b] if crossed else [a]]
        return Candidate(child, tuple(parents.tolist()), self._generation)


def breeding_probabilities(visits: IntArray, novelty: float) -> FloatArray:
    """Return probabilities proportional to ``visits`` (positive) to the power of ``-novelty``, (n,).

    >>> breeding_probabilities(np.array([1, 3]), 1.0)
    array([0.75, 0.25])
    """
    weights = np.asarray(visits, dtype=np.float64) ** -novelty
    return np.asarray(weights / weights.sum())
