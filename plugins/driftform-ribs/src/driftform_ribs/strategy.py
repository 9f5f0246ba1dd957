"""Quality diversity with an archive of pyribs, over heights at stations of the pipe or over any measures."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Annotated, Any, Literal

import numpy as np
import numpy.typing as npt
from pydantic import Field, field_validator

from driftform.interfaces import GenerationStrategy, Result, SearchSpace, Table, option
from driftform.search import PipeGrid
from driftform.types import Candidate, Evaluation, FloatArray, Genome, Trajectory

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
        "measures that are the axes of the archive in place of heights at stations, each with its least and greatest value, "
        "such as mass, or height_0.5 for the height half-way",
        max_length=6,
    )
    objective: Literal["best", "mean"] = option(
        "best", "objective of an elite: its best fitness for any target, or the mean over all targets"
    )
    emitter: Literal["breed", "cma-me", "cma-mae"] = option(
        "breed",
        "what makes candidates: 'breed', offspring of elites; 'cma-me' (Fontaine et al. 2020) or 'cma-mae' (Fontaine and "
        "Nikolaidis 2023), evolution strategies over genomes that are vectors, such as those of bspline",
    )
    emitters: int = option(5, "evolution strategies at a time, which share a batch", "", ge=1, le=1000)
    step: float = option(0.2, "first step of an evolution strategy, relative to the range of each gene", "", gt=0, le=1)
    learning_rate: float = option(0.01, "how fast 'cma-mae' asks for more of a cell, 0 to 1", "", ge=0, le=1)
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


class RibsStrategy(GenerationStrategy[RibsOptions]):
    """Quality diversity by pyribs: the archive keeps flights that pass the stations at different heights.

    The measures of a flight are its heights above the pipe's axis at some stations along it, or any that an evaluation
    has, such as mass and length; the archive keeps the fittest of the flights with similar measures. Parents are drawn uniformly from the elites,
    or evolution strategies look for what improves the archive. The map of what flights reach so fills in places that are hard to
    reach, and `driftform pick` finds an agent for any point.
    """

    name = "ribs"
    Options = RibsOptions

    def __init__(self, options: RibsOptions, space: SearchSpace) -> None:
        super().__init__(options, space)
        self._names = [*options.measures] or [f"height_{station:g}" for station in options.stations]
        self._stations = {
            name: float(name[7:]) for name in self._names if re.fullmatch(r"height_(1|0?\.\d+|[\d.]+e-\d+)", name)
        }
        self._cells = PipeGrid.of_scenario(space.scenario) if self._stations else None
        length, height = (0.0, 0.0) if self._cells is None else self._cells.size[:2] * self._cells.shape
        self._places = float(length) * np.array([*self._stations.values()])
        self._ranges = list(options.measures.values()) or [(-float(height) / 2, float(height) / 2)] * len(self._names)
        genes, seed = 0 if options.emitter == "breed" else len(space.grammar.list_genes()), space.rng.integers(2**31)
        self._guide = self._archive = make_archive(options, self._ranges, int(seed), genes)
        if options.emitter == "cma-mae":
            # It asks of a cell less than its elite has, so the elites have an archive of their own.
            soft = {"learning_rate": options.learning_rate, "threshold_min": -1.0}
            self._guide = make_archive(options, self._ranges, int(seed), genes, **soft)
        self._emitters = make_emitters(options, self._guide, genes, space.rng) if genes else []
        self._asked = np.empty((0, genes))
        self._evaluated = 0

    def begin_generation(self) -> list[Candidate]:
        """Return the next batch."""
        options, rng, grammar = self.options, self.space.rng, self.space.grammar
        if self._emitters:
            self._asked = np.concatenate([emitter.ask() for emitter in self._emitters])
            # Mirrored at the bounds of the genes, where evolution strategies know none.
            vectors = 1 - np.abs(1 - self._asked % 2)
            return [Candidate(grammar.make_genome(vector), (), self.generation) for vector in vectors]
        remaining = options.random - self._evaluated
        if remaining > 0 or self._archive.empty:
            count = min(options.batch, remaining) if remaining > 0 else options.batch
            return [Candidate(grammar.random(rng), (), self.generation) for _ in range(count)]
        # Drawn by the search's generator and not by the archive's, so that one seed determines everything.
        elites = self._archive.data(["solution", "evaluation"])
        found = []
        for pair in rng.integers(len(elites["solution"]), size=(options.batch, 2)):
            a, b = elites["solution"][pair]
            crossed = bool(rng.random() < options.crossover)
            child = grammar.mutate(grammar.crossover(a, b, rng)[0] if crossed else a, rng, options.mutation_rate)
            if child in (a, b) and child.symbols:
                # Otherwise it would fly as the parent did.
                child = grammar.flip(child, int(rng.integers(len(child.symbols))), rng)
            parents = elites["evaluation"][pair if crossed else pair[:1]]
            found.append(Candidate(child, tuple(parents.tolist()), self.generation))
        return found

    def end_generation(self, first: int, evaluations: Sequence[Evaluation]) -> None:
        """Add the flights to the archive, and tell the evolution strategies what they added."""
        self._evaluated += len(evaluations)
        measures = np.array([self._measure(evaluation) for evaluation in evaluations])
        sound = np.isfinite(measures).all(axis=1)
        if not sound.any():
            return
        score = np.max if self.options.objective == "best" else np.mean
        fitness = np.array([float(score(evaluation.fitness)) for evaluation in evaluations])
        solutions = self._asked if self._emitters else as_objects([one.genome for one in evaluations])
        rows = first + np.arange(len(evaluations))
        for archive in dict.fromkeys((self._archive, self._guide)):
            added = archive.add(solutions[sound], fitness[sound], measures[sound], evaluation=rows[sound])
        # What failed adds nothing, and ranks last, by how far it is from feasible.
        status = np.zeros(len(sound), dtype=np.int32)
        value = -1000.0 - np.array([sum(evaluation.violations.values()) for evaluation in evaluations])
        status[sound], value[sound] = added["status"], added["value"]
        measures[~sound] = np.mean(self._ranges, axis=1)
        for number, emitter in enumerate(self._emitters):
            at = slice(number * emitter.batch_size, (number + 1) * emitter.batch_size)
            info: dict[str, npt.NDArray[Any]] = {"status": status[at], "value": value[at]}
            emitter.tell(solutions[at], fitness[at], measures[at], info, evaluation=rows[at])

    def collect_results(self) -> Mapping[str, Result]:
        """Return the archive: the evaluation, the fitness and the measures of each elite."""
        data, side = (
            self._archive.data(["evaluation", "objective", "measures"]),
            find_side(self.options, len(self._names)),
        )
        columns = {"evaluation": data["evaluation"], "fitness": data["objective"]}
        columns |= dict(zip(self._names, data["measures"].T, strict=True))
        meaning = "The fittest of flights with similar measures."
        if len(self._names) < 2:
            return {"archive": Result(meaning, columns)}
        grid = [(low, high, side) for low, high in self._ranges[:2]]
        return {"archive": Result(meaning, columns, self._names[:2], grid, "fitness")}

    def _measure(self, evaluation: Evaluation) -> FloatArray:
        """Return the place of a flight in the archive; NaN if it has none."""
        flight = evaluation.trajectory
        if evaluation.failure is not None or flight is None or any(evaluation.violations.values()):
            return np.full(len(self._names), np.nan)
        heights = np.zeros(0) if self._cells is None else station_heights(self._cells, flight, self._places)
        measures = {**evaluation.measures, **dict(zip(self._stations, heights, strict=True))}
        return np.array(self.read_values(replace(evaluation, measures=measures), self._names, "measures"))


def as_objects(genomes: Sequence[Genome]) -> npt.NDArray[np.object_]:
    """Return genomes as an array of objects, (n,): so they have any length and alphabet, and are not converted."""
    solutions = np.empty(len(genomes), dtype=object)
    solutions[:] = genomes
    return solutions


def find_side(options: RibsOptions, measures: int) -> int:
    """Return the number of cells of a grid along each measure; of a map of the first two for cells around centroids."""
    # The small term absorbs rounding: the cube root of 1000 is 9.999...
    return max(2, int(options.cells ** (1 / (measures if options.archive == "grid" else 2)) + 1e-9))


def make_archive(
    options: RibsOptions, ranges: Sequence[tuple[float, float]], seed: int, genes: int = 0, **values: Any
) -> Any:
    """Return an empty archive over measures with these ranges, of genomes, or of vectors of ``genes``."""
    # Imported here: every command lists the names of all strategies, and importing pyribs takes 2 s.
    from ribs.archives import CVTArchive, GridArchive
    from threadpoolctl import threadpool_limits

    common: dict[str, Any] = {
        "solution_dim": genes or (),
        "solution_dtype": np.float64 if genes else object,
        "objective_dtype": np.float64,
        "measures_dtype": np.float64,
        "ranges": ranges,
        "extra_fields": {"evaluation": ((), np.int64)},
        "seed": seed,
        **values,
    }
    if options.archive == "grid":
        return GridArchive(dims=[find_side(options, len(ranges))] * len(ranges), **common)
    # The order of k-means' sums depends on the number of threads: one thread gives the same cells everywhere.
    with threadpool_limits(1):
        return CVTArchive(centroids=options.cells, samples=max(_SAMPLES, 10 * options.cells), **common)


def make_emitters(options: RibsOptions, archive: Any, genes: int, rng: np.random.Generator) -> list[Any]:
    """Return evolution strategies that look for what improves an archive, from the middle of the ranges of all genes."""
    from ribs.emitters import EvolutionStrategyEmitter

    ranking: dict[str, Any] = {"ranker": "2imp", "selection_rule": "filter", "restart_rule": "no_improvement"}
    if options.emitter == "cma-mae":
        ranking = {"ranker": "imp", "selection_rule": "mu", "restart_rule": "basic"}
    size = max(2, options.batch // options.emitters)
    return [
        EvolutionStrategyEmitter(
            archive, x0=np.full(genes, 0.5), sigma0=options.step, batch_size=size, seed=int(seed), **ranking
        )
        for seed in rng.integers(2**31, size=options.emitters)
    ]


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
