"""Cubic curves in space: compiled kernels to make one, to evaluate it and to find its nearest point."""

from typing import TypeAlias

from driftform.util.compiled import compiled
from driftform.util.small_vectors import Vector, add, distance_between, dot, scale, subtract

Cubic: TypeAlias = tuple[Vector, Vector, Vector, Vector]
"""Coefficients of a polynomial in u, lowest power first."""


@compiled
def cubic_between(p: Vector, v: Vector, q: Vector, w: Vector, h: float) -> Cubic:
    """Return the cubic in u, 0 to 1, from the point p with velocity v to the point q with velocity w, in the time h."""
    m, n, chord = scale(h, v), scale(h, w), subtract(q, p)
    return p, m, subtract(scale(3.0, chord), add(scale(2.0, m), n)), subtract(add(m, n), scale(2.0, chord))


@compiled
def cubic_point(cubic: Cubic, u: float) -> Vector:
    """Return the point of a cubic at u."""
    a, b, c, d = cubic
    return add(a, scale(u, add(b, scale(u, add(c, scale(u, d))))))


@compiled
def cubic_slope(cubic: Cubic, u: float) -> Vector:
    """Return the derivative of a cubic with respect to u, at u."""
    _, b, c, d = cubic
    return add(b, scale(u, add(scale(2.0, c), scale(3.0 * u, d))))


@compiled
def nearest_on_cubic(cubic: Cubic, point: Vector, u: float) -> tuple[float, float]:
    """Return the distance from ``point`` to the nearest point of a cubic, and that point's u.

    Newton's method starts at ``u`` and finds the foot of the perpendicular, or an end of the cubic.
    """
    _, _, c, d = cubic
    best, best_u = distance_between(cubic_point(cubic, u), point), u
    for _ in range(20):
        offset = subtract(cubic_point(cubic, u), point)
        first = cubic_slope(cubic, u)
        second = add(scale(2.0, c), scale(6.0 * u, d))
        speed = dot(first, first)
        curvature = speed + dot(offset, second)
        if curvature <= 0.0:
            # If the distance is not convex, Newton's step would climb: step as if the path were straight.
            curvature = speed
        if curvature == 0.0:
            break
        new = min(1.0, max(0.0, u - dot(offset, first) / curvature))
        distance = distance_between(cubic_point(cubic, new), point)
        if distance < best:
            best, best_u = distance, new
        if abs(new - u) < 1e-12:
            break
        u = new
    return best, best_u
