"""Contact of a body of revolution with the inside of a pipe: springs and dampers at its rims, and friction."""

import math

import numpy as np

from driftform.dynamics.bore import (
    ANGLE_TOLERANCE,
    axis_line,
    bore_vectors,
    is_clear,
    is_coplanar,
    lever_and_normal,
    rim_contact,
    smoothed_sine,
    transverse_parts,
)
from driftform.dynamics.vectors import (
    ZERO,
    Rotation,
    Vector,
    Wrench,
    add,
    add_wrenches,
    body_axis,
    cross,
    dot,
    force_wrench,
    scale,
    subtract,
    to_body,
    to_world,
)
from driftform.types import FloatArray
from driftform.util.compiled import compiled

DAMPER_ONSET = 1e-3
"""Depth (m) over which the damper reaches its full strength, so that the force is continuous."""

SLIP_SPEED = 1e-2
"""Sliding speed (m/s) below which friction grows with the speed instead of being constant."""


@compiled
def wall_gap(point: Vector, pipe: FloatArray) -> tuple[float, Vector]:
    """Return the distance from ``point`` to the wall (m, negative outside the pipe), and the unit vector to the wall.

    The pipe (see :class:`driftform.dynamics.model.FlightModel`) is the union of its segments' bores; the first and
    the last continue beyond their outer ends. If the point lies on an axis, the vector is zero.
    """
    best, normal = -np.inf, ZERO
    last = pipe.shape[0] - 1
    for s in range(pipe.shape[0]):
        axis = (pipe[s, 3], pipe[s, 4], pipe[s, 5])
        off = subtract(point, (pipe[s, 0], pipe[s, 1], pipe[s, 2]))
        along = dot(axis, off)
        if s > 0:
            along = max(along, 0.0)
        if s < last:
            along = min(along, pipe[s, 6])
        off = subtract(off, scale(along, axis))
        distance = math.sqrt(dot(off, off))
        if pipe[s, 7] - distance > best:
            best = pipe[s, 7] - distance
            normal = scale(1.0 / distance, off) if distance > 0.0 else ZERO
    return best, normal


@compiled
def is_far_from_wall(position: Vector, reach: float, pipe: FloatArray) -> bool:
    """Return True if nothing within ``reach`` (m) of ``position`` can touch a wall."""
    if pipe.shape[0] != 1:
        return pipe.shape[0] == 0 or wall_gap(position, pipe)[0] > reach
    off = subtract(position, (pipe[0, 0], pipe[0, 1], pipe[0, 2]))
    along, room = dot(off, (pipe[0, 3], pipe[0, 4], pipe[0, 5])), pipe[0, 7] - reach
    return bool(room > 0.0 and dot(off, off) - along * along < room * room)


@compiled
def farthest_rim_point(centre: Vector, axis: Vector, r: float, normal: Vector) -> Vector:
    """Return the point of a rim of radius ``r`` (m) that lies farthest along ``normal``, world frame, m."""
    s = dot(axis, normal)
    return add(centre, scale(r / smoothed_sine(s), subtract(normal, scale(s, axis))))


@compiled
def rim_depth(
    position: Vector, axis: Vector, x: float, r: float, pipe: FloatArray
) -> tuple[float, Vector, Vector]:
    """Return the depth of the rim (x, r) in the wall (m, 0 if it is clear), the point, and the wall's normal there.

    ``position`` of the body's origin (m), its ``axis``, the point and the normal are in the world frame. The farthest
    point defines the normal, and the normal defines the point; two rounds suffice in a wide bore.
    """
    if pipe.shape[0] == 1:
        contact = rim_contact(x, r, axis_line(position, axis, pipe))
        o, a = transverse_parts(position, axis, pipe)
        lever, normal = lever_and_normal(axis, o, a, contact)
        return max(0.0, contact[0]), add(position, lever), normal
    centre = add(position, scale(x, axis))
    gap, normal = wall_gap(centre, pipe)
    if gap > r:
        return 0.0, centre, normal
    point = farthest_rim_point(centre, axis, r, normal)
    gap, there = wall_gap(point, pipe)
    turned = subtract(there, normal)
    if dot(turned, turned) > ANGLE_TOLERANCE * ANGLE_TOLERANCE:
        point = farthest_rim_point(centre, axis, r, there)
        gap, there = wall_gap(point, pipe)
    return max(0.0, -gap), point, there


