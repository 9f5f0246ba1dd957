"""Motion in the vertical plane: surge, heave and pitch only, for a fraction of the work of motion in space.

A body of revolution that is released without yaw, in a steady flow parallel to a pipe in the vertical plane, never
leaves the plane of its axis and the pipe's: sway, roll and yaw are always zero, and so are their forces. Friction on the
wall acts along the pipe, and bends one number per bristle. The remaining terms of :mod:`driftform.motion.equations` are written out here. With u, v the velocities relative to the water along the
body's x and z axes, q the pitch rate, and (P_x, P_z, H) = M (u, v, q) the momentum,::

    P_x' = X - P_z q        P_z' = Z + P_x q        H' = N + P_z u - P_x v

X, Z and N are the forces and the moment of weight, buoyancy, drag and the wall. Water that flows parallel to the pipe
does not accelerate, so the relative velocity is all that a velocity profile changes.
"""

import math
from typing import TypeAlias

import numpy as np

from driftform.motion.bore import end_of_dome, smoothed_sine
from driftform.motion.drag import SLOWEST
from driftform.motion.drag_coefficients import (
    blockage_factor,
    crossflow_drag,
    friction_coefficient,
    sphere_coefficient,
)
from driftform.motion.impact import FREQUENCY, common_mass, damper, spring
from driftform.motion.model import (
    ACROSS as SPREAD_ACROSS,
)
from driftform.motion.model import (
    AXIAL_DRAG,
    BLOCKING,
    BODY_MASS,
    CENTRE,
    COB,
    COG,
    CURRENT,
    DAMPED,
    DENSITY,
    DIAMETER,
    DISPLACED_MASS,
    FRICTION,
    FROUDE_KRYLOV,
    GRAVITY,
    LENGTHWISE,
    LINEAR,
    MASS,
    REACH,
    ROUND_AREA,
    SHEAR_VOLUME,
    STEADY,
    TAILS,
    VISCOSITY,
    WATER_LEVEL,
    FlightModel,
)
from driftform.types import FloatArray
from driftform.util.compiled import compiled
from driftform.water.profiles import LOG_LAW, POWER_LAW, UNIFORM, spread_profile
from driftform.water.velocity import KIND, PARAMETER, SPEED

Point: TypeAlias = tuple[float, float]
"""Components along x and z of the world, or two numbers like them."""

STATE_INDICES = (0, 2, 3, 5, 7, 9, 11)
"""Indices of the numbers that change in a state (13,): x, z, the quaternion's w and y, velocity along x and z, q."""

# Indices in the array of a plane's model. Symmetric 3x3 matrices of surge, heave and pitch: rows from the diagonal on.
INERTIA, RESPONSE = 0, 6
_UPPER = 2 * np.array(np.triu_indices(3))
NET_WEIGHT, HANGING, TRIM = 12, 13, 14
STREAM = 15
RADIUS, NEAR = 17, 18
ACROSS, INLET, LENGTH = 19, 21, 23
PROFILE, CENTRE_X, CENTRE_Z, SPREAD = 24, 27, 28, 29
IS_DRAGGED, SHEAR_MASS, FRICTION_AREA, FRICTION_RATE, AHEAD, ASTERN = 31, 32, 33, 34, 35, 36
ROUND, ROUND_RATE, ROUND_X = 37, 38, 39
TAIL_AHEAD, TAIL_ASTERN = 40, 42
STRIP, STRIPS = 44, 5
"""Rows of x, 1/2 rho C dx d (kg/m), viscosity over d; the strips must be as many."""
LAW = STRIP + 3 * STRIPS
RUB = LAW + 8
MODEL_SIZE = RUB + 1


def stays_in_plane(start: FloatArray, model: FlightModel) -> bool:
    """Return True if :func:`fill_rate_in_plane` describes the whole motion from the state ``start`` (13,).

    The conditions: all components across the plane are exactly zero; the water is steady, and uniform or parallel to the
    pipe; the pipe is full and straight, and its radius is at least twice the greatest distance of a surface from the
    origin (the near wall is then the same all along the body); and only weight, buoyancy, added mass, drag and the
    wall act.
    """
    table, pipe = model.table, model.pipe
    parallel = (
        model.flow[KIND] in (POWER_LAW, LOG_LAW) and len(model.gusts) == 0 and table[FROUDE_KRYLOV] != 0.0
    )
    if table[STEADY] == 0.0 and not parallel:
        return False
    if table[WATER_LEVEL] < np.inf or table[DAMPED] != 0.0:
        return False
    if len(model.strips) not in (0, STRIPS) or len(pipe) > 1 or model.fittings is not None:
        return False
    coupling = table[MASS:LINEAR].reshape(2, 6, 6)
    across = [*start[4:13:2], table[COG, 1], table[COB, 1], table[CURRENT, 1]]
    if len(pipe) == 1:
        if pipe[0, 7] < 2.0 * table[REACH]:
            return False
        across += [pipe[0, 1] - start[1], pipe[0, 4]]
    return not (any(across) or coupling[:, ::2, 1::2].any() or coupling[:, 1::2, ::2].any())


