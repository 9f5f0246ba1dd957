"""The wall of a tee or a wye: a level set of two bores whose edge is rounded.

Local frame of the part: the origin is where the two axes meet, x points downstream along the run (radius R), the branch (radius r)
leaves along d = (cos A, 0, sin A). With a and b the distances of a point beyond the two bores, the wall is where::

    G = f - sqrt((f - a)^2 + (f - b)^2)    if a < f and b < f;    G = min(a, b)    elsewhere

is zero: the edge between the bores is rounded with the radius f, tangentially to both, and exactly so where the bores meet at a
right angle. G is negative in the water. The branch begins at the axis of the run: behind it, b grows.
"""

import math

from driftform.dynamics.vectors import ZERO, Vector, add, dot, scale, subtract
from driftform.util.compiled import compiled

CLOSING = 2.0
"""Factor of t^2 / r, by which b grows at the distance t behind the run's axis."""


@compiled
def tee_level(point: Vector, R: float, r: float, cosine: float, sine: float, f: float) -> tuple[float, Vector]:
    """Return G (m) at a point of the local frame (m), and its gradient; G over the gradient's length is the depth in the wall.

    Parameters
    ----------
    R, r
        radii of run and branch, m.
    cosine, sine
        of the angle A between the run's downstream axis and the branch.
    f
        radius of the rounded edge, m.
    """
    a, toward_a = _beyond_bore(point, (1.0, 0.0, 0.0), R)
    d = (cosine, 0.0, sine)
    b, toward_b = _beyond_bore(point, d, r)
    t = dot(point, d)
    if t < 0.0:
        b, toward_b = b + CLOSING * t * t / r, add(toward_b, scale(2.0 * CLOSING * t / r, d))
    if a >= f or b >= f:
        return (a, toward_a) if a < b else (b, toward_b)
    h = math.sqrt((f - a) ** 2 + (f - b) ** 2)
    return f - h, add(scale((f - a) / h, toward_a), scale((f - b) / h, toward_b))


@compiled
def _beyond_bore(point: Vector, axis: Vector, radius: float) -> tuple[float, Vector]:
    """Return how far (m) a point lies beyond the bore about ``axis`` through the origin, and the unit vector outward."""
    off = subtract(point, scale(dot(point, axis), axis))
    distance = math.sqrt(dot(off, off))
    return distance - radius, scale(1.0 / distance, off) if distance > 0.0 else ZERO