@compiled
def deepest_rim_depth(
    position: Vector, R: Rotation, rims: FloatArray, reach: float, pipe: FloatArray
) -> float:
    """Return the depth (m) of the deepest rim in the wall, 0 if none touches.

    ``reach`` is the greatest distance (m) of a rim from the body's origin.
    """
    deepest = 0.0
    if not is_far_from_wall(position, reach, pipe):
        axis = body_axis(R)
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
    """Return force (N) and torque (N m) of the wall on the body, about the body's origin, in body axes.

    ``position`` (m) and ``velocity`` (m/s) of the body's origin are in the world frame, ``omega`` (rad/s) is in the
    body frame. A rim whose farthest point lies at the depth d in the wall presses with its share N of
    k d + c d' onset(d), and never pulls. The share of a rim is s^2 / sqrt(sum of s^4 over all rims), with
    s^2 = k d^2: the springs then have the potential sqrt(sum of s^4) / 2, and a finely divided dome, of which many
    rims touch at once, is not many times stiffer than a single rim.

    Friction opposes the velocity v along the wall with mu N v / sqrt(|v|^2 + s^2): Coulomb's law, smoothed below the
    speed s. This speed is :data:`SLIP_SPEED`, unless the effective mass m of the rim is so small (as in a roll) that
    friction would act faster than ``rate`` (1/s): then s = mu N / (m rate).
    """
    if is_far_from_wall(position, reach, pipe):
        return ZERO, ZERO
    axis = body_axis(R)
    w = to_world(R, omega)
    if pipe.shape[0] > 1:
        push, share = _pipe_wrench(position, axis, velocity, w, rims, pipe)
    elif is_coplanar(axis_line(position, axis, pipe), reach):
        push, share = _coplanar_wrench(position, axis, velocity, w, rims, pipe)
    else:
        push, share = _straight_pipe_wrench(position, axis, velocity, w, rims, pipe)
    if friction > 0.0 and share > 0.0:
        push = add_wrenches(
            push, _friction_wrench(position, axis, velocity, w, rims, pipe, friction * share, rate)
        )
    return to_body(R, push[0]), to_body(R, push[1])


@compiled
def _coplanar_wrench(
    position: Vector, axis: Vector, v: Vector, w: Vector, rims: FloatArray, pipe: FloatArray
) -> tuple[Wrench, float]:
    """Return what :func:`_pipe_wrench` does if :func:`driftform.dynamics.bore.is_coplanar`: all rims share one normal."""
    line, vectors = axis_line(position, axis, pipe), bore_vectors(position, axis, pipe)
    off = math.sqrt(line[0])
    normal, tilted = scale(1.0 / off, vectors[0]), scale(1.0 / off, vectors[2])
    force, torque, share = coplanar_force(rims, line[1] / off, line[3] - off, dot(normal, v), dot(tilted, w))
    return (scale(-force, normal), scale(-torque, tilted)), share


@compiled
def coplanar_force(
    rims: FloatArray, s: float, gap: float, speed: float, turning: float
) -> tuple[float, float, float]:
    """Return force (N) and torque (N m) of rims with one normal n on the wall, and 1 / sqrt(sum of s^4).

    Parameters
    ----------
    rims
        of :class:`driftform.dynamics.model.FlightModel`.
    s
        a'.n, where a' is the body's axis.
    gap
        distance from the body's origin to the wall along n, m.
    speed, turning
        velocity of the body's origin along n, m/s, and of rotation about a' x n, rad/s.
    """
    outward = 1.0 / smoothed_sine(s)
    total, force, torque = 0.0, 0.0, 0.0
    for k in range(rims.shape[0]):
        x, k_r = rims[k, 0], outward * rims[k, 1]
        depth = x * s + k_r * (1.0 - s * s) - gap
        if depth <= 0.0:
            continue
        along = x - k_r * s
        square, pressed = _weigh_force(rims, k, depth, speed + along * turning)
        total += square * square
        force += pressed
        torque += pressed * along
    share = 1.0 / math.sqrt(total) if total > 0.0 else 0.0
    return share * force, share * torque, share