def plane_model(model: FlightModel) -> FloatArray:
    """Return the input of :func:`accelerations_in_plane` except the surfaces and bristles, (68,).

    Total mass and its inverse; weight less buoyancy (N), their moments about the origin from heights and from lengths along
    the body (N m); the water's velocity (x, z); the bore's radius, and the distance from its axis beyond which a surface may
    touch (m); in the world frame, the unit vector across the bore and a point on its axis (x, z each); the bore's
    length (m). Then the velocity profile (kind, speed, parameter), the COB in body axes (x, z) and the spread of the body;
    then its drag, with densities, viscosity and the narrowness of the bore multiplied in; then the law of the contacts, and
    the coefficient of friction.
    """
    table, out = model.table, np.zeros(MODEL_SIZE)
    out[INERTIA:NET_WEIGHT] = table[MASS:LINEAR].reshape(2, 6, 6)[:, _UPPER[0], _UPPER[1]].ravel()
    weight, lift = table[BODY_MASS] * table[GRAVITY], table[DISPLACED_MASS] * table[GRAVITY]
    # The flight of an agent of infinite mass or volume fails later, as not finite.
    with np.errstate(invalid="ignore"):
        out[NET_WEIGHT] = weight - lift
        out[HANGING] = weight * table[COG, 2] - lift * table[COB, 2]
        out[TRIM] = weight * table[COG, 0] - lift * table[COB, 0]
    out[LAW:RUB], out[RUB] = model.law, table[FRICTION]
    out[STREAM], out[STREAM + 1] = table[CURRENT, 0], table[CURRENT, 2]
    out[NEAR] = out[LENGTH] = math.inf
    if len(model.pipe) == 1:
        pipe = model.pipe[0]
        out[RADIUS], out[NEAR] = pipe[7], pipe[7] - table[REACH]
        out[ACROSS], out[ACROSS + 1] = -pipe[5], pipe[3]
        out[INLET], out[INLET + 1], out[LENGTH] = pipe[0], pipe[2], pipe[6]
    if table[STEADY] == 0.0:
        out[PROFILE : PROFILE + 3] = model.flow[[KIND, SPEED, PARAMETER]]
        out[STREAM : STREAM + 2] = 0.0
    out[CENTRE_X], out[CENTRE_Z] = table[COB, 0], table[COB, 2]
    out[SPREAD], out[SPREAD + 1] = table[SPREAD_ACROSS], table[LENGTHWISE]
    if len(model.strips) == STRIPS:
        _fill_drag(model, out)
    return out


def _fill_drag(model: FlightModel, out: FloatArray) -> None:
    table, axial = model.table, model.table[AXIAL_DRAG]
    out[IS_DRAGGED], viscosity = 1.0, table[VISCOSITY]
    radius = model.pipe[0, 7] if len(model.pipe) == 1 else np.inf
    half = 0.5 * table[DENSITY] * blockage_factor(0.5 * table[BLOCKING] / radius)
    out[SHEAR_MASS] = table[DENSITY] * table[SHEAR_VOLUME]
    out[FRICTION_AREA], out[FRICTION_RATE] = half * axial[0], axial[1] / viscosity
    out[AHEAD], out[ASTERN] = half * axial[2], half * axial[3]
    out[ROUND], out[ROUND_RATE] = half * table[ROUND_AREA], table[DIAMETER] / viscosity
    out[ROUND_X] = table[CENTRE]
    out[TAIL_AHEAD], out[TAIL_AHEAD + 1] = table[TAILS, 0], table[DENSITY] * table[TAILS, 1]
    out[TAIL_ASTERN], out[TAIL_ASTERN + 1] = table[TAILS, 2], table[DENSITY] * table[TAILS, 3]
    x, diameter, width, factor = model.strips.T
    strips = np.column_stack([x, half * factor * diameter * width, viscosity / diameter])
    out[STRIP:LAW] = strips.ravel()


