"""Events within a step: a touch of the wall that begins and ends between the two ends of a step.

Two integrations that step over the same touch agree, so their difference does not show it. Points of a body that move
along straight lines are farthest from the axis of a bore at one of the two ends; within a step of h s they are less than
h^2 A / 8 further out, with the greatest acceleration A. Surfaces that are clear by more than that at both ends cannot
touch in between. For the others, the greatest depth in the wall is found on the dense output.
"""

import math

from driftform.motion.forces.bore import AxisLine, axis_line, is_clear, transverse_parts
from driftform.motion.forces.contact import is_near_wall, signed_depth
from driftform.motion.forces.model import FlightModel
from driftform.motion.forces.rates import frame_spin
from driftform.motion.solver.dense import Motion, move_between, pose_within
from driftform.types import FloatArray
from driftform.util.compiled import compiled
from driftform.util.rotations import rotation_from_quaternion
from driftform.util.small_vectors import Vector

BULGE = 0.25
"""Greatest distance of the path from its chord, over h^2 A: 1/8 for the accelerations A at the ends of a step, twice that
for those within it."""

ROUNDING = 1e-9
"""Margin of a depth for rounding, m."""

GLANCE = 1e-3
"""Share of a step after which, and before whose end, its depth is compared with that at the end."""

LOOKS = 8
"""Parts of a step whose ends are compared first."""

ROUNDS = 40
"""Halvings of the interval in which a depth is greatest, or zero."""

GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)

MIN_DEPTH = 1e-10
"""Depth (m) of a touch below which it is none: it changes the speed of a body by some 0.05 mm/s."""


@compiled
def find_touch(
    h: float, y: FloatArray, rate: FloatArray, new: FloatArray, new_rate: FloatArray, model: FlightModel
) -> tuple[float, float]:
    """Return when a surface that is clear at both ends of a step first touches the wall.

    Args:
        h: length of the step, s.
        y, rate, new, new_rate: the numbers of the flight at both ends, and their rates.
        model: of the flight.

    Returns:
        share: of the step before the touch; 1 if there is none.
        stay: time (s) for which the surface would be in the wall if the wall did not push; infinite if there is none.
    """
    margin = _bulge(h, y, rate, new, new_rate, model)
    p, q = (y[0], y[1], y[2]), (new[0], new[1], new[2])
    if not (is_near_wall(p, model, margin) or is_near_wall(q, model, margin)):
        return 1.0, math.inf
    a, b = _axis(y), _axis(new)
    is_straight = model.fittings is None
    before, after = _narrow_line(p, a, margin, model), _narrow_line(q, b, margin, model)
    first, stay = 1.0, math.inf
    for k in range(model.surfaces.shape[0]):
        if is_straight and is_clear(model.surfaces, k, before) and is_clear(model.surfaces, k, after):
            continue
        start = signed_depth(p, a, k, model, model.fittings)
        end = signed_depth(q, b, k, model, model.fittings)
        if start > 0.0 or end > 0.0 or max(start, end) < -margin:
            continue
        spins = frame_spin(y[10], model), frame_spin(new[10], model)
        motion = move_between(h, y, rate, new, new_rate, spins)
        # The depth grows at the beginning and falls at the end, or has no maximum in between.
        if _depth_within(motion, GLANCE, k, model) > start and _depth_within(motion, 1.0 - GLANCE, k, model) > end:
            share, time = _first_touch(motion, k, model)
            if share < first:
                first, stay = share, time * h
    return first, stay


@compiled
def _bulge(
    h: float, y: FloatArray, rate: FloatArray, new: FloatArray, new_rate: FloatArray, model: FlightModel
) -> float:
    """Return how far (m) a point of the body may be from the chord of its path, and from a wall that bulges in between."""
    n = model.numbers[0]
    hardest = max(_acceleration(y, rate, n.reach, n.curvature), _acceleration(new, new_rate, n.reach, n.curvature))
    return float(BULGE * h * h * hardest + ROUNDING)


