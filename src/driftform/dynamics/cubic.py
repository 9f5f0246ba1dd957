"""Cubic curves between two samples: compiled kernels."""

from typing import TypeAlias

import numpy as np

from driftform.dynamics.vectors import Vector, add, dot, scale, subtract
from driftform.util.compiled import compiled

Cubic: TypeAlias = tuple[Vector, Vector, Vector, Vector]
"""A polynomial, lowest power first."""


@compiled
def cubic_between(p: Vector, v: Vector, q: Vector, w: Vector, h: float) -> Cubic:
    """Return the cubic in u from 0 to 1 that leads from p with the rate v to q with the rate w, in the time h."""
    m, n, chord = scale(h, v), scale(h, w), subtract(q, p)
    return p, m, subtract(scale(3.0, chord), add(scale(2.0, m), n)), subtract(add(m, n), scale(2.0, chord))


@compiled
def _distance(a: Vector, b: Vector) -> float:
    offset = subtract(a, b)
    return float(np.sqrt(dot(offset, offset)))


@compiled
def at(cubic: Cubic, u: float) -> Vector:
    """Return the point of a cubic at u."""
    a, b, c, d = cubic
    return add(a, scale(u, add(b, scale(u, add(c, scale(u, d))))))


@compiled
def rate_at(cubic: Cubic, u: float) -> Vector:
    """Return the slope of a cubic at u, for a unit of u."""
    _, b, c, d = cubic
    return add(b, scale(u, add(scale(2.0, c), scale(3.0 * u, d))))


@compiled
def foot(cubic: Cubic, point: Vector, u: float) -> tuple[float, float]:
    """Return the distance of the foot of the perpendicular, or of an end, and its u: Newton's method from ``u``."""
    _, _, c, d = cubic
    best, best_u = _distance(at(cubic, u), point), u
    for _ in range(20):
        offset = subtract(at(cubic, u), point)
        first = rate_at(cubic, u)
        second = add(scale(2.0, c), scale(6.0 * u, d))
        speed = dot(first, first)
        curvature = speed + dot(offset, second)
        if curvature <= 0.0:
            # Where the distance is not convex Newton's step would climb: step as if the path were straight.
            curvature = speed
        if curvature == 0.0:
            break
        new = min(1.0, max(0.0, u - dot(offset, first) / curvature))
        distance = _distance(at(cubic, new), point)
        if distance < best:
            best, best_u = distance, new
        if abs(new - u) < 1e-12:
            break
        u = new
    return best, best_u