@compiled
def fill_rate_in_plane(
    y: FloatArray,
    plane: FloatArray,
    surfaces: FloatArray,
    touches: FloatArray,
    bristles: FloatArray,
    out: FloatArray,
) -> None:
    """Fill ``out`` with the time derivative of ``y``, the numbers of a state at :data:`STATE_INDICES`, (7,), and the bristles.

    ``plane`` is the result of :func:`plane_model`; ``surfaces`` and ``touches`` are those of its :class:`FlightModel`, and
    ``bristles`` is room for twice as many numbers as there are bristles.
    """
    w, h, q = y[2], y[3], y[6]
    double = 2.0 / (w * w + h * h)
    attitude = 1.0 - double * h * h, double * w * h
    count = y.shape[0] - 7
    for k in range(count):
        bristles[k] = y[7 + k]
    out[0], out[1] = y[4], y[5]
    out[2], out[3] = -0.5 * h * q, 0.5 * w * q
    out[4], out[5], out[6] = accelerations_in_plane(
        (y[0], y[1]), attitude, (y[4], y[5]), q, plane, surfaces, touches, bristles
    )
    for k in range(count):
        out[7 + k] = bristles[count + k]


@compiled
def accelerations_in_plane(
    position: Point,
    attitude: Point,
    velocity: Point,
    q: float,
    plane: FloatArray,
    surfaces: FloatArray,
    touches: FloatArray,
    bristles: FloatArray,
) -> tuple[float, float, float]:
    """Return the accelerations along x and z of the world (m/s2), and the pitch acceleration (rad/s2).

    Parameters
    ----------
    position, velocity
        along x and z of the world (m, m/s).
    attitude
        cosine and sine of the pitch: the body's axis is (cos, -sin) in the world, its z axis (sin, cos).
    q
        pitch rate (rad/s).
    plane
        the result of :func:`plane_model`.
    surfaces, touches
        those of its :class:`FlightModel`.
    bristles
        the components along the pipe of what :attr:`FlightModel.bristles` holds, m/s; the second half is filled with their
        rates, m/s2.
    """
    c, s = attitude
    along, upward = velocity[0] - plane[STREAM], velocity[1] - plane[STREAM + 1]
    u, v = c * along - s * upward, s * along + c * upward
    X, Z = plane[NET_WEIGHT] * s, -plane[NET_WEIGHT] * c
    N = plane[HANGING] * s + plane[TRIM] * c
    off = offset_in_plane(position, plane)
    # The unit vector across the pipe, in body axes; that along the pipe is (n_b, -n_a).
    n_a = c * plane[ACROSS] - s * plane[ACROSS + 1]
    n_b = s * plane[ACROSS] + c * plane[ACROSS + 1]
    shear = 0.0
    if plane[PROFILE] != UNIFORM:
        stream, shear = _stream(off + n_a * plane[CENTRE_X] + n_b * plane[CENTRE_Z], n_a, plane)
        u, v = u - n_b * stream, v + n_a * stream
    if plane[IS_DRAGGED] != 0.0:
        F_x, F_z, torque = _drag(u, v, q, -n_a * n_a * shear, shear, plane)
        X, Z, N = X + F_x, Z + F_z, N + torque
    count, touches[0, 9] = bristles.shape[0] // 2, -1.0
    for k in range(count):
        bristles[count + k] = -plane[LAW + FREQUENCY] * bristles[k]
    if abs(off) >= plane[NEAR]:
        side = 1.0 if off > 0.0 else -1.0
        across = plane[ACROSS] * velocity[0] + plane[ACROSS + 1] * velocity[1]
        sliding = plane[ACROSS + 1] * velocity[0] - plane[ACROSS] * velocity[1]
        # The cross product of axis and normal is -upright along y.
        gap, n_a, n_b = plane[RADIUS] - side * off, side * n_a, side * n_b
        force, rub, torque = press_in_plane(
            n_a, n_b, gap, side * across, sliding, q, side, plane, surfaces, touches, bristles
        )
        rub *= side
        X, Z, N = X - force * n_a - rub * n_b, Z - force * n_b + rub * n_a, N + torque
    P_x = plane[INERTIA] * u + plane[INERTIA + 1] * v + plane[INERTIA + 2] * q
    P_z = plane[INERTIA + 1] * u + plane[INERTIA + 3] * v + plane[INERTIA + 4] * q
    X, Z, N = X - P_z * q, Z + P_x * q, N + P_z * u - P_x * v
    a_x = plane[RESPONSE] * X + plane[RESPONSE + 1] * Z + plane[RESPONSE + 2] * N + q * v
    a_z = plane[RESPONSE + 1] * X + plane[RESPONSE + 3] * Z + plane[RESPONSE + 4] * N - q * u
    alpha = plane[RESPONSE + 2] * X + plane[RESPONSE + 4] * Z + plane[RESPONSE + 5] * N
    return c * a_x + s * a_z, c * a_z - s * a_x, alpha