@compiled
def _straight_pipe_wrench(
    position: Vector, axis: Vector, v: Vector, w: Vector, rims: FloatArray, pipe: FloatArray
) -> tuple[Wrench, float]:
    """Return what :func:`_pipe_wrench` does, in a pipe of one segment."""
    line, vectors = axis_line(position, axis, pipe), bore_vectors(position, axis, pipe)
    o, a, axis_o, axis_a, o_a = vectors
    v_o, v_a = dot(v, o), dot(v, a)
    w_o, w_a, w_oa = dot(w, axis_o), dot(w, axis_a), dot(w, o_a)
    total, f_o, f_a, t_o, t_a, t_oa = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(rims.shape[0]):
        if is_clear(rims, k, line):
            continue
        depth, n_o, n_a, along, l_o, l_a = rim_contact(rims[k, 0], rims[k, 1], line)
        if depth <= 0.0:
            continue
        # The normal is n_o o + n_a a; the lever is along axis + l_o o + l_a a.
        turn = l_o * n_a - l_a * n_o
        speed = n_o * v_o + n_a * v_a + along * (n_o * w_o + n_a * w_a) + turn * w_oa
        square, pressed = _weigh_force(rims, k, depth, speed)
        total += square * square
        f_o += pressed * n_o
        f_a += pressed * n_a
        t_o += pressed * along * n_o
        t_a += pressed * along * n_a
        t_oa += pressed * turn
    share = 1.0 / math.sqrt(total) if total > 0.0 else 0.0
    force = scale(-share, add(scale(f_o, o), scale(f_a, a)))
    torque = scale(-share, add(scale(t_o, axis_o), add(scale(t_a, axis_a), scale(t_oa, o_a))))
    return (force, torque), share


@compiled
def _pipe_wrench(
    position: Vector, axis: Vector, v: Vector, w: Vector, rims: FloatArray, pipe: FloatArray
) -> tuple[Wrench, float]:
    """Return the wrench of the wall's springs and dampers on the body, about its origin in the world frame.

    The second value is 1 / sqrt(sum of s^4), or 0 if no rim touches.
    """
    wrench, total = (ZERO, ZERO), 0.0
    for k in range(rims.shape[0]):
        depth, point, normal = rim_depth(position, axis, rims[k, 0], rims[k, 1], pipe)
        if depth <= 0.0:
            continue
        lever = subtract(point, position)
        square, force = _weigh_force(rims, k, depth, dot(normal, add(v, cross(w, lever))))
        total += square * square
        wrench = add_wrenches(wrench, force_wrench(lever, scale(-force, normal)))
    share = 1.0 / math.sqrt(total) if total > 0.0 else 0.0
    return (scale(share, wrench[0]), scale(share, wrench[1])), share


@compiled
def _friction_wrench(
    position: Vector,
    axis: Vector,
    v: Vector,
    w: Vector,
    rims: FloatArray,
    pipe: FloatArray,
    factor: float,
    rate: float,
) -> Wrench:
    """Return the friction on all rims about the body's origin, world frame; ``factor`` is mu / sqrt(sum of s^4)."""
    wrench = (ZERO, ZERO)
    line, straight = axis_line(position, axis, pipe), pipe.shape[0] == 1
    o, a = transverse_parts(position, axis, pipe)
    for k in range(rims.shape[0]):
        x, r = rims[k, 0], rims[k, 1]
        if is_clear(rims, k, line):
            continue
        if straight:
            contact = rim_contact(x, r, line)
            depth = contact[0]
            lever, normal = lever_and_normal(axis, o, a, contact)
        else:
            depth, point, normal = rim_depth(position, axis, x, r, pipe)
            lever = subtract(point, position)
        if depth <= 0.0:
            continue
        moving = add(v, cross(w, lever))
        speed = dot(normal, moving)
        grip = factor * _weigh_force(rims, k, depth, speed)[1]
        sliding = subtract(moving, scale(speed, normal))
        smooth = max(SLIP_SPEED, grip / (rims[k, 4] * rate))
        drag = grip / math.sqrt(dot(sliding, sliding) + smooth * smooth)
        wrench = add_wrenches(wrench, force_wrench(lever, scale(-drag, sliding)))
    return wrench


@compiled
def _weigh_force(rims: FloatArray, k: int, depth: float, speed: float) -> tuple[float, float]:
    """Return s^2 (J) of a rim that enters the wall at ``speed`` (m/s), and s^2 times its spring's and damper's force (N)."""
    square = rims[k, 2] * depth * depth
    return square, square * max(0.0, rims[k, 2] * depth + rims[k, 3] * speed * min(1.0, depth / DAMPER_ONSET))