@compiled
def _acceleration(y: FloatArray, rate: FloatArray, reach: float, curvature: float) -> float:
    """Return an upper bound (m/s2) of how any point within ``reach`` (m) accelerates, seen from a wall of this curvature (1/m)."""
    turning = math.sqrt(y[11] * y[11] + y[12] * y[12])
    swing = math.sqrt(rate[11] * rate[11] + rate[12] * rate[12]) + abs(y[10]) * turning
    push = math.sqrt(rate[7] * rate[7] + rate[8] * rate[8] + rate[9] * rate[9])
    speed = math.sqrt(y[7] * y[7] + y[8] * y[8] + y[9] * y[9]) + reach * turning
    return float(push + reach * (swing + turning * turning) + curvature * speed * speed)


@compiled
def _axis(y: FloatArray) -> Vector:
    R = rotation_from_quaternion(y[3], y[4], y[5], y[6])
    return R[0][0], R[1][0], R[2][0]


@compiled
def _narrow_line(position: Vector, axis: Vector, margin: float, model: FlightModel) -> AxisLine:
    """Return the place of the body's axis in a straight bore that is narrower by ``margin`` (m)."""
    if model.fittings is not None:
        return 0.0, 0.0, 0.0, 0.0
    oo, oa, aa, radius = axis_line(transverse_parts(position, axis, model.pipe), model.pipe)
    return oo, oa, aa, max(0.0, radius - margin)


@compiled
def _first_touch(motion: Motion, k: int, model: FlightModel) -> tuple[float, float]:
    """Return the share of a step before surface ``k`` touches, and that for which it is in the wall; 1 and 0 without a touch."""
    best, deepest = 0, -math.inf
    for i in range(LOOKS + 1):
        depth = _depth_within(motion, i / LOOKS, k, model)
        if depth > deepest:
            best, deepest = i, depth
    low, high = max(0, best - 1) / LOOKS, min(LOOKS, best + 1) / LOOKS
    u = best / LOOKS
    if not deepest > MIN_DEPTH:
        u, deepest = _find_deepest(motion, low, high, k, model)
    if not deepest > MIN_DEPTH:
        return 1.0, 0.0
    # The first of the looks may lie beyond another one in the wall.
    while low > 0.0 and _depth_within(motion, low, k, model) > 0.0:
        low -= 1.0 / LOOKS
    while high < 1.0 and _depth_within(motion, high, k, model) > 0.0:
        high += 1.0 / LOOKS
    enters = _find_zero(motion, low, u, k, model)
    return enters, _find_zero(motion, high, u, k, model) - enters


@compiled
def _depth_within(motion: Motion, u: float, k: int, model: FlightModel) -> float:
    position, axis = pose_within(motion, u)
    return signed_depth(position, axis, k, model, model.fittings)


@compiled
def _find_deepest(motion: Motion, low: float, high: float, k: int, model: FlightModel) -> tuple[float, float]:
    """Return the share of the step at which surface ``k`` is deepest, and its depth (m), by golden sections."""
    a, b = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    at_a, at_b = _depth_within(motion, a, k, model), _depth_within(motion, b, k, model)
    for _ in range(ROUNDS):
        if at_a > at_b:
            high, b, at_b = b, a, at_a
            a = high - GOLDEN * (high - low)
            at_a = _depth_within(motion, a, k, model)
        else:
            low, a, at_a = a, b, at_b
            b = low + GOLDEN * (high - low)
            at_b = _depth_within(motion, b, k, model)
        if max(at_a, at_b) > MIN_DEPTH:
            break
    return (a, at_a) if at_a > at_b else (b, at_b)


@compiled
def _find_zero(motion: Motion, clear: float, deep: float, k: int, model: FlightModel) -> float:
    """Return the share of the step at which surface ``k`` enters or leaves the wall, by bisection."""
    for _ in range(ROUNDS):
        middle = 0.5 * (clear + deep)
        if _depth_within(motion, middle, k, model) > 0.0:
            deep = middle
        else:
            clear = middle
    return deep