@compiled
def offset_in_plane(position: Point, plane: FloatArray) -> float:
    """Return the distance (m) of the position (x, z) from the axis of the pipe, along the unit vector across it."""
    x, z = position[0] - plane[INLET], position[1] - plane[INLET + 1]
    return float(plane[ACROSS] * x + plane[ACROSS + 1] * z)


@compiled
def press_in_plane(
    s: float,
    upright: float,
    gap: float,
    speed: float,
    sliding: float,
    q: float,
    side: float,
    plane: FloatArray,
    surfaces: FloatArray,
    touches: FloatArray,
    bristles: FloatArray,
) -> tuple[float, float, float]:
    """Return the forces of all surfaces on the wall, normal to it and along the pipe (N), and the moment (N m) on the body.

    Parameters
    ----------
    s, upright
        components of the normal along the body's x and z axes.
    gap
        distance from the body's origin to the wall along the normal, m.
    speed, sliding, q
        velocity of the body's origin along the normal and along the pipe, m/s, and pitch rate, rad/s.
    side
        sign of the normal's component across the pipe.
    touches
        is filled with depth, arm, twice the energy of the spring, half of its derivatives, and index of all surfaces that touch.
    bristles
        see :func:`accelerations_in_plane`; what friction adds to their rates is added.
    """
    law = plane[LAW:RUB]
    inverse = 1.0 / smoothed_sine(s)
    outward, share = upright * inverse, (1.0 - s * s) * inverse
    total, pressed, moment, mass, count = 0.0, 0.0, 0.0, 0.0, 0
    for k in range(surfaces.shape[0]):
        depth, x, r = depth_in_plane(surfaces, k, s, share, gap)
        if depth > 0.0:
            mass, energy, force, turning = spring(s, x, r, depth, law)
            arm, row = x * upright - r * outward * s, touches[count]
            total += energy * energy
            pressed += energy * force
            moment += energy * force * arm
            row[0], row[1], row[2], row[3], row[4], row[9] = depth, arm, energy, force, turning, k
            count += 1
    touches[count, 9] = -1.0
    if not total > 0.0:
        return 0.0, 0.0, 0.0
    if count > 1:
        # The wrench of all springs, and the acceleration that it gives to the body.
        X, Z = pressed * s, pressed * upright
        a_x = plane[RESPONSE] * X + plane[RESPONSE + 1] * Z - plane[RESPONSE + 2] * moment
        a_z = plane[RESPONSE + 1] * X + plane[RESPONSE + 3] * Z - plane[RESPONSE + 4] * moment
        alpha = plane[RESPONSE + 2] * X + plane[RESPONSE + 4] * Z - plane[RESPONSE + 5] * moment
        mass = common_mass(pressed, X * a_x + Z * a_z - moment * alpha, law)
    root, rates = math.sqrt(total), bristles.shape[0] // 2
    pressed, moment, rubbed = 0.0, 0.0, 0.0
    for i in range(count):
        row = touches[i]
        arm, share = row[1], row[2] / root
        force = row[3] * share * damper(root / mass, speed - arm * q, mass, law)
        pressed += force
        moment += force * arm + row[4] * share * outward
        if rates > 0:
            k, height, most = int(row[9]), side * (gap + row[0]), plane[RUB] * force
            rub = surfaces[k, 6] * law[FREQUENCY] * (sliding + height * q + bristles[k])
            rub = min(most, max(-most, rub))
            bristles[rates + k] += rub / surfaces[k, 6]
            rubbed += rub
            moment -= rub * height
    return pressed, rubbed, moment


