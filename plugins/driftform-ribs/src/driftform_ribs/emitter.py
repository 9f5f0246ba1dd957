"""An emitter for genomes of symbols; the emitters of pyribs are for vectors of numbers."""

from typing import Any

import numpy as np
import numpy.typing as npt
from ribs.archives import ArchiveBase
from ribs.emitters import EmitterBase

from driftform.interfaces import Grammar
from driftform.types import Genome

ObjectArray = npt.NDArray[np.object_]
"""Solutions of pyribs: an array of genomes, (n,)."""


def to_solutions(genomes: list[Genome]) -> ObjectArray:
    """Return genomes as an array of objects, (n,)."""
    solutions = np.empty(len(genomes), dtype=object)
    solutions[:] = genomes
    return solutions


class SymbolEmitter(EmitterBase):
    """Breeds the elites of an archive by the operators of a grammar.

    A solution is a genome itself, in an archive with ``solution_dim=()`` and ``solution_dtype=object``. Symbols are not
    converted to numbers, so genomes can have any length and alphabet.

    Attributes:
        parents: for each of the solutions last asked for, the evaluations of its parents. The archive must have a
            field ``evaluation``.
    """

    def __init__(
        self,
        archive: ArchiveBase,
        grammar: Grammar[Any],
        rng: np.random.Generator,
        *,
        batch: int,
        crossover: float,
        mutation_rate: float,
    ) -> None:
        super().__init__(archive, solution_dim=(), bounds=None, lower_bounds=None, upper_bounds=None)
        self.parents: list[tuple[int, ...]] = []
        self._grammar, self._rng, self._batch = grammar, rng, batch
        self._crossover, self._mutation_rate = crossover, mutation_rate

    def ask(self) -> ObjectArray:
        """Return offspring of elites drawn uniformly, or random genomes if the archive is empty, (batch,)."""
        if self.archive.empty:
            self.parents = [()] * self._batch
            return to_solutions([self._grammar.random(self._rng) for _ in range(self._batch)])
        # Drawn by the search's generator and not by the archive's, so that one seed determines everything.
        elites = self.archive.data(["solution", "evaluation"])
        genomes, evaluations = elites["solution"], elites["evaluation"]
        self.parents, offspring = [], []
        for i, j in self._rng.integers(len(genomes), size=(self._batch, 2)):
            child, crossed = self._grammar.breed(
                genomes[i],
                genomes[j],
                self._rng,
                crossover=self._crossover,
                mutation_rate=self._mutation_rate,
            )
            self.parents.append(tuple(evaluations[[i, j] if crossed else [i]].tolist()))
            offspring.append(child)
        return to_solutions(offspring)
