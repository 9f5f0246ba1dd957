"""Coverage: the cells of a pipe's section that flights cross, and the closest pass in each."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from driftform.errors import InputError
from driftform.scenario import Scenario, Segment, Vector
from driftform.types import FloatArray, Trajectory

IntArray = npt.NDArray[np.int64]

_ROWS, _COLUMNS = 20, 1000
"""Default number of cells across the pipe, and greatest default number along it."""


@dataclass(frozen=True, eq=False)
class PipeGrid:
    """Grid of cells over a straight pipe's section in the vertical plane through its axis.

    The coordinates on the map are the distance along the axis from the upstream end, and the height above the axis,
    perpendicular to it. A cell is a box centred on that plane, as deep as it is high: a flight that passes beside it,
    because gusts have blown the agent out of the plane, does not cross it. Cells are half open, so that each point is in
    exactly one.

    Attributes
    ----------
    origin
        centre of the pipe's upstream end, m, (3,).
    axes
        unit vectors along the axis, upward and aside, in the world frame, (3, 3). Aside completes a right-handed
        frame as y does with x and z: it is upward x along. In a vertical pipe, upward is the world's x.
    size
        of a cell along, upward and aside, m, (3,).
    shape
        number of cells along the axis, and across it.
    """

    origin: FloatArray
    axes: FloatArray
    size: FloatArray
    shape: tuple[int, int]

    @classmethod
    def of_segment(cls, segment: Segment, side: float | None = None) -> "PipeGrid":
        """Return the grid of a segment's section; the sides of its cells are as close to ``side`` (m) as possible.

        The default side is a tenth of the radius, or more, so that there are at most 1000 cells along the pipe.
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
    def of_scenario(cls, scenario: Scenario, side: float | None = None) -> "PipeGrid":
        """Return the grid of a scenario's pipe; see :meth:`of_segment`.

        Raises
        ------
        InputError
            if the scenario is open water, which has no section.
        """
        if not scenario.pipe.segments:
            raise InputError("a map of what flights reach needs a pipe; this scenario is open water")
        [segment] = scenario.pipe.segments
        return cls.of_segment(segment, side)

    @property
    def cell_count(self) -> int:
        """Number of cells."""
        return self.shape[0] * self.shape[1]

    def to_map(self, points: FloatArray) -> FloatArray:
        """Return world points (n, 3) as distance along, height above and distance beside the axis, m, (n, 3)."""
        return np.asarray((points - self.origin) @ self.axes.T)

    def to_world(self, points: FloatArray) -> FloatArray:
        """Return the world points (n, 3) of points on the map (n, 2), m."""
        return np.asarray(self.origin + points @ self.axes[:2])

    def centres(self) -> FloatArray:
        """Return the centres of all cells on the map, m, (cells, 2): upward first, then along."""
        column, row = np.divmod(np.arange(self.cell_count), self.shape[1])
        return np.column_stack(
            [(column + 0.5) * self.size[0], (row + 0.5 - self.shape[1] / 2) * self.size[1]]
        )

    def cell_of(self, points: FloatArray) -> IntArray:
        """Return the cell that contains each world point (n, 3), or -1, (n,)."""
        place = np.floor(self._scale(points, offset=True)).astype(np.int64)
        inside = ((place >= 0) & (place < (*self.shape, 1))).all(axis=1)
        return np.where(inside, place[:, 0] * self.shape[1] + place[:, 1], -1)

    def find_crossed(self, trajectory: Trajectory) -> tuple[IntArray, FloatArray]:
        """Return the cells that a flight crosses, ascending (k,), and its least distances from their centres, m, (k,).

        The path between samples is their cubic Hermite curve. It is cut where it crosses the sides of cells; the
        distance in a cell is that of the nearest point of the parts inside it.
        """
        from driftform.trajectory.crossing import lower_distances
        from driftform.trajectory.path import world_velocity

        place = self._scale(trajectory.position, offset=True)
        nearest = np.full(self.cell_count, np.inf)
        if len(trajectory.t) == 1:
            cells = self.cell_of(trajectory.position)
            offset = (place - np.floor(place) - 0.5) * self.size
            nearest[cells[cells >= 0]] = np.linalg.norm(offset, axis=1)[cells >= 0]
        else:
            rate = self._scale(world_velocity(trajectory), offset=False)
            lower_distances(trajectory.t, place, rate, self.size, self.shape, nearest)
        found = np.flatnonzero(np.isfinite(nearest))
        return found, nearest[found]

    def _scale(self, vectors: FloatArray, offset: bool) -> FloatArray:
        """Return world points (or velocities) on the map, in sides of a cell from the lower upstream corner, (n, 3)."""
        to_cells = self.axes.T / self.size
        scaled = vectors @ to_cells
        if offset:
            scaled += np.array([0.0, self.shape[1] / 2, 0.5]) - self.origin @ to_cells
        return np.asarray(scaled)


class CoverageMap:
    """The cells that flights have crossed, and the flight that came closest to the centre of each.

    Attributes
    ----------
    cells
        the grid.
    distance
        least distance from the centre of each cell among the flights that cross it, m, infinite if none does,
        (cells,).
    evaluation
        index of that flight's evaluation, -1 if no flight crosses the cell, (cells,); the earliest of equals.
    visits
        number of flights that cross each cell, (cells,).
    flights, unchecked
        number of flights that were added, and of those among them without an estimate of their error.
    """

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
    def reached(self) -> npt.NDArray[np.bool_]:
        """True for the cells that a flight has crossed, (cells,)."""
        return self.visits > 0


def map_coverage(flights: Iterable[tuple[int, Trajectory]], cells: PipeGrid) -> CoverageMap:
    """Return the coverage of flights, which are pairs of the index of an evaluation and its trajectory."""
    coverage = CoverageMap(cells)
    for evaluation, trajectory in flights:
        coverage.add(evaluation, trajectory)
    return coverage


@dataclass(frozen=True)
class ClosestPass:
    """The closest pass of a flight by a point.

    Attributes
    ----------
    evaluation
        index of the flight's evaluation.
    distance, t
        distance from the point, m, and time, s.
    checked
        whether the error of the flight was estimated.
    """

    evaluation: int
    distance: float
    t: float
    checked: bool


def find_passes(flights: Iterable[tuple[int, Trajectory]], point: Vector) -> list[ClosestPass]:
    """Return the closest pass of each flight by a point of the world, closest first, the earlier of equals first."""
    from driftform.trajectory.approach import closest_approach

    passes, points = [], np.array([point], dtype=np.float64)
    for evaluation, trajectory in flights:
        [distance], [t] = closest_approach(trajectory, points)
        passes.append(ClosestPass(evaluation, float(distance), float(t), trajectory.error is not None))
    return sorted(passes, key=lambda found: found.distance)