@compiled
def depth_in_plane(
    surfaces: FloatArray, k: int, s: float, share: float, gap: float
) -> tuple[float, float, float]:
    """Return the depth (m) of a surface in the wall, negative if it is clear, and the rim (x, r) that touches, m.

    Of a dome, that is its centre. ``s`` and ``gap`` are those of :func:`press_in_plane`, ``share`` is (1 - s^2) over the
    smoothed sine of s.
    """
    x, r, radius = surfaces[k, 0], surfaces[k, 1], surfaces[k, 2]
    if radius > 0.0:
        if surfaces[k, 3] <= s <= surfaces[k, 4]:
            return x * s + radius - gap, x, r
        x, r = end_of_dome(surfaces, k, s)
    return x * s + r * share - gap, x, r


@compiled
def _stream(off: float, n_a: float, plane: FloatArray) -> tuple[float, float]:
    """Return the water's velocity along the pipe (m/s), ``off`` metres from its axis, and its derivative (1/s)."""
    square = 2.0 * plane[SPREAD] + (plane[SPREAD + 1] - plane[SPREAD]) * n_a * n_a
    along, shear, _, _ = spread_profile(
        plane[RADIUS], 0.0, abs(off), square, plane[PROFILE], plane[PROFILE + 1], plane[PROFILE + 2]
    )
    return along, shear if off > 0.0 else -shear


@compiled
def _drag(
    u: float, v: float, q: float, shear: float, curl: float, plane: FloatArray
) -> tuple[float, float, float]:
    """Return the forces (N) along x and z of the body and the moment (N m) of drag and lift.

    The same as :func:`driftform.motion.equations.drag_wrench` with shear lift, of motion in the plane: ``u``, ``v`` are
    relative to the water at the COB (m/s), ``shear`` is the derivative of v along the axis, ``curl`` the water's (1/s).
    """
    X, Z, N, centre = 0.0, 0.0, 0.0, plane[CENTRE_X]
    for k in range(STRIPS):
        x, mass, scale = plane[STRIP + 3 * k], plane[STRIP + 3 * k + 1], plane[STRIP + 3 * k + 2]
        across = v - x * q - (x - centre) * shear
        force = mass * crossflow_drag(abs(across), scale) * across
        Z -= force
        N += x * force
    along = abs(u)
    x, area = plane[TAIL_AHEAD], plane[TAIL_AHEAD + 1]
    if u <= 0.0:
        x, area = plane[TAIL_ASTERN], plane[TAIL_ASTERN + 1]
    if along >= SLOWEST:
        drag = plane[AHEAD] if u > 0.0 else plane[ASTERN]
        if plane[FRICTION_AREA] > 0.0:
            drag += plane[FRICTION_AREA] * friction_coefficient(along * plane[FRICTION_RATE])
        X -= drag * along * u
        across = v - x * q - (x - centre) * shear
        speed = math.sqrt(u * u + across * across)
        force = area * along * math.sqrt(0.5 * (1.0 + along / speed)) * across
        Z -= force
        N += x * force
    if plane[ROUND] > 0.0:
        x = plane[ROUND_X]
        across = v - x * q - (x - centre) * shear
        speed = math.sqrt(u * u + across * across)
        if speed >= SLOWEST:
            force = plane[ROUND] * sphere_coefficient(speed * plane[ROUND_RATE]) * speed
            X -= force * u
            Z -= force * across
            N += x * force * across
    lift = plane[SHEAR_MASS] * curl
    if lift != 0.0:
        F_x = lift * (v - centre * q)
        F_z = -lift * (u + plane[CENTRE_Z] * q)
        X, Z, N = X + F_x, Z + F_z, N + plane[CENTRE_Z] * F_x - centre * F_z
    return X, Z, N


@compiled
def has_left_in_plane(position: Point, plane: FloatArray) -> bool:
    """Return what :func:`driftform.motion.flight.has_left_pipe` does, for the position (x, z), m."""
    x, z = position[0] - plane[INLET], position[1] - plane[INLET + 1]
    along = plane[ACROSS + 1] * x - plane[ACROSS] * z
    return bool(along >= plane[LENGTH] or along < -plane[RADIUS])


@compiled
def is_near_in_plane(position: Point, plane: FloatArray) -> bool:
    """Return True if a surface of a body at the position (x, z), m, may touch the wall."""
    return bool(abs(offset_in_plane(position, plane)) >= plane[NEAR])
