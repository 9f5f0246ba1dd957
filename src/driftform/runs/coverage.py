"""Coverage: the cells of a pipe's section that flights cross, and the closest pass in each."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from driftform.errors import InputError
from driftform.types import BoolArray, FloatArray, Trajectory
from driftform.water import Scenario
from driftform.water.parts.layout import Layout
from driftform.water.parts.shapes import locate_on_axis, place_on_axis
from driftform.water.pipe import Vector

IntArray = npt.NDArray[np.int64]

_ROWS, _COLUMNS = 20, 1000
"""Default number of cells across the pipe, and greatest default number along it."""

_APART = 0.2
"""Distance between the run and a branch on a map, m."""

BOUNDS = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05)
"""Distances between the classes of cells, m."""

_ROUNDING = 1e-9
"""Distance (m) by which a point of the map may lie beyond the end of a part by rounding."""

_FINE = 0.1
"""Length of the pieces of a path, in sides of a cell."""


@dataclass(frozen=True, eq=False)
class PipeGrid:
    """Grid of cells over the section of a pipe, unrolled: the run from inlet to outlet, then each branch.

    The coordinates on the map are the distance along the axes from the inlet, and the height above them: in a vertical
    part, the axes that the pipe carries along take the place of up and aside. A branch begins at the axis of its run,
    :data:`_APART` after the end of the chain before it on the map. All chains have rows for the widest bore.

    A cell is a box centred on the vertical plane through the axis, as deep as it is high: a flight that gusts have blown
    out of the plane does not cross it. Cells are half open, so that each point is in exactly one.

    Attributes:
        layout: the parts.
        starts: what to add to the distance along the axes from the inlet to get the place of each part on the map, m,
            (parts,).
        size: of a cell along, upward and aside, m, (3,).
        shape: number of cells along the axis, and across it.
    """

    layout: Layout
    starts: FloatArray
    size: FloatArray
    shape: tuple[int, int]

    @classmethod
    def of_scenario(cls, scenario: Scenario, side: float | None = None) -> "PipeGrid":
        """Return the grid of a scenario's pipe; the sides of its cells are as close to ``side`` (m) as possible.

        The default side is a tenth of the radius, or more, so that there are at most 1000 cells along the pipe.

        Raises InputError if the scenario is open water, which has no section.
        """
        if scenario.pipe.is_open:
            raise InputError("a map of what flights reach needs a pipe; this scenario is open water")
        layout = scenario.pipe.layout
        firsts, ends = list(range(len(layout.parts))), layout.depths.copy()
        for index, placed in enumerate(layout.parts):
            ends[index] += placed.part.length
            if placed.upstream is not None and not placed.by_branch:
                firsts[index] = firsts[placed.upstream]
        chains, starts, at = np.array(firsts), np.zeros(len(firsts)), 0.0
        for first in np.unique(chains):
            placed, chain = layout.parts[first], chains == first
            if placed.upstream is not None:
                starts[chain] = at + _APART - layout.junction_depth(placed.upstream)
            at = float((starts + ends)[chain].max())
        return cls(layout, starts, *_divide_section(at, max(p.part.radius for p in layout.parts), side))

    @property
    def axes(self) -> FloatArray:
        """Unit vectors along the axis, upward and aside at the inlet, in the world frame, (3, 3)."""
        return self.layout.inlet.axes[[0, 2, 1]]

    @property
    def cell_count(self) -> int:
        """Number of cells."""
        return self.shape[0] * self.shape[1]

    def to_map(self, points: FloatArray) -> FloatArray:
        """Return world points (n, 3) as place along, height above and distance aside of the axis, m, (n, 3).

        A point outside the pipe counts for the first part.
        """
        parts, found = np.maximum(self.layout.find_part(points), 0), np.empty((len(points), 3))
        for index in np.unique(parts):
            here = parts == index
            along, foot, axes, on_branch = locate_on_axis(self.layout.parts[index].part, points[here])
            start = self.starts[index] + np.zeros(len(along))
            if on_branch.any():
                branch = next(
                    k for k, placed in enumerate(self.layout.parts) if placed.by_branch and placed.upstream == index
                )
                start[on_branch] = self.starts[branch]
            off = points[here] - foot
            found[here, 0] = start + self.layout.depths[index] + along
            found[here, 1] = (off * axes[:, 2]).sum(axis=1)
            found[here, 2] = (off * axes[:, 1]).sum(axis=1)
        return found

    def to_world(self, points: FloatArray) -> FloatArray:
        """Return the world points (n, 3) of points on the map (n, 2), m; not a number between the chains of parts."""
        found = np.full((len(points), 3), np.nan)
        for index, placed in enumerate(self.layout.parts):
            entry = self.starts[index] + self.layout.depths[index]
            spans = [(0.0, placed.part.length, entry, False)]
            if placed.by_branch and placed.upstream is not None:
                # The axis of the branch within the tee, from that of the run on.
                tee = placed.upstream
                begin = self.layout.junction_depth(tee) - self.layout.depths[tee]
                end = self.layout.depths[index] - self.layout.depths[tee]
                spans.append((begin, end, self.starts[index] + self.layout.depths[tee], True))
            for begin, end, start, on_branch in spans:
                along = points[:, 0] - start
                here = np.isnan(found[:, 0]) & (along >= begin - _ROUNDING) & (along <= end + _ROUNDING)
                part = self.layout.parts[placed.upstream or 0].part if on_branch else placed.part
                foot, axes = place_on_axis(part, along[here], on_branch)
                found[here] = foot + points[here, 1:] * axes[:, 2]
        return found

    def centres(self) -> FloatArray:
        """Return the centres of all cells on the map, m, (cells, 2): upward first, then along."""
        column, row = np.divmod(np.arange(self.cell_count), self.shape[1])
        return np.column_stack([(column + 0.5) * self.size[0], (row + 0.5 - self.shape[1] / 2) * self.size[1]])

    def find_crossed(self, trajectory: Trajectory) -> tuple[IntArray, FloatArray]:
        """Return the cells that a flight crosses, ascending (k,), and its least distances from their centres, m, (k,).

        The path between samples is their cubic Hermite curve, in straight pieces of a tenth of a cell: each counts for
        the cell of its middle.
        """
        from driftform.motion.path.interpolation import interpolate_positions

        speed = np.linalg.norm(trajectory.velocity[:, :3], axis=1)
        chords = np.linalg.norm(np.diff(trajectory.position, axis=0), axis=1)
        lengths = np.maximum(chords, np.diff(trajectory.t) * np.maximum(speed[1:], speed[:-1]))
        pieces = np.maximum(1, np.ceil(lengths / (_FINE * self.size.min()))).astype(np.int64)
        between = np.concatenate([[0.0], np.cumsum(pieces)])
        points = interpolate_positions(trajectory, np.interp(np.arange(between[-1] + 1), between, trajectory.t))
        place = self._place(points[self.layout.find_part(points) >= 0])
        begin, end = (place[:-1], place[1:]) if len(place) > 1 else (place, place)
        # Where a flight enters a branch, or is outside between two pieces, the map does not go on.
        end = np.where(np.abs(end - begin).max(axis=1, keepdims=True) < 1.0, end, begin)
        middle, way = 0.5 * (begin + end), (end - begin) * self.size
        to_centre = (np.floor(middle) + 0.5 - begin) * self.size
        share = (to_centre * way).sum(axis=1) / np.maximum((way * way).sum(axis=1), 1e-300)
        distance = np.linalg.norm(to_centre - np.clip(share, 0.0, 1.0)[:, None] * way, axis=1)
        cells, nearest = self._cell_at(middle), np.full(self.cell_count, np.inf)
        np.minimum.at(nearest, cells[cells >= 0], distance[cells >= 0])
        found = np.flatnonzero(np.isfinite(nearest))
        return found, nearest[found]

    def _place(self, points: FloatArray) -> FloatArray:
        """Return world points on the map, in sides of a cell from the lower upstream corner, (n, 3)."""
        return np.asarray(self.to_map(points) / self.size + [0.0, self.shape[1] / 2, 0.5])

    def _cell_at(self, place: FloatArray) -> IntArray:
        cell = np.floor(place).astype(np.int64)
        inside = ((cell >= 0) & (cell < (*self.shape, 1))).all(axis=1)
        return np.where(inside, cell[:, 0] * self.shape[1] + cell[:, 1], -1)


def _divide_section(length: float, radius: float, side: float | None) -> tuple[FloatArray, tuple[int, int]]:
    """Return the size of a cell, m, (3,), and the numbers of cells along a section and across it."""
    side = side or max(2 * radius / _ROWS, length / _COLUMNS)
    columns, rows = max(1, round(length / side)), max(1, round(2 * radius / side))
    return np.array([length / columns, 2 * radius / rows, 2 * radius / rows]), (columns, rows)


class CoverageMap:
    """The cells that flights have crossed, and the flight that came closest to the centre of each.

    Attributes:
        cells: the grid.
        distance: least distance from the centre of each cell among the flights that cross it, m, infinite if none
            does, (cells,).
        evaluation: index of that flight's evaluation, -1 if no flight crosses the cell, (cells,); the earliest of
            equals.
        visits: number of flights that cross each cell, (cells,).
        flights, unchecked: number of flights that were added, and of those among them without an estimate of their
            error.
    """

    bounds: ClassVar = BOUNDS

    def __init__(self, cells: PipeGrid) -> None:
        self.cells = cells
        self.distance = np.full(cells.cell_count, np.inf)
        self.evaluation = np.full(cells.cell_count, -1, dtype=np.int64)
        self.visits = np.zeros(cells.cell_count, dtype=np.int64)
        self.flights = self.unchecked = 0

    def add(self, evaluation: int, trajectory: Trajectory) -> IntArray:
        """Add a flight to every cell that it crosses; return the cells in which it is now the closest, (k,)."""
        crossed, distance = self.cells.find_crossed(trajectory)
        self.flights += 1
        self.unchecked += trajectory.error is None
        self.visits[crossed] += 1
        closer = distance < self.distance[crossed]
        taken = crossed[closer]
        self.distance[taken] = distance[closer]
        self.evaluation[taken] = evaluation
        return np.asarray(taken)

    @property
    def reached(self) -> BoolArray:
        """True for the cells that a flight has crossed, (cells,)."""
        return self.visits > 0

    @property
    def classes(self) -> IntArray:
        """How many of :data:`BOUNDS` the distance of each cell reaches, -1 for those that no flight crosses, (cells,)."""
        return np.where(self.reached, np.searchsorted(self.bounds, self.distance, side="right"), -1)


def map_coverage(flights: Iterable[tuple[int, Trajectory]], cells: PipeGrid) -> CoverageMap:
    """Return the coverage of flights, which are pairs of the index of an evaluation and its trajectory."""
    coverage = CoverageMap(cells)
    for evaluation, trajectory in flights:
        coverage.add(evaluation, trajectory)
    return coverage


@dataclass(frozen=True)
class ClosestPass:
    """The closest pass of an evaluation's flight by a point: distance, m, time, s, and whether the flight's error was estimated."""

    evaluation: int
    distance: float
    t: float
    checked: bool


def find_passes(flights: Iterable[tuple[int, Trajectory]], point: Vector) -> list[ClosestPass]:
    """Return the closest pass of each flight by a point of the world, closest first, the earlier of equals first."""
    from driftform.motion.path.approach import closest_approach

    passes, points = [], np.array([point], dtype=np.float64)
    for evaluation, trajectory in flights:
        [distance], [t] = closest_approach(trajectory, points)
        passes.append(ClosestPass(evaluation, float(distance), float(t), trajectory.error is not None))
    return sorted(passes, key=lambda found: found.distance)
