"""How the accelerations by the forces of a wall change with the pose, the velocity and the bristles of a body.

An implicit step needs these derivatives to be stable where springs and bristles are much faster than the motion. It
needs no more of them than that: how levers and normals change with the pose is left out where it is slow. It is fast of a
body that stands on a flat end: a small tilt moves the point of contact from the middle of the face to its edge.

Several springs have the energy U = r / 2, with r = sqrt(sum of e^2), see :mod:`driftform.motion.impact`. With the
derivatives of e with respect to the depths::

    d2U / (dd_i dd_j) = delta_ij (e_i'^2 + e_i e_i'') / (2 r) - e_i e_i' e_j e_j' / (2 r^3)

With S = 1 where a bristle sticks, and otherwise its share of the greatest friction across the direction d of the slip,
S = (1 - d d^T) mu N / |y|, the force of a bristle, and its rate, change by::

    df = m omega S (dv + db) + mu d dN        db' = omega S (dv + db) - omega db
"""

import math
from typing import NamedTuple

import numpy as np

from driftform.motion.bore import SINE_SMOOTHING, smoothed_sine
from driftform.motion.contact import axis_in_bore, is_far_from_wall, surface_depth
from driftform.motion.fitting_contact import flat_curvatures, flat_tilt
from driftform.motion.impact import FREQUENCY, common_mass, damper, spring, spring_slope
from driftform.motion.model import FRICTION, INVERSE, LINEAR, REACH, FlightModel
from driftform.motion.plane import ACROSS, LAW, NEAR, RADIUS, RESPONSE, RUB, depth_in_plane, offset_in_plane
from driftform.motion.rates import PLANE_STATE, STATE
from driftform.types import FloatArray
from driftform.util.compiled import borrow, borrowing, compiled
from driftform.util.rotations import rotation_from_quaternion
from driftform.util.small_vectors import (
    ZERO,
    Rotation,
    Vector,
    body_axis,
    cross,
    dot,
    multiply,
    to_body,
    to_world,
)

MOST = 4
"""Number of surfaces that may touch at once; of a body that rests on more no Jacobian is made."""

SPEED_STEP = 1e-3
"""Difference of the speed of approach (m/s) from which the rate of damping follows."""


class ContactJacobian(NamedTuple):
    """Derivatives of v velocities, and of d numbers for the bristle of each of c surfaces that touch.

    Attributes
    ----------
    fast
        of the rates of these v + c d numbers with respect to the numbers themselves, 1/s.
    stiff
        of the accelerations with respect to the pose, 1/s2, (v, v).
    touching
        indices of the surfaces.
    springs
        of each surface: twice the energy (J), half of its derivative (N), half of its second derivative (N/m), mass of
        the bristle (kg), (c, 4).
    normals
        of the wall, in the directions of the bristles, (c, d).
    curvatures
        second derivative of each surface's depth with respect to turns of the body across its axis, m: one in the plane,
        (c, 2, 2) in space.
    pushes, pulls
        the generalised forces of unit forces on a surface, along the normal and along the directions of its bristle, and the
        accelerations that they cause: rows 0 and 1 to d, (c, 1 + d, v).
    turns
        the accelerations by unit torques across the axis, (1 or 2, v).
    trial
        room for the slip of a bristle, m/s, (3,).
    """

    fast: FloatArray
    stiff: FloatArray
    touching: FloatArray
    springs: FloatArray
    normals: FloatArray
    curvatures: FloatArray
    pushes: FloatArray
    pulls: FloatArray
    turns: FloatArray
    trial: FloatArray


EQUATIONS = 6 + 3 * MOST
"""Numbers of a body in space whose bristles all touch; no other motion has more."""

_SIZES = (EQUATIONS**2, 6 * 6, MOST, MOST * 4, MOST * 3, MOST * 4, MOST * 4 * 6, MOST * 4 * 6, 2 * 6, 3)
_STIFF, _TOUCHING, _SPRINGS, _NORMALS, _CURVATURES, _PUSHES, _PULLS, _TURNS, _TRIAL, JACOBIAN_ROOM = (
    np.cumsum(_SIZES).tolist()
)


