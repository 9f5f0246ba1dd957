"""The wall of a tee or wye: two round bores, their edge rounded by a ball that rolls along both.

All lengths are in units of the radius of the run, the bore that passes through. The axes meet at the origin; x runs along
the run, and the branch leaves along (cos A, 0, sin A), A up to 90 degrees. The wall is symmetric about y = 0.
"""

import math
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from driftform.types import FloatArray
from driftform.util.compiled import compiled

COSINE, SINE, BRANCH, FILLET, INLET, OUTLET, END = range(7)
"""Indices in the array of a wall: cosine and sine of A, radius of the branch, fillet, and the planes of the ends."""

REACH = 3.0
"""Length of each leg beyond the rounded edge, in its own radii, or a little more."""

CELLS = 6.0
"""Widths of the finest cells in the radius of the fillet."""

Point: TypeAlias = tuple[float, float, float]
"""A point of the frame of a tee, m."""


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
        """Return the wall as the kernels read it, (7,)."""
        c, s, rho = math.cos(self.angle), math.sin(self.angle), self.branch + self.fillet
        c, w = 0.0 if abs(c) < 1e-12 else c, self.width
        along = (1 + self.fillet) * c
        inlet = math.floor(((along - rho) / s - REACH) / w) * w
        outlet = math.ceil(((along + rho) / s + REACH) / w) * w
        end = math.ceil(((1 + self.fillet + rho * c) / s + REACH * self.branch) / w) * w
        return np.array([c, s, self.branch, self.fillet, inlet, outlet, end])


@compiled
def wall_level(x: float, y: float, z: float, wall: FloatArray) -> tuple[float, Point]:
    """Return the distance from the wall, negative in the water, and the unit vector towards the wall.

    Far from the wall the first number is only some negative number.
    """
    a = math.sqrt(y * y + z * z) - 1.0
    t = x * wall[COSINE] + z * wall[SINE]
    across = x * wall[SINE] - z * wall[COSINE]
    b = math.sqrt(across * across + y * y) - wall[BRANCH]
    if t < 0.0:
        # The branch begins at the origin: its level grows beyond it.
        b += 2.0 * t * t / wall[BRANCH]
    f = wall[FILLET]
    if min(a, b) > -f and max(a, b) < 2.0 * f:
        cx, cy, cz = nearest_centre(x, abs(y), z, math.atan2(abs(y), across), wall)
        vx, vy, vz = x - cx, abs(y) - cy, z - cz
        distance = math.sqrt(vx * vx + vy * vy + vz * vz)
        if _is_faced(cx, cy, cz, vx, vy, vz, distance, wall):
            return f - distance, (-vx / distance, -vy / distance if y >= 0.0 else vy / distance, -vz / distance)
    if a < b:
        return a, (0.0, y / (a + 1.0), z / (a + 1.0))
    r = math.sqrt(across * across + y * y)
    return b, (wall[SINE] * across / r, y / r, -wall[COSINE] * across / r)


@compiled
def ball_centre(phi: float, wall: FloatArray) -> Point:
    """Return the centre of the ball at the angle ``phi`` about the branch's axis, 0 on the downstream side."""
    rho, c, s = wall[BRANCH] + wall[FILLET], wall[COSINE], wall[SINE]
    near, aside = rho * math.cos(phi), rho * math.sin(phi)
    t = (math.sqrt(max(0.0, (1.0 + wall[FILLET]) ** 2 - aside * aside)) + near * c) / s
    return t * c + near * s, aside, t * s - near * c


@compiled
def _is_faced(cx: float, cy: float, cz: float, vx: float, vy: float, vz: float, size: float, wall: FloatArray) -> bool:
    """Return True if the direction v from the ball's centre c lies between those to the points where it touches the bores."""
    rho, t = wall[BRANCH] + wall[FILLET], cx * wall[COSINE] + cz * wall[SINE]
    ny, nz = -cy / (1.0 + wall[FILLET]), -cz / (1.0 + wall[FILLET])
    mx, my, mz = (t * wall[COSINE] - cx) / rho, -cy / rho, (t * wall[SINE] - cz) / rho
    least = (ny * my + nz * mz) * size - 1e-9
    return bool(size > 0.0 and ny * vy + nz * vz >= least and mx * vx + my * vy + mz * vz >= least)


@compiled
def nearest_centre(x: float, y: float, z: float, phi: float, wall: FloatArray) -> Point:
    """Return the centre of the ball that is nearest to the point, by Newton's method in a bracket about ``phi``."""
    rho, c, s, bore = wall[BRANCH] + wall[FILLET], wall[COSINE], wall[SINE], 1.0 + wall[FILLET]
    t, across = x * c + z * s, x * s - z * c
    low, high = phi - 0.5, phi + 0.5
    for _ in range(50):
        # Along the branch, across it, and along y: from the centre to the point, and the centre's derivatives.
        cos, sin = math.cos(phi), math.sin(phi)
        root = math.sqrt(max(1e-12, bore * bore - (rho * sin) ** 2))
        first = -rho * rho * sin * cos / root
        second = -(rho * rho * (cos * cos - sin * sin) + first * first) / root
        u, v, w = t - (root + rho * cos * c) / s, across - rho * cos, y - rho * sin
        du, dv, dw = (first - rho * sin * c) / s, -rho * sin, rho * cos
        slope = -(u * du + v * dv + w * dw)
        bend = du * du + dv * dv + dw * dw - u * (second - rho * cos * c) / s + v * rho * cos + w * rho * sin
        if slope < 0.0:
            low = phi
        else:
            high = phi
        new = phi - slope / bend if bend > 0.0 else np.inf
        if not low < new < high:
            new = 0.5 * (low + high)
        if abs(new - phi) < 1e-11:
            break
        phi = new
    return ball_centre(phi, wall)
