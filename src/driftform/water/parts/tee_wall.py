"""The wall of a tee or wye: two round bores, their edge rounded by a ball that rolls along both.

All lengths are in units of the radius of the run, the bore that passes through. The axes meet at the origin; x runs along
the run, and the branch leaves along (cos A, 0, sin A), A up to 90 degrees. The wall is symmetric about y = 0.
"""

import math
from dataclasses import dataclass

import numpy as np

from driftform.types import FloatArray
from driftform.util.compiled import compiled
from driftform.util.small_vectors import Vector
from driftform.water.parts import walls
from driftform.water.parts.walls import EDGE, EDGE_POINTS, PART, RADIUS, edge_point, gap_in_tee, nearest_on_edge

__all__ = ["COSINE", "DOWNSTREAM", "END_RADIUS", "FILLET", "SIDE", "SINE", "UPSTREAM"]
__all__ += ["Junction", "nearest_on_edge", "wall_level"]

# Indices in a row.
COSINE, SINE, END_RADIUS, FILLET = walls.COSINE, walls.SINE, walls.END_RADIUS, walls.FILLET
UPSTREAM, DOWNSTREAM, SIDE = walls.UPSTREAM, walls.DOWNSTREAM, walls.SIDE

REACH = 3.0
"""Length of each leg beyond the rounded edge, in its own radii, or a little more."""

CELLS = 6.0
"""Widths of the finest cells in the radius of the fillet."""


@dataclass(frozen=True)
class Junction:
    """The shape of a tee or wye.

    Attributes:
        branch: radius of the branch, at most 1.
        angle: A, rad.
        fillet: radius of the ball that rounds the edge.
    """

    branch: float
    angle: float
    fillet: float

    @property
    def finest(self) -> float:
        """Width of the finest cells."""
        return self.fillet / CELLS

    @property
    def width(self) -> float:
        """Width of the coarsest cells, 0.2 to 0.4: a power of two times that of the finest. The ends are at multiples of it."""
        return self.finest * 2.0 ** math.floor(math.log2(0.4 / self.finest))

    def array(self) -> FloatArray:
        """Return the wall as a row of :mod:`driftform.water.parts.walls`, whose ends are those of the grid, (PART,)."""
        c, s, rho = math.cos(self.angle), math.sin(self.angle), self.branch + self.fillet
        c, w = 0.0 if abs(c) < 1e-12 else c, self.width
        along = (1 + self.fillet) * c
        row = np.zeros(PART)
        row[COSINE], row[SINE], row[RADIUS], row[END_RADIUS], row[FILLET] = c, s, 1.0, self.branch, self.fillet
        row[UPSTREAM] = -math.floor(((along - rho) / s - REACH) / w) * w
        row[DOWNSTREAM] = math.ceil(((along + rho) / s + REACH) / w) * w
        row[SIDE] = math.ceil(((1 + self.fillet + rho * c) / s + REACH * self.branch) / w) * w
        return fill_edge(row)


def fill_edge(row: FloatArray) -> FloatArray:
    """Write the points of the rounded edge of a tee to its row, and return it."""
    edge = [edge_point(float(phi), row, 0)[0] for phi in np.linspace(0, math.pi, EDGE_POINTS)]
    row[EDGE : EDGE + 3 * EDGE_POINTS] = np.ravel(edge)
    return row


@compiled
def wall_level(x: float, y: float, z: float, wall: FloatArray) -> tuple[float, Vector]:
    """Return the distance from the wall, negative in the water, and the unit vector towards the wall."""
    gap, normal = gap_in_tee((x, y, z), wall, 0)
    return -gap, normal
