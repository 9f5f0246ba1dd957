"""What the flights of a run reach: a map of cells over the section of a pipe, and how close they come in each."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from driftform.errors import InputError
from driftform.scenario import Scenario, Segment, Vector
from driftform.types import FloatArray, Trajectory

IntArray = npt.NDArray[np.int64]

_ROWS, _COLUMNS = 20, 1000
"""Cells across the pipe, and at most along it, where nothing else is asked for."""


@dataclass(frozen=True, eq=False)
class PipeGrid:
    """Cells over the section of a straight pipe by the vertical plane through its axis.

    A point of the map is its distance along the axis from the upstream end, and its height above the axis, square to
    it. A cell is a box about that plane: it is as deep as it is high, and a flight that passes beside it, where gusts
    have blown the agent out of the plane, does not cross it. Cells are half open, so that each point is in one.

    Attributes
    ----------
    origin
        centre of the pipe's upstream end, m, (3,).
    axes
        unit vectors along the axis, upward and aside, in the world frame, (3, 3). Aside completes a right-handed
        frame as y does with x and z: it is upward x along. Where the pipe is vertical, upward is the world's x.
    size
        of a cell along, upward and aside, m, (3,).
    shape
        how many cells there are along the axis, and across it.
    """

    origin: FloatArray
    axes: FloatArray
    size: FloatArray
    shape: tuple[int, int]

    @classmethod
    def of_segment(cls, segment: Segment, side: float | None = None) -> "PipeGrid":
        """Return the cells that fill the section of a segment, their sides as near to ``side`` (m) as goes.

        Without a side it is a tenth of the radius, and more where there were over a thousand along the pipe.
        """
        start = np.array(segment.start)
        axis = np.subtract(segment.end, segment.start)
        length = float(np.linalg.norm(axis))
        along = axis / length
        upward = np.array([0.0, 0.0, 1.0]) - along[2] * along
        if np.linalg.norm(upward) < 1e-6:
            upward = np.array([1.0, 0.0, 0.0]) - along[0] * along
        upward /= np.linalg.norm(upward)
        side = side or max(2 * segment.radius / _ROWS, length / _COLUMNS)
        columns = max(1, round(length / side))
        rows = max(1, round(2 * segment.radius / side))
        width, height = length / columns, 2 * segment.radius / rows
        axes = np.array([along, upward, np.cross(upward, along)])
        return cls(start, axes, np.array([width, height, height]), (columns, rows))

    @classmethod
    def of(cls, scenario: Scenario, side: float | None = None) -> "PipeGrid":
        """Return the cells of a scenario's pipe, as :meth:`of_segment`.

        Raises
        ------
        InputError
            in open water, which has no section to be filled.
        """
        if not scenario.pipe.segments:
            raise InputError("a map of what flights reach needs a pipe; this scenario is open water")
        [segment] = scenario.pipe.segments
        return cls.of_segment(segment, side)

    @property
    def count(self) -> int:
        """How many cells there are."""
        return self.shape[0] * self.shape[1]

    def to_map(self, points: FloatArray) -> FloatArray:
        """Return world points as distance along, height above and distance beside the axis, m, (n, 3)."""
        return np.asarray((points - self.origin) @ self.axes.T)

    def to_world(self, points: FloatArray) -> FloatArray:
        """Return world points of points on the map, (n, 2) in m; (n, 3)."""
        return np.asarray(self.origin + points @ self.axes[:2])

    def centres(self) -> FloatArray:
        """Return the centres of all cells on the map, m, (cells, 2): upward first, then along."""
        column, row = np.divmod(np.arange(self.count), self.shape[1])
        return np.column_stack(
            [(column + 0.5) * self.size[0], (row + 0.5 - self.shape[1] / 2) * self.size[1]]
        )

    def cell_of(self, points: FloatArray) -> IntArray:
        """Return the cell that each world point (n, 3) is in, -1 for none, (n,)."""
        place = np.floor(self._scale(points, offset=True)).astype(np.int64)
        inside = ((place >= 0) & (place < (*self.shape, 1))).all(axis=1)
        return np.where(inside, place[:, 0] * self.shape[1] + place[:, 1], -1)

    def find_crossed(self, trajectory: Trajectory) -> tuple[IntArray, FloatArray]:
        """Return the cells that a flight crosses, (k,) and ascending, and how close it comes to their centres, m, (k,).

        The path between samples is their cubic Hermite curve. It is cut where it crosses the sides of cells; the
        distance is that of the nearest point of the parts inside a cell.
        """
        from driftform.trajectory.crossing import cross_cells
        from driftform.trajectory.path import world_velocity

        place = self._scale(trajectory.position, offset=True)
        nearest = np.full(self.count, np.inf)
        if len(trajectory.t) == 1:
            cells = self.cell_of(trajectory.position)
            offset = (place - np.floor(place) - 0.5) * self.size
            nearest[cells[cells >= 0]] = np.linalg.norm(offset, axis=1)[cells >= 0]
        else:
            rate = self._scale(world_velocity(trajectory), offset=False)
            cross_cells(trajectory.t, place, rate, self.size, self.shape, nearest)
        found = np.flatnonzero(np.isfinite(nearest))
        return found, nearest[found]

    def _scale(self, vectors: FloatArray, offset: bool) -> FloatArray:
        """World points (or velocities) on the map, in sides of a cell from its lower upstream corner, (n, 3)."""
        to_cells = self.axes.T / self.size
        scaled = vectors @ to_cells
        if offset:
            scaled += np.array([0.0, self.shape[1] / 2, 0.5]) - self.origin @ to_cells
        return np.asarray(scaled)


class CoverageMap:
    """The cells that flights have crossed so far, and the flight that came closest to the centre of each.

    Attributes
    ----------
    cells
        the map.
    distance
        closest approach to the centre of each cell among the flights that cross it, m, infinite where none does,
        (cells,).
    evaluation
        which flight that was, -1 where none, (cells,); the earliest of equals.
    visits
        how many flights cross each cell, (cells,).
    flights
        how many flights there were.
    """

    def __init__(self, cells: PipeGrid) -> None:
        self.cells = cells
        self.distance = np.full(cells.count, np.inf)
        self.evaluation = np.full(cells.count, -1, dtype=np.int64)
        self.visits = np.zeros(cells.count, dtype=np.int64)
        self.flights = 0

    def add(self, evaluation: int, trajectory: Trajectory) -> IntArray:
        """Credit a flight with every cell that it crosses; return those where it is the closest now, (k,)."""
        crossed, distance = self.cells.find_crossed(trajectory)
        self.flights += 1
        self.visits[crossed] += 1
        closer = distance < self.distance[crossed]
        taken = crossed[closer]
        self.distance[taken] = distance[closer]
        self.evaluation[taken] = evaluation
        return np.asarray(taken)

    @property
    def reached(self) -> npt.NDArray[np.bool_]:
        """Which cells a flight has crossed, (cells,)."""
        return self.visits > 0


def map_coverage(flights: Iterable[tuple[int, Trajectory]], cells: PipeGrid) -> CoverageMap:
    """Return the map of flights, each with the index of its evaluation."""
    reach = CoverageMap(cells)
    for evaluation, flight in flights:
        reach.add(evaluation, flight)
    return reach


@dataclass(frozen=True)
class ClosestPass:
    """Where a flight comes closest to a point: which ``evaluation``, at what ``distance`` (m), when (``t``, s)."""

    evaluation: int
    distance: float
    t: float


def find_closest_pass(flights: Iterable[tuple[int, Trajectory]], point: Vector) -> ClosestPass | None:
    """Return the closest of all flights to a point of the world, the earliest of equals; ``None`` without any."""
    from driftform.trajectory.path import closest_approach

    best: ClosestPass | None = None
    points = np.array([point], dtype=np.float64)
    for evaluation, flight in flights:
        [distance], [t] = closest_approach(flight, points)
        if best is None or distance < best.distance:
            best = ClosestPass(evaluation, float(distance), float(t))
    return best
