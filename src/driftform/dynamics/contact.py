"""Contact of a body of revolution with the inside of a pipe: an inelastic penalty on its rims, with friction."""

import math

import numpy as np

from driftform.dynamics.compiled import compiled
from driftform.dynamics.vectors import (
    ZERO,
    Rotation,
    Vector,
    Wrench,
    both,
    cross,
    dot,
    force_at,
    forward,
    minus,
    plus,
    times,
    to_body,
)
from driftform.types import FloatArray

ONSET = 1e-3
"""Depth, m, over which the damper sets in, so that the force is continuous."""

BLUNT = 1e-3
"""Sine of the angle between axis and wall normal below which a rim touches with less than its radius.

A rim that faces the wall flatly touches all around at once; its lowest point is then undefined, and the force
passes through its centre.
"""

SETTLED = 1e-7
"""Angle (rad) between the wall's normal at the centre of a rim and at its contact point that makes no difference."""

SLIP = 1e-2
"""Speed, m/s, below which friction grows with the speed of sliding instead of being constant."""


@compiled
def wall_gap(point: Vector, pipe: FloatArray) -> tuple[float, Vector]:
    """Return how far ``point`` is inside the pipe (m, negative outside), and the unit vector to the wall.

    The pipe (see :class:`driftform.dynamics.model.FlightModel`) is the union of its segments' bores; the first and
    the last run on beyond their outer ends. Where the point lies on an axis, the vector is zero.
    """
    best, normal = -np.inf, ZERO
    last = pipe.shape[0] - 1
    for s in range(pipe.shape[0]):
        axis = (pipe[s, 3], pipe[s, 4], pipe[s, 5])
        off = minus(point, (pipe[s, 0], pipe[s, 1], pipe[s, 2]))
        along = dot(axis, off)
        if s > 0:
            along = max(along, 0.0)
        if s < last:
            along = min(along, pipe[s, 6])
        off = minus(off, times(along, axis))
        distance = math.sqrt(dot(off, off))
        if pipe[s, 7] - distance > best:
            best = pipe[s, 7] - distance
            normal = times(1.0 / distance, off) if distance > 0.0 else ZERO
    return best, normal


@compiled
def is_far(position: Vector, reach: float, pipe: FloatArray) -> bool:
    """Return True where nothing within ``reach`` (m) of a point can touch a wall."""
    if pipe.shape[0] != 1:
        return pipe.shape[0] == 0 or wall_gap(position, pipe)[0] > reach
    off = minus(position, (pipe[0, 0], pipe[0, 1], pipe[0, 2]))
    along, room = dot(off, (pipe[0, 3], pipe[0, 4], pipe[0, 5])), pipe[0, 7] - reach
    return bool(room > 0.0 and dot(off, off) - along * along < room * room)


@compiled
def rim_point(centre: Vector, axis: Vector, r: float, normal: Vector) -> Vector:
    """Return the point of a rim of radius ``r`` (m) that lies farthest along ``normal``, world frame, m."""
    across = minus(normal, times(dot(axis, normal), axis))
    return plus(centre, times(r / math.sqrt(dot(across, across) + BLUNT * BLUNT), across))


@compiled
def axis_line(position: Vector, axis: Vector, pipe: FloatArray) -> tuple[float, float, float, float]:
    """Return a, b, c, R: a point at x of the body's axis lies sqrt(a + 2 b x + c x^2) from the axis of the pipe.

    R is the radius of the pipe, 0 where it has more than one segment and the distance is no such simple thing.
    """
    if pipe.shape[0] != 1:
        return 0.0, 0.0, 0.0, 0.0
    downstream = (pipe[0, 3], pipe[0, 4], pipe[0, 5])
    off = minus(position, (pipe[0, 0], pipe[0, 1], pipe[0, 2]))
    off = minus(off, times(dot(off, downstream), downstream))
    across = minus(axis, times(dot(axis, downstream), downstream))
    return dot(off, off), dot(off, across), dot(across, across), pipe[0, 7]


@compiled
def is_clear(rims: FloatArray, k: int, line: tuple[float, float, float, float]) -> bool:
    """Return True where rim ``k`` surely does not touch the pipe of :func:`axis_line`.

    Its centre is at d from the pipe's axis, and it reaches out by r sqrt(1 - s^2), s being the component of the
    body's axis along d. Neither root is taken: d <= (d^2 + R^2) / (2 R), and s d = b + c x.
    """
    a, b, c, R = line
    x, r = rims[k, 0], rims[k, 1]
    slope = b + c * x
    square = a + (b + slope) * x
    room = 0.5 * R - 0.5 * square / R - rims[k, 5] if R > 0.0 else 0.0
    return room > 0.0 and r * r * (square - slope * slope) < room * room * square


