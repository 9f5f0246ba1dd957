"""Rims and domes of a body of revolution against the wall of a pipe with parts.

A dome touches where its centre is nearest to the wall. A rim touches where its point in the wall is deepest: there the wall's
normal has no component along the rim. The angle around the rim at which that is so is found by the secant method.

The wall of a fitting may bulge into the water, and touch the flank of a body between two corners of its contour: such bodies have
additional rims (:func:`driftform.dynamics.surfaces.refined_surfaces`).
"""

import math

from driftform.dynamics.bore import ANGLE_TOLERANCE, end_of_dome, smoothed_sine
from driftform.dynamics.fitting_walls import KIND, TEE, fitting_gap
from driftform.dynamics.vectors import ZERO, Vector, add, cross, dot, scale, subtract
from driftform.types import FloatArray
from driftform.util.compiled import compiled

LOOKS = 8
"""Points of a rim at which it is first compared with the wall of a tee, whose edges have more than one nearest point."""

MOST_ROUNDS = 12
"""Most steps of the search for the deepest point of a rim; two or three are usual."""

LONGEST_TURN = 0.7
"""Largest step of that search, rad."""


@compiled
def touch_fitting(
    position: Vector, axis: Vector, surfaces: FloatArray, k: int, f: FloatArray
) -> tuple[float, Vector, Vector, float, float]:
    """Return how surface ``k`` touches the wall: see ``Touch`` of :mod:`driftform.dynamics.contact`."""
    x, r, radius = surfaces[k, 0], surfaces[k, 1], surfaces[k, 2]
    centre = add(position, scale(x, axis))
    gap, normal, o = fitting_gap(centre, f)
    if gap > r + radius:
        return 0.0, ZERO, ZERO, x, r
    if radius > 0.0:
        s = dot(axis, normal)
        if surfaces[k, 3] <= s <= surfaces[k, 4]:
            return max(0.0, radius - gap), add(scale(x, axis), scale(radius, normal)), normal, x, 0.0
        x, r = end_of_dome(surfaces, k, s)
        centre = add(position, scale(x, axis))
        gap, normal, o = fitting_gap(centre, f)
    if r == 0.0:
        return max(0.0, -gap), scale(x, axis), normal, x, r
    if f[o + KIND] == TEE:
        normal = _nearest_look(centre, axis, r, normal, f)
    gap, point, normal = deepest_rim_point(centre, axis, r, normal, f)
    return max(0.0, -gap), subtract(point, position), normal, x, r


@compiled
def _nearest_look(centre: Vector, axis: Vector, r: float, normal: Vector, f: FloatArray) -> Vector:
    """Return the normal of the wall at the deepest of some points of a rim."""
    u, v = _across(axis, normal)
    best = math.inf
    for i in range(LOOKS):
        angle = 2.0 * math.pi * i / LOOKS
        arm = add(scale(r * math.cos(angle), u), scale(r * math.sin(angle), v))
        gap, there, _ = fitting_gap(add(centre, arm), f)
        if gap < best:
            best, normal = gap, there
    return normal


@compiled
def _across(axis: Vector, normal: Vector) -> tuple[Vector, Vector]:
    """Return two unit vectors across ``axis``, the first in its plane with ``normal``."""
    s = dot(axis, normal)
    u = subtract(normal, scale(s, axis))
    square = dot(u, u)
    if square < 1e-12:
        other = (1.0, 0.0, 0.0) if abs(axis[0]) < 0.7 else (0.0, 1.0, 0.0)
        u = cross(axis, other)
        square = dot(u, u)
    u = scale(1.0 / math.sqrt(square), u)
    return u, cross(axis, u)


@compiled
def deepest_rim_point(
    centre: Vector, axis: Vector, r: float, normal: Vector, f: FloatArray
) -> tuple[float, Vector, Vector]:
    """Return the gap (m) of the deepest point of a rim, that point (m), and the wall's normal there.

    The search begins along ``normal``. A rim that lies flat against the wall touches with less than its radius: see
    :data:`driftform.dynamics.bore.SINE_SMOOTHING`.
    """
    u, v = _across(axis, normal)
    angle, before, turn_before = 0.0, 0.0, 0.0
    gap, point = 0.0, centre
    for i in range(MOST_ROUNDS):
        c, s = math.cos(angle), math.sin(angle)
        sine = dot(axis, normal)
        reach = r * math.sqrt(max(0.0, 1.0 - sine * sine)) / smoothed_sine(sine)
        point = add(centre, add(scale(reach * c, u), scale(reach * s, v)))
        gap, normal, _ = fitting_gap(point, f)
        radial = c * dot(normal, u) + s * dot(normal, v)
        around = c * dot(normal, v) - s * dot(normal, u)
        turn = math.atan2(around, radial)
        if abs(turn) < ANGLE_TOLERANCE:
            break
        step = turn
        if i > 0 and abs(turn_before - turn) > 1e-3 * abs(turn):
            step = turn * (angle - before) / (turn_before - turn)
        before, turn_before = angle, turn
        angle += min(LONGEST_TURN, max(-LONGEST_TURN, step))
    return gap, point, normal