@borrowing
def make_jacobian(room: FloatArray, velocities: int, directions: int) -> ContactJacobian:
    """Return a Jacobian to be filled: of 3 velocities in the plane or 6 in space, and bristles with so many directions.

    It is in the first :data:`JACOBIAN_ROOM` numbers of ``room``, which must be zero.
    """
    size = velocities + MOST * directions
    return ContactJacobian(
        borrow(room, 0, (size, size)),
        borrow(room, _STIFF, (velocities, velocities)),
        borrow(room, _TOUCHING, (MOST,)),
        borrow(room, _SPRINGS, (MOST, 4)),
        borrow(room, _NORMALS, (MOST, 3)),
        borrow(room, _CURVATURES, (MOST, 2, 2)),
        borrow(room, _PUSHES, (MOST, 1 + directions, velocities)),
        borrow(room, _PULLS, (MOST, 1 + directions, velocities)),
        borrow(room, _TURNS, (velocities // 3, velocities)),
        borrow(room, _TRIAL, (3,)),
    )


@compiled
def fill_jacobian_in_plane(
    y: FloatArray, plane: FloatArray, surfaces: FloatArray, jacobian: ContactJacobian
) -> int:
    """Fill the Jacobian at the state ``y`` in the plane; return the number of surfaces that touch, 0 if it has none."""
    w, h = y[2], y[3]
    double = 2.0 / (w * w + h * h)
    c, s = 1.0 - double * h * h, double * w * h
    off = offset_in_plane((y[0], y[1]), plane)
    side, count = 1.0 if off > 0.0 else -1.0, 0
    n_x, n_z, gap = side * plane[ACROSS], side * plane[ACROSS + 1], plane[RADIUS] - side * off
    tilt, upright = c * n_x - s * n_z, s * n_x + c * n_z
    inverse = 1.0 / smoothed_sine(tilt)
    share = (1.0 - tilt * tilt) * inverse
    if abs(off) < plane[NEAR]:
        return 0
    for k in range(surfaces.shape[0]):
        depth, x, r = depth_in_plane(surfaces, k, tilt, share, gap)
        if depth > 0.0:
            if count == MOST:
                return 0
            _fill_spring(tilt, x, r, depth, plane[LAW:RUB], surfaces, k, jacobian, count)
            push = jacobian.pushes[count]
            push[0, 0], push[0, 1] = n_x, n_z
            push[0, 2] = r * upright * inverse * tilt - x * upright
            if push.shape[0] > 1:
                push[1, 0], push[1, 1], push[1, 2] = side * n_z, -side * n_x, side * (gap + depth)
            for i in range(push.shape[0]):
                _respond_in_plane(push[i, 0], push[i, 1], push[i, 2], c, s, plane, jacobian.pulls[count, i])
            jacobian.curvatures[count, 0, 0] = edge_curvatures(r, upright)[0]
            count += 1
    if count > 0:
        _respond_in_plane(0.0, 0.0, 1.0, c, s, plane, jacobian.turns[0])
        _complete(y[PLANE_STATE - 3 :], count, plane[LAW:RUB], plane[RUB], jacobian)
    return count


@compiled
def _respond_in_plane(
    F_x: float, F_z: float, N: float, c: float, s: float, plane: FloatArray, pull: FloatArray
) -> None:
    """Fill ``pull`` with the accelerations by a force, world frame, and a moment at the pitch with this cosine and sine."""
    X, Z = c * F_x - s * F_z, s * F_x + c * F_z
    a_x = plane[RESPONSE] * X + plane[RESPONSE + 1] * Z + plane[RESPONSE + 2] * N
    a_z = plane[RESPONSE + 1] * X + plane[RESPONSE + 3] * Z + plane[RESPONSE + 4] * N
    pull[0], pull[1] = c * a_x + s * a_z, c * a_z - s * a_x
    pull[2] = plane[RESPONSE + 2] * X + plane[RESPONSE + 4] * Z + plane[RESPONSE + 5] * N


@compiled
def edge_curvatures(r: float, c: float) -> tuple[float, float]:
    """Return the curvatures (m) of the depth of a rim of radius ``r`` (m), r c^2 / sqrt(c^2 + SINE_SMOOTHING^2).

    c is the sine of the body's tilt from upright. The first curvature is that along the tilt, or zero where it is negative;
    the second is that across it.
    """
    small = SINE_SMOOTHING * SINE_SMOOTHING
    square = c * c + small
    root = math.sqrt(square)
    return (
        max(0.0, r * small * (2.0 * small - c * c) / (square * square * root)),
        r * (c * c + 2.0 * small) / (square * root),
    )


@compiled
def fill_jacobian_in_space(y: FloatArray, model: FlightModel, jacobian: ContactJacobian) -> int:
    """Fill the Jacobian at the state ``y`` in space; return the number of surfaces that touch, 0 if it has none."""
    position, count = (y[0], y[1], y[2]), 0
    if is_far_from_wall(position, model.table[REACH], model.pipe, model.fittings):
        return 0
    R = rotation_from_quaternion(y[3], y[4], y[5], y[6])
    axis = body_axis(R)
    line, parts = axis_in_bore(position, axis, model.pipe, model.fittings)
    for k in range(model.surfaces.shape[0]):
        depth, lever, normal, x, r = surface_depth(position, axis, line, parts, k, model, model.fittings)
        if depth > 0.0:
            if count == MOST:
                return 0
            _fill_spring(dot(axis, normal), x, r, depth, model.law, model.surfaces, k, jacobian, count)
            push, pull = jacobian.pushes[count], jacobian.pulls[count]
            _fill_push(normal, lever, R, model.table[INVERSE:LINEAR], push[0], pull[0])
            if push.shape[0] > 1:
                for j in range(3):
                    jacobian.normals[count, j] = normal[j]
                    unit = (1.0 if j == 0 else 0.0, 1.0 if j == 1 else 0.0, 1.0 if j == 2 else 0.0)
                    _fill_push(unit, lever, R, model.table[INVERSE:LINEAR], push[1 + j], pull[1 + j])
            flat = flat_tilt(r, model.surfaces, k) if model.fittings is not None and r > 0.0 else 0.0
            _fill_curvatures(to_body(R, normal), r, flat, jacobian.curvatures[count])
            count += 1
    if count > 0:
        for i in range(2):
            a, alpha = multiply(model.table[INVERSE:LINEAR], ZERO, (0.0, 1.0 - i, float(i)))
            a = to_world(R, a)
            for j in range(3):
                jacobian.turns[i, j], jacobian.turns[i, 3 + j] = a[j], alpha[j]
        _complete(y[STATE - 6 :], count, model.law, model.table[FRICTION], jacobian)
    return count


@compiled
def _fill_push(
    force: Vector, lever: Vector, R: Rotation, inverse: FloatArray, push: FloatArray, pull: FloatArray
) -> None:
    """Fill ``push`` with the generalised force of ``force`` at ``lever``, and ``pull`` with the accelerations by it."""
    torque = to_body(R, cross(lever, force))
    a, alpha = multiply(inverse, to_body(R, force), torque)
    a = to_world(R, a)
    for j in range(3):
        push[j], push[3 + j], pull[j], pull[3 + j] = force[j], torque[j], a[j], alpha[j]


@compiled
def _fill_curvatures(normal: Vector, r: float, flat: float, out: FloatArray) -> None:
    """Fill ``out`` (2, 2) with the second derivatives of a rim's depth (m) with respect to turns about the body's y and z.

    ``normal`` is that of the wall in the body frame, ``flat`` the tilt of :func:`driftform.motion.fitting_contact.rim_reach`, 0 in a
    straight pipe.
    """
    c = math.sqrt(normal[1] * normal[1] + normal[2] * normal[2])
    along, across = edge_curvatures(r, c) if flat == 0.0 else flat_curvatures(r, c, flat)
    y, z = (normal[2] / c, -normal[1] / c) if c > 0.0 else (1.0, 0.0)
    along, across = along * normal[0] * normal[0], across * normal[0] * normal[0]
    out[0, 0], out[1, 1] = along * y * y + across * z * z, along * z * z + across * y * y
    out[0, 1] = out[1, 0] = (along - across) * y * z


@compiled
def _fill_spring(
    s: float,
    x: float,
    r: float,
    depth: float,
    law: FloatArray,
    surfaces: FloatArray,
    k: int,
    jacobian: ContactJacobian,
    i: int,
) -> None:
    mass, energy, force, _ = spring(s, x, r, depth, law)
    row = jacobian.springs[i]
    row[0], row[1], row[2], row[3] = energy, force, spring_slope(mass, depth, law), surfaces[k, 6]
    jacobian.touching[i] = k


@compiled
def _complete(y: FloatArray, count: int, law: FloatArray, friction: float, jacobian: ContactJacobian) -> None:
    """Fill ``fast`` and ``stiff`` from the other parts; ``y`` holds the velocities and then the bristles."""
    fast, stiff, springs, curvatures, pushes, pulls = (
        jacobian.fast,
        jacobian.stiff,
        jacobian.springs,
        jacobian.curvatures,
        jacobian.pushes,
        jacobian.pulls,
    )
    v, d, omega, turns = stiff.shape[0], pushes.shape[1] - 1, law[FREQUENCY], jacobian.turns.shape[0]
    total = pressed = power = 0.0
    for i in range(count):
        total += springs[i, 0] * springs[i, 0]
        pressed += springs[i, 0] * springs[i, 1]
        for j in range(count):
            power += (
                springs[i, 0]
                * springs[i, 1]
                * springs[j, 0]
                * springs[j, 1]
                * _dot(pushes[i, 0], pulls[j, 0])
            )
    mass, root = common_mass(pressed, power, law), math.sqrt(total)
    for i in range(v + count * d):
        for j in range(v + count * d):
            fast[i, j] = 0.0
    for i in range(v):
        for j in range(v):
            stiff[i, j] = 0.0
    for i in range(count):
        energy, slope, bristle = springs[i, 0], springs[i, 1], springs[i, 3]
        speed, force = _dot(pushes[i, 0], y), slope * energy / root
        factor = damper(root / mass, speed, mass, law)
        damping = force * (damper(root / mass, speed + SPEED_STEP, mass, law) - factor) / SPEED_STEP
        # From here on the row of the pull is that of the normal force with its friction.
        pull = pulls[i, 0]
        if d > 0:
            _add_bristle(y, i, friction * force * factor, friction, bristle * omega, omega, jacobian)
        for a in range(v):
            for b in range(v):
                fast[a, b] -= damping * pull[a] * pushes[i, 0, b]
            for b in range(turns):
                for k in range(turns):
                    stiff[a, v - turns + b] -= force * factor * curvatures[i, k, b] * jacobian.turns[k, a]
        for j in range(count):
            change = -2.0 * energy * slope * springs[j, 0] * springs[j, 1] / (root * total)
            if i == j:
                change += (2.0 * slope * slope + energy * springs[i, 2]) / root
            for a in range(v):
                for b in range(v):
                    stiff[a, b] -= change * pull[a] * pushes[j, 0, b]


@compiled
def _add_bristle(
    y: FloatArray,
    i: int,
    most: float,
    friction: float,
    stiffness: float,
    omega: float,
    jacobian: ContactJacobian,
) -> None:
    """Add the rows and columns of a bristle, whose friction is at most ``most`` (N)."""
    fast, push, pull, normal = jacobian.fast, jacobian.pushes[i], jacobian.pulls[i], jacobian.normals[i]
    v, d = push.shape[1], push.shape[0] - 1
    first, bent = v + i * d, v + d * int(jacobian.touching[i])
    trial, along = jacobian.trial, 0.0
    for a in range(d):
        trial[a] = _dot(push[1 + a], y) + y[bent + a]
        along += trial[a] * normal[a]
    size = 0.0
    for a in range(d):
        trial[a] -= along * normal[a]
        size += trial[a] * trial[a]
    size = math.sqrt(size)
    slips = stiffness * size > most
    share = most / (stiffness * size) if slips else 1.0
    for a in range(d):
        if slips:
            for j in range(v):
                pull[0, j] += friction * trial[a] / size * pull[1 + a, j]
        for b in range(d):
            stuck = -normal[a] * normal[b] - (trial[a] * trial[b] / (size * size) if slips else 0.0)
            stuck = share * (1.0 + stuck if a == b else stuck)
            fast[first + a, first + b] = omega * (stuck - (1.0 if a == b else 0.0))
            for j in range(v):
                fast[first + a, j] += omega * stuck * push[1 + b, j]
                fast[j, first + b] -= stiffness * stuck * pull[1 + a, j]
                for k in range(v):
                    fast[j, k] -= stiffness * stuck * pull[1 + a, j] * push[1 + b, k]


@compiled
def _dot(a: FloatArray, b: FloatArray) -> float:
    total = 0.0
    for j in range(a.shape[0]):
        total += a[j] * b[j]
    return total