@compiled
def rim_depth(
    position: Vector, axis: Vector, x: float, r: float, pipe: FloatArray
) -> tuple[float, Vector, Vector]:
    """Return how deep the rim (x, r) is in the wall (m, 0 where it is clear), where, and the wall's normal there.

    ``position`` of the body's origin and its ``axis`` are in the world frame. The farthest point defines the normal
    and the normal the point; the bore is wide, so two rounds settle.
    """
    centre = plus(position, times(x, axis))
    gap, normal = wall_gap(centre, pipe)
    if gap > r:
        return 0.0, centre, normal
    point = rim_point(centre, axis, r, normal)
    gap, there = wall_gap(point, pipe)
    turned = minus(there, normal)
    if dot(turned, turned) > SETTLED * SETTLED:
        point = rim_point(centre, axis, r, there)
        gap, there = wall_gap(point, pipe)
    return max(0.0, -gap), point, there


@compiled
def deepest_rim(position: Vector, R: Rotation, rims: FloatArray, reach: float, pipe: FloatArray) -> float:
    """Return the depth (m) of the deepest rim in the wall, 0 where none touches.

    ``reach`` is the greatest distance (m) of a rim from the body's origin.
    """
    deepest = 0.0
    if not is_far(position, reach, pipe):
        axis = forward(R)
        line = axis_line(position, axis, pipe)
        for k in range(rims.shape[0]):
            if not is_clear(rims, k, line):
                deepest = max(deepest, rim_depth(position, axis, rims[k, 0], rims[k, 1], pipe)[0])
    return deepest


@compiled
def wall_wrench(
    position: Vector,
    R: Rotation,
    velocity: Vector,
    omega: Vector,
    rims: FloatArray,
    reach: float,
    pipe: FloatArray,
    friction: float,
    rate: float,
) -> Wrench:
    """Return force (N) and torque (N m) of the wall about the body's origin, in body axes.

    ``position`` (m) of the body's origin is in the world frame, its ``velocity`` (m/s) and ``omega`` (rad/s) are in
    the body frame. A rim whose farthest point is the depth d beyond the wall presses with its share N of
    k d + c d' onset(d), and never pulls. The share of a rim is s^2 / sqrt(sum of s^4 over all rims), with
    s^2 = k d^2: the springs then have the potential sqrt(sum of s^4) / 2, and a finely divided dome, of which many
    rims touch at once, is not many times stiffer than a single rim.

    Friction opposes the velocity v along the wall with mu N v / sqrt(|v|^2 + s^2): Coulomb's law, smoothed below the
    speed s. That is :data:`SLIP`, or more where the mass m that the rim opposes is so small (that of a roll) that
    friction would act faster than ``rate``: s = mu N / (m rate) then.
    """
    wrench = (ZERO, ZERO)
    if is_far(position, reach, pipe):
        return wrench
    axis = forward(R)
    line = axis_line(position, axis, pipe)
    total = 0.0
    for k in range(rims.shape[0]):
        if is_clear(rims, k, line):
            continue
        depth, point, normal = rim_depth(position, axis, rims[k, 0], rims[k, 1], pipe)
        if depth == 0.0:
            continue
        total += (rims[k, 2] * depth * depth) ** 2
        arm, inward = to_body(R, minus(point, position)), to_body(R, normal)
        speed = dot(inward, plus(velocity, cross(omega, arm)))
        push = rims[k, 2] * depth * depth * _push(rims, k, depth, speed)
        wrench = both(wrench, force_at(arm, times(-push, inward)))
    if total == 0.0:
        return wrench
    share = 1.0 / math.sqrt(total)
    wrench = (times(share, wrench[0]), times(share, wrench[1]))
    if friction == 0.0:
        return wrench
    for k in range(rims.shape[0]):
        if is_clear(rims, k, line):
            continue
        depth, point, normal = rim_depth(position, axis, rims[k, 0], rims[k, 1], pipe)
        if depth == 0.0:
            continue
        arm, inward = to_body(R, minus(point, position)), to_body(R, normal)
        moving = plus(velocity, cross(omega, arm))
        speed = dot(inward, moving)
        grip = friction * share * rims[k, 2] * depth * depth * _push(rims, k, depth, speed)
        sliding = minus(moving, times(speed, inward))
        smooth = max(SLIP, grip / (rims[k, 4] * rate))
        drag = grip / math.sqrt(dot(sliding, sliding) + smooth * smooth)
        wrench = both(wrench, force_at(arm, times(-drag, sliding)))
    return wrench


@compiled
def _push(rims: FloatArray, k: int, depth: float, speed: float) -> float:
    """Spring and damper of a rim that enters the wall at ``speed``, N, before its share is taken."""
    return float(max(0.0, rims[k, 2] * depth + rims[k, 3] * speed * min(1.0, depth / ONSET)))
