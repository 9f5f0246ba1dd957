"""Rims and domes of a body of revolution against the wall of a pipe with parts.

A dome touches where its centre is nearest to the wall. A rim touches where its point in the wall is deepest: there the wall's
normal has no component along the rim. The angle around the rim at which that is so is found by the secant method.

The wall of a fitting may bulge into the water, and touch the flank of a body between two corners of its contour: such bodies have
additional rims (:func:`driftform.motion.forces.surfaces.refined_surfaces`).
"""

import math

from driftform.motion.forces.bore import ANGLE_TOLERANCE, AxisLine, end_of_dome
from driftform.types import FloatArray
from driftform.util.compiled import compiled
from driftform.util.small_vectors import ZERO, Vector, add, cross, dot, scale, subtract
from driftform.water.parts.walls import (
    KIND,
    LENGTH,
    RADIUS,
    STRAIGHT,
    TEE,
    find_part,
    fitting_gap,
    to_part,
    turn_to_part,
)

FLATNESS = 1.5
"""Sine of the tilt from upright below which a rim counts as flat, over the rim's radius times the wall's curvature; with 1.5, its reach
grows so slowly that it has one deepest point."""

MAX_STANDOFF = 0.375 * FLATNESS
"""Greatest standoff of a rim over the fall of the bore within its radius."""

MAX_FLAT = 0.7
"""Greatest sine of the tilt at which a rim counts as flat: a body that lies along the pipe touches with its rims."""

LOOKS = 8
"""Points of a rim at which it is first compared with the wall of a tee, whose edges have more than one nearest point."""

MAX_ROUNDS = 12
"""Most steps of the search for the deepest point of a rim; two or three are usual."""

LONGEST_TURN = 0.7
"""Largest step of that search, rad."""


@compiled
def line_in_straight(position: Vector, axis: Vector, reach: float, f: FloatArray) -> AxisLine:
    """Return the position of a body's axis in the straight that holds all within ``reach`` (m) of it; zeros elsewhere."""
    o, _ = find_part(position, f)
    p, along = to_part(position, f, o), turn_to_part(axis, f, o)
    if f[o + KIND] != STRAIGHT or not reach < p[0] < f[o + LENGTH] - reach:
        return 0.0, 0.0, 0.0, 0.0
    across, turned = p[1] * along[1] + p[2] * along[2], along[1] * along[1] + along[2] * along[2]
    return p[1] * p[1] + p[2] * p[2], across, turned, f[o + RADIUS]


@compiled
def touch_fitting(
    position: Vector, axis: Vector, surfaces: FloatArray, k: int, f: FloatArray
) -> tuple[float, Vector, Vector, float, float]:
    """Return how surface ``k`` touches the wall: see ``Touch`` of :mod:`driftform.motion.forces.contact`.

    The depth of a surface that is clear is negative, and not less than minus its distance from the wall.
    """
    x, r, radius = surfaces[k, 0], surfaces[k, 1], surfaces[k, 2]
    centre = add(position, scale(x, axis))
    gap, normal, o = fitting_gap(centre, f)
    if gap > r + radius:
        return r + radius - gap, ZERO, ZERO, x, r
    if radius > 0.0:
        s = dot(axis, normal)
        if surfaces[k, 3] <= s <= surfaces[k, 4]:
            return radius - gap, add(scale(x, axis), scale(radius, normal)), normal, x, 0.0
        x, r = end_of_dome(surfaces, k, s)
        centre = add(position, scale(x, axis))
        gap, normal, o = fitting_gap(centre, f)
    if r == 0.0:
        return -gap, scale(x, axis), normal, x, r
    flat = flat_tilt(r, surfaces, k)
    angle = _nearest_look(centre, axis, r, normal, f) if f[o + KIND] == TEE else 0.0
    gap, point, normal = deepest_rim_point(centre, axis, r, flat, normal, angle, f)
    return -gap, subtract(point, position), normal, x, r


