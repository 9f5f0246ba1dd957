"""MAP-Elites with an archive of pyribs, over heights at stations of the pipe or over any measures."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
import numpy.typing as npt
from pydantic import Field, field_validator

from driftform.errors import InputError
from driftform.interfaces import Result, SearchSpace, Strategy, Table, option
from driftform.search import PipeGrid
from driftform.types import Candidate, Evaluation, FloatArray, Genome, Trajectory

if TYPE_CHECKING:
    from ribs.archives import ArchiveBase

Station = Annotated[float, Field(strict=True, gt=0, le=1)]
"""A position along the pipe, relative to its length."""

Bound = Annotated[float, Field(ge=-1e9, le=1e9)]
"""The least or the greatest value of a measure."""

_SAMPLES = 10_000
"""Samples of the measure space from which the centroids of a CVT archive are computed."""


class RibsOptions(Table):
    """The archive, the measures of its elites, and how they breed."""

    archive: Literal["cvt", "grid"] = option(
        "cvt", "'cvt': cells around centroids (Vassiliades et al. 2018), 'grid': equal boxes (Mouret and Clune 2015)"
    )
    cells: int = option(
        1000,
        "cells of the archive; a grid has the largest equal number in each measure that this allows",
        "",
        ge=2,
        le=100_000,
    )
    stations: tuple[Station, ...] = option(
        (0.25, 0.5, 1.0),
        "stations at which the height of a flight is measured, relative to the pipe's length; one measure each",
        min_length=1,
        max_length=6,
    )
    measures: dict[str, tuple[Bound, Bound]] = option(
        {},
        "measures that are the axes of the archive, each with its least and greatest value, in place of heights at stations",
        max_length=6,
    )
    objective: Literal["best", "mean"] = option(
        "best", "objective of an elite: its best fitness for any target, or the mean over all targets"
    )
    batch: int = option(50, "candidates asked for at once", "", gt=0, le=100_000)
    random: int = option(200, "random genomes at the start", "", gt=0, le=10_000_000)
    crossover: float = option(0.3, "probability that an offspring has two parents", "", ge=0, le=1)
    mutation_rate: float = option(0.03, "probability that a symbol flips", "", ge=0, le=1)

    @field_validator("measures")
    @classmethod
    def _check_ranges(cls, measures: dict[str, tuple[float, float]]) -> dict[str, tuple[float, float]]:
        for name, (low, high) in measures.items():
            if not low < high:
                raise ValueError(f"{name} goes from {low:g} to {high:g}: the least value comes first")
        return measures


class RibsStrategy(Strategy[RibsOptions]):
    """Quality diversity by pyribs: the archive keeps flights that pass the stations at different heights.

    The measures of a flight are its heights above the pipe's axis at some stations along it, or any that an evaluation
    has, such as mass and length; the archive keeps the fittest of the flights with similar measures. Parents are drawn uniformly from the elites. The map of
    what flights reach so fills in places that are hard to reach, and `driftform pick` finds an agent for any point.
    """

    name = "ribs"
    Options = RibsOptions

    def __init__(self, options: RibsOptions, space: SearchSpace) -> None:
        super().__init__(options, space)
        self._cells = PipeGrid.of_scenario(space.scenario)
        length, height = self._cells.size[:2] * self._cells.shape
        self._stations = length * np.array(options.stations)
        heights = [(-float(height) / 2, float(height) / 2)] * len(options.stations)
        self._ranges = list(options.measures.values()) or heights
        self._names = [*options.measures] or [f"height_{station:g}" for station in options.stations]
        self._archive = make_archive(options, self._ranges, int(space.rng.integers(2**31)))
        self._evaluated = 0
        self._generation = 0

    def ask(self, limit: int) -> list[Candidate]:
        """Return the next batch, cut at ``limit``."""
        options, rng, grammar = self.options, self.space.rng, self.space.grammar
        remaining = options.random - self._evaluated
        if remaining > 0 or self._archive.empty:
            count = min(options.batch, remaining) if remaining > 0 else options.batch
            genomes = [grammar.random(rng) for _ in range(count)]
            return [Candidate(genome, (), self._generation) for genome in genomes][:limit]
        # Drawn by the search's generator and not by the archive's, so that one seed determines everything.
        elites = self._archive.data(["solution", "evaluation"])
        found = []
        for pair in rng.integers(len(elites["solution"]), size=(options.batch, 2)):
            a, b = elites["solution"][pair]
            child, crossed = grammar.breed(a, b, rng, crossover=options.crossover, mutation_rate=options.mutation_rate)
            parents = elites["evaluation"][pair if crossed else pair[:1]]
            found.append(Candidate(child, tuple(parents.tolist()), self._generation))
        return found[:limit]

    def tell(self, first: int, evaluations: Sequence[Evaluation]) -> None:
        """Add the flights to the archive."""
        measured = [
            (index, evaluation, self._measure(evaluation, evaluation.trajectory))
            for index, evaluation in enumerate(evaluations, first)
            if evaluation.failure is None and evaluation.trajectory is not None
        ]
        # What never happens in a flight, such as a contact, has no place in the archive.
        sound = [row for row in measured if np.isfinite(row[2]).all()]
        if sound:
            score = np.max if self.options.objective == "best" else np.mean
            self._archive.add(
                as_objects([evaluation.genome for _, evaluation, _ in sound]),
                np.array([score(evaluation.fitness) for _, evaluation, _ in sound]),
                np.array([measures for _, _, measures in sound]),
                evaluation=np.array([index for index, _, _ in sound]),
            )
        self._evaluated += len(evaluations)
        self._generation += 1

    def collect_results(self) -> Mapping[str, Result]:
        """Return the archive: the evaluation, the fitness and the measures of each elite."""
        data = self._archive.data(["evaluation", "objective", "measures"])
        columns = {"evaluation": data["evaluation"], "fitness": data["objective"]}
        columns |= dict(zip(self._names, data["measures"].T, strict=True))
        meaning = "The fittest of flights with similar measures."
        if len(self._names) < 2:
            return {"archive": Result(meaning, columns)}
        side = find_side(self.options, len(self._names))
        grid = [(low, high, side) for low, high in self._ranges[:2]]
        return {"archive": Result(meaning, columns, self._names[:2], grid, "fitness")}

    def _measure(self, evaluation: Evaluation, flight: Trajectory) -> FloatArray:
        """Return the place of a flight in the archive."""
        names = self.options.measures
        if not names:
            return station_heights(self._cells, flight, self._stations)
        if lacking := [name for name in names if name not in evaluation.measures]:
            known = ", ".join(evaluation.measures)
            raise InputError(f"strategy.measures has '{lacking[0]}', which no evaluation has; these have {known}")
        return np.array([evaluation.measures[name] for name in names])


def as_objects(genomes: Sequence[Genome]) -> npt.NDArray[np.object_]:
    """Return genomes as an array of objects, (n,): so they have any length and alphabet, and are not converted."""
    solutions = np.empty(len(genomes), dtype=object)
    solutions[:] = genomes
    return solutions


def find_side(options: RibsOptions, measures: int) -> int:
    """Return the number of cells of a grid along each measure; for cells around centroids, that of a map of two measures."""
    # The small term absorbs rounding: the cube root of 1000 is 9.999...
    return max(2, int(options.cells ** (1 / (measures if options.archive == "grid" else 2)) + 1e-9))


def make_archive(options: RibsOptions, ranges: Sequence[tuple[float, float]], seed: int) -> "ArchiveBase":
    """Return an empty archive of genomes over measures with these ranges."""
    # Imported here: every command lists the names of all strategies, and importing pyribs takes 2 s.
    from ribs.archives import CVTArchive, GridArchive
    from threadpoolctl import threadpool_limits

    common: dict[str, Any] = {
        "solution_dim": (),
        "solution_dtype": object,
        "objective_dtype": np.float64,
        "measures_dtype": np.float64,
        "ranges": ranges,
        "extra_fields": {"evaluation": ((), np.int64)},
        "seed": seed,
    }
    if options.archive == "grid":
        return GridArchive(dims=[find_side(options, len(ranges))] * len(ranges), **common)
    # The order of k-means' sums depends on the number of threads: one thread gives the same cells everywhere.
    with threadpool_limits(1):
        return CVTArchive(centroids=options.cells, samples=max(_SAMPLES, 10 * options.cells), **common)


def station_heights(cells: PipeGrid, trajectory: Trajectory, stations: FloatArray) -> FloatArray:
    """Return the height above the axis (m) at which a flight first passes each station (m along the pipe), (stations,).

    The height is interpolated linearly between samples. If a flight ends before a station, its final height is
    returned for that station.
    """
    along, up = cells.to_map(trajectory.position)[:, :2].T
    found = np.empty(len(stations))
    for i, station in enumerate(stations):
        beyond = int(np.argmax(along >= station))
        if along[beyond] < station:
            found[i] = up[-1]
        elif beyond == 0:
            found[i] = up[0]
        else:
            share = (station - along[beyond - 1]) / (along[beyond] - along[beyond - 1])
            found[i] = up[beyond - 1] + share * (up[beyond] - up[beyond - 1])
    return found
