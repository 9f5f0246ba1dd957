"""Illumination: a map of the pipe, and in each of its cells the agent that comes closest to the middle."""

from collections.abc import Sequence

import numpy as np

from driftform.builtin.strategies.breeding import breed
from driftform.interfaces import SearchSpace, Strategy
from driftform.options import Table, option
from driftform.trajectory.coverage import CoverageMap, IntArray, PipeGrid
from driftform.types import Candidate, Evaluation, FloatArray, Genome


class AtlasOptions(Table):
    """The map, and how its elites breed."""

    cell: float | None = option(
        None,
        "side of the cells of the map; a tenth of the pipe's radius where none is given",
        "m",
        ge=0.001,
        strict=True,
    )
    random: int = option(200, "random genomes to begin with", "", gt=0)
    batch: int = option(50, "candidates asked for at once", "", gt=0)
    novelty: float = option(
        1.0,
        "how much rarely crossed cells are favoured: a cell breeds in proportion to this negative power of the "
        "number of flights across it",
        "",
        ge=0,
        le=4,
    )
    crossover: float = option(0.3, "probability that an offspring has two parents", "", ge=0, le=1)
    mutation_rate: float = option(0.03, "probability of each symbol to flip", "", ge=0, le=1)


class AtlasStrategy(Strategy[AtlasOptions]):
    """MAP-Elites over the section of the pipe by the vertical plane through its axis, blind to the targets.

    Every flight is credited with every cell that it crosses, and each cell keeps the agent whose flight comes closest
    to its middle. After some random genomes, parents are the agents of cells drawn at random, those preferred that few
    flights cross; the offspring always differs from them. So the map fills where it is hard to reach, and a point that
    was no target has an agent that passes it: `driftform pick` finds it. (Mouret and Clune 2015, arXiv:1504.04909;
    there each solution has one cell.)
    """

    name = "atlas"
    Options = AtlasOptions

    def __init__(self, options: AtlasOptions, space: SearchSpace) -> None:
        super().__init__(options, space)
        self._reach = CoverageMap(PipeGrid.of(space.scenario, options.cell))
        # One for each cell, and no more: what is no elite any more is forgotten.
        self._elites: dict[int, Genome] = {}
        self._told = 0
        self._generation = 0

    def ask(self, limit: int) -> list[Candidate]:
        """Return the next batch, cut at ``limit``."""
        size, rng = self.options.batch, self.space.rng
        to_come = self.options.random - self._told
        if to_come > 0 or not self._elites:
            genomes = [
                self.space.grammar.random(rng) for _ in range(min(size, to_come) if to_come > 0 else size)
            ]
            return [Candidate(genome, (), self._generation) for genome in genomes][:limit]
        cells = np.flatnonzero(self._reach.reached)
        chance = favour(self._reach.visits[cells], self.options.novelty)
        pairs = rng.choice(cells, size=(size, 2), p=chance)
        return [self._offspring(int(a), int(b)) for a, b in pairs][:limit]

    def tell(self, first: int, evaluations: Sequence[Evaluation]) -> None:
        """Credit the flights with the cells that they cross."""
        for index, evaluation in enumerate(evaluations, first):
            if evaluation.failure is None and evaluation.trajectory is not None:
                for cell in self._reach.add(index, evaluation.trajectory).tolist():
                    self._elites[cell] = evaluation.genome
        self._told += len(evaluations)
        self._generation += 1

    def _offspring(self, a: int, b: int) -> Candidate:
        """Breed the agent of cell ``a``, with that of ``b`` where it comes to a crossover."""
        options = self.options
        child, crossed = breed(
            self.space.grammar,
            self._elites[a],
            self._elites[b],
            self.space.rng,
            crossover=options.crossover,
            mutation_rate=options.mutation_rate,
        )
        parents = self._reach.evaluation[[a, b] if crossed else [a]]
        return Candidate(child, tuple(parents.tolist()), self._generation)


def favour(visits: IntArray, novelty: float) -> FloatArray:
    """Return probabilities in proportion to ``visits`` (positive) to the power of ``-novelty``, (n,).

    >>> favour(np.array([1, 3]), 1.0)
    array([0.75, 0.25])
    """
    weights = np.asarray(visits, dtype=np.float64) ** -novelty
    return np.asarray(weights / weights.sum())