@compiled
def _nearest_look(centre: Vector, axis: Vector, r: float, normal: Vector, f: FloatArray) -> float:
    """Return the angle of the deepest of some points of a rim, from the direction of ``normal``, rad."""
    u, v = _across(axis, normal)
    best, found = math.inf, 0.0
    for i in range(LOOKS):
        angle = 2.0 * math.pi * i / LOOKS
        arm = add(scale(r * math.cos(angle), u), scale(r * math.sin(angle), v))
        gap, _, _ = fitting_gap(add(centre, arm), f)
        if gap < best:
            best, found = gap, angle
    return found


@compiled
def flat_tilt(r: float, surfaces: FloatArray, k: int) -> float:
    """Return the sine of the tilt from upright below which a rim of radius ``r`` (m) of a surface counts as flat: see :func:`rim_reach`.

    It is that of the most curved part of the pipe everywhere: the depth of a body must not jump where it enters a part.
    """
    whole = surfaces[k, 1] + surfaces[k, 2]
    return float(min(MAX_FLAT, FLATNESS * r * surfaces[k, 5] / (whole * whole)))


@compiled
def rim_reach(r: float, c: float, flat: float) -> tuple[float, float]:
    """Return how far from its centre a rim of radius ``r`` touches, and how much further the wall is kept off there, m.

    A flat end in a bore of radius R touches the wall with two opposite points of its rim. A small tilt moves the
    load from one to the other, and a single deepest point would jump. Instead the point moves steadily from the centre of the end
    to its rim, while c, the sine of the tilt from upright, grows to ``flat``, 3/2 r / R. With t = c / flat::

        reach = r t (3 - t^2) / 2        standoff = 3/8 r flat (1 - t^2)^2

    The depth of a rim in a flat wall, reach c + standoff, has the derivative ``reach``, so that forces do no work in
    a cycle. In the bore it is within r^2 / (16 R) of the true one, r^2 / (2 R) + c^2 R / 2 for c < r / R, and r c for c > ``flat``.
    """
    if c >= flat:
        return r, 0.0
    t = c / flat
    square = 1.0 - t * t
    return 0.5 * r * t * (3.0 - t * t), 0.375 * r * flat * square * square


@compiled
def flat_curvatures(r: float, c: float, flat: float) -> tuple[float, float]:
    """Return the curvatures (m) of the depth of a rim along its tilt and across it; see :func:`rim_reach`."""
    if c >= flat:
        return 0.0, r / c if c > 0.0 else 0.0
    t = c / flat
    return 1.5 * r * (1.0 - t * t) / flat, 0.5 * r * (3.0 - t * t) / flat


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
    centre: Vector, axis: Vector, r: float, flat: float, normal: Vector, angle: float, f: FloatArray
) -> tuple[float, Vector, Vector]:
    """Return the gap (m) of the deepest point of a rim, that point (m), and the wall's normal there.

    Args:
        flat: sine of the tilt below which the rim touches with less than its radius: see :func:`rim_reach`.
        normal: of the wall at the rim's centre.
        angle: around the axis from the direction of ``normal``, at which the search begins, rad.
    """
    u, v = _across(axis, normal)
    before, turn_before = 0.0, 0.0
    gap, point, sine, c, s = 0.0, centre, dot(axis, normal), 1.0, 0.0
    tilt = math.sqrt(max(0.0, 1.0 - sine * sine))
    reach, standoff = rim_reach(r, tilt, flat)
    for i in range(MAX_ROUNDS):
        c, s = math.cos(angle), math.sin(angle)
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
    if standoff > 0.0:
        # The reach grows with the tilt, and so the gap changes more than by the motion of this point: as if it were further out.
        slope = flat_curvatures(r, tilt, flat)[0]
        further = slope * (c * dot(normal, u) + s * dot(normal, v) - tilt)
        point = add(point, scale(further, u))
        _, normal, _ = fitting_gap(point, f)
    return gap - standoff, point, normal
