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
    CROSSFLOW_FRICTION,
    CROSSFLOW_PLATEAU,
    blockage_factor,
    friction_coefficient,
    sphere_excess,
)
from driftform.motion.fields import PLANE
from driftform.motion.impact import common_mass, damper, spring
from driftform.motion.model import FlightModel
from driftform.types import FloatArray
from driftform.util.compiled import compiled
from driftform.water.parts.profiles import LOG_LAW, PARABOLA, POWER_LAW, UNIFORM, spread_profile
from driftform.water.velocity import KIND, PARAMETER, SPEED

Point: TypeAlias = tuple[float, float]
"""Components along x and z of the world, or two numbers like them."""

STATE_INDICES = (0, 2, 3, 5, 7, 9, 11)
"""Indices of the numbers that change in a state (13,): x, z, the quaternion's w and y, velocity along x and z, q."""

STRIPS = PLANE["strips"].shape[0]
"""Strips that a body with drag must have."""


def stays_in_plane(start: FloatArray, model: FlightModel) -> bool:
    """Return True if :func:`fill_rate_in_plane` describes the whole motion from the state ``start`` (13,).

    The conditions: all components across the plane are exactly zero; the water is steady, and uniform or parallel to the
    pipe; the pipe is full and straight, and its radius is at least twice the greatest distance of a surface from the
    origin (the near wall is then the same all along the body); and only weight, buoyancy, added mass, drag and the
    wall act.
    """
    n, pipe = model.numbers[0], model.pipe
    parallel = (
        model.flow[KIND] in (POWER_LAW, LOG_LAW, PARABOLA)
        and len(model.gusts) == 0
        and n["has_pressure_gradient"] != 0.0
    )
    if n["is_steady"] == 0.0 and not parallel:
        return False
    if n["water_level"] < np.inf or n["is_damped"] != 0.0:
        return False
    if len(model.strips) not in (0, STRIPS) or len(pipe) > 1 or model.fittings is not None:
        return False
    across = [*start[4:13:2], n["cog"][1], n["cob"][1], n["current"][1]]
    if len(pipe) == 1:
        if pipe[0, 7] < 2.0 * n["reach"]:
            return False
        across += [pipe[0, 1] - start[1], pipe[0, 4]]
    coupled = (m[::2, 1::2].any() or m[1::2, ::2].any() for m in (n["mass"], n["inverse"]))
    return not (any(across) or any(coupled))


def fill_plane(model: FlightModel) -> None:
    """Fill :data:`driftform.motion.fields.PLANE` in the numbers of a model from its other numbers."""
    n = model.numbers[0]
    p = n["plane"]
    weight, lift = n["body_mass"] * n["gravity"], n["displaced_mass"] * n["gravity"]
    # The flight of an agent of infinite mass or volume fails later, as not finite.
    with np.errstate(invalid="ignore"):
        p["net_weight"] = weight - lift
        p["hanging"] = weight * n["cog"][2] - lift * n["cob"][2]
        p["trim"] = weight * n["cog"][0] - lift * n["cob"][0]
    p["near"] = p["length"] = math.inf
    if len(model.pipe) == 1:
        pipe = model.pipe[0]
        p["radius"], p["near"] = pipe[7], pipe[7] - n["reach"]
        p["across"] = -pipe[5], pipe[3]
        p["inlet"], p["length"] = pipe[[0, 2]], pipe[6]
    if n["is_steady"]:
        p["stream"] = n["current"][[0, 2]]
    else:
        p["profile"], p["speed"], p["parameter"] = model.flow[[KIND, SPEED, PARAMETER]]
    if len(model.strips) == STRIPS:
        _fill_drag(model)


def _fill_drag(model: FlightModel) -> None:
    n = model.numbers[0]
    p, viscosity, density = n["plane"], n["viscosity"], n["density"]
    radius = model.pipe[0, 7] if len(model.pipe) == 1 else np.inf
    half = 0.5 * density * blockage_factor(0.5 * n["blocking"] / radius)
    area, length, ahead, astern = n["axial"]
    p["is_dragged"], p["shear_mass"] = 1.0, density * n["shear_volume"]
    p["friction_area"], p["friction_rate"] = half * area, length / viscosity
    p["ahead"], p["astern"] = half * ahead, half * astern
    p["round_area"], p["round_rate"] = half * n["round_area"], n["diameter"] / viscosity
    p["tails"] = n["tails"] * (1.0, density, 1.0, density)
    x, diameter, width, factor = model.strips.T
    p["creeping"] = n["creeping"] * ([2 * half * viscosity] * 3 + [1.0])
    whole, friction = half * factor * diameter * width, CROSSFLOW_FRICTION * n["rubbing"]
    p["strips"] = np.column_stack([x, CROSSFLOW_PLATEAU * whole, friction * whole * np.sqrt(viscosity / diameter)])


@compiled
def fill_rate_in_plane(
    y: FloatArray, n: np.record, surfaces: FloatArray, touches: FloatArray, bristles: FloatArray, out: FloatArray
) -> None:
    """Fill ``out`` with the time derivative of ``y``, the numbers of a state at :data:`STATE_INDICES`, (7,), and the bristles.

    ``n`` are the numbers of a :class:`FlightModel` after :func:`fill_plane`, ``surfaces`` and ``touches`` its own, and
    ``bristles`` is room for the components along the pipe of what :attr:`FlightModel.bristles` holds, m/s, and for their rates.
    """
    w, h, q = y[2], y[3], y[6]
    double = 2.0 / (w * w + h * h)
    # The body's axis is (c, -s) in the world, its z axis (s, c).
    c, s = 1.0 - double * h * h, double * w * h
    count, velocity = y.shape[0] - 7, (y[4], y[5])
    for k in range(count):
        bristles[k] = y[7 + k]
    out[0], out[1] = velocity
    out[2], out[3] = -0.5 * h * q, 0.5 * w * q
    p, across, stream = n.plane, n.plane.across, n.plane.stream
    along, upward = velocity[0] - stream[0], velocity[1] - stream[1]
    u, v = c * along - s * upward, s * along + c * upward
    X, Z = p.net_weight * s, -p.net_weight * c
    N = p.hanging * s + p.trim * c
    off = across[0] * (y[0] - p.inlet[0]) + across[1] * (y[1] - p.inlet[1])
    # The unit vector across the pipe, in body axes; that along the pipe is (n_b, -n_a).
    n_a = c * across[0] - s * across[1]
    n_b = s * across[0] + c * across[1]
    shear = 0.0
    if p.profile != UNIFORM:
        flow, shear = _stream(off + n_a * n.cob[0] + n_b * n.cob[2], n_a, n)
        u, v = u - n_b * flow, v + n_a * flow
    if p.is_dragged != 0.0:
        F_x, F_z, torque = _drag(u, v, q, -n_a * n_a * shear, shear, n)
        X, Z, N = X + F_x, Z + F_z, N + torque
    count, touches[0, 9] = bristles.shape[0] // 2, -1.0
    for k in range(count):
        bristles[count + k] = -n.law.frequency * bristles[k]
    if abs(off) >= p.near:
        side = 1.0 if off > 0.0 else -1.0
        approach = across[0] * velocity[0] + across[1] * velocity[1]
        sliding = across[1] * velocity[0] - across[0] * velocity[1]
        # The cross product of axis and normal is -upright along y.
        gap, n_a, n_b = p.radius - side * off, side * n_a, side * n_b
        force, rub, torque = press_in_plane(
            n_a, n_b, gap, side * approach, sliding, q, side, n, surfaces, touches, bristles
        )
        rub *= side
        X, Z, N = X - force * n_a - rub * n_b, Z - force * n_b + rub * n_a, N + torque
    mass, inverse = n.mass, n.inverse
    P_x = mass[0, 0] * u + mass[0, 2] * v + mass[0, 4] * q
    P_z = mass[0, 2] * u + mass[2, 2] * v + mass[2, 4] * q
    X, Z, N = X - P_z * q, Z + P_x * q, N + P_z * u - P_x * v
    a_x = inverse[0, 0] * X + inverse[0, 2] * Z + inverse[0, 4] * N + q * v
    a_z = inverse[0, 2] * X + inverse[2, 2] * Z + inverse[2, 4] * N - q * u
    alpha = inverse[0, 4] * X + inverse[2, 4] * Z + inverse[4, 4] * N
    out[4], out[5], out[6] = c * a_x + s * a_z, c * a_z - s * a_x, alpha
    for k in range(count):
        out[7 + k] = bristles[count + k]


@compiled
def press_in_plane(
    s: float,
    upright: float,
    gap: float,
    speed: float,
    sliding: float,
    q: float,
    side: float,
    n: np.record,
    surfaces: FloatArray,
    touches: FloatArray,
    bristles: FloatArray,
) -> tuple[float, float, float]:
    """Return the forces of all surfaces on the wall, normal to it and along the pipe (N), and the moment (N m) on the body.

    Args:
        s, upright: components of the normal along the body's x and z axes.
        gap: distance from the body's origin to the wall along the normal, m.
        speed, sliding, q: velocity of the body's origin along the normal and along the pipe, m/s, and pitch rate,
            rad/s.
        side: sign of the normal's component across the pipe.
        touches: is filled with depth, arm, twice the energy of the spring, half of its derivatives, and index of all
            surfaces that touch.
        bristles: of :func:`fill_rate_in_plane`; what friction adds to their rates is added.
    """
    law, response, steep = n.law, n.inverse, 1.0 / smoothed_sine(s)
    outward, share = upright * steep, (1.0 - s * s) * steep
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
        a_x = response[0, 0] * X + response[0, 2] * Z - response[0, 4] * moment
        a_z = response[0, 2] * X + response[2, 2] * Z - response[2, 4] * moment
        alpha = response[0, 4] * X + response[2, 4] * Z - response[4, 4] * moment
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
            k, height, most = int(row[9]), side * (gap + row[0]), n.friction * force
            rub = surfaces[k, 6] * law.frequency * (sliding + height * q + bristles[k])
            rub = min(most, max(-most, rub))
            bristles[rates + k] += rub / surfaces[k, 6]
            rubbed += rub
            moment -= rub * height
    return pressed, rubbed, moment


@compiled
def depth_in_plane(surfaces: FloatArray, k: int, s: float, share: float, gap: float) -> tuple[float, float, float]:
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
def _stream(off: float, n_a: float, n: np.record) -> tuple[float, float]:
    """Return the water's velocity along the pipe (m/s), ``off`` metres from its axis, and its derivative (1/s)."""
    p = n.plane
    square = 2.0 * n.spread_across + (n.spread_along - n.spread_across) * n_a * n_a
    along, shear, _, _ = spread_profile(p.radius, 0.0, abs(off), square, p.profile, p.speed, p.parameter)
    return along, shear if off > 0.0 else -shear


@compiled
def _drag(u: float, v: float, q: float, shear: float, curl: float, n: np.record) -> tuple[float, float, float]:
    """Return the forces (N) along x and z of the body and the moment (N m) of drag and lift.

    The same as :func:`driftform.motion.equations.drag_wrench` with shear lift, of motion in the plane: ``u``, ``v`` are
    relative to the water at the COB (m/s), ``shear`` is the derivative of v along the axis, ``curl`` the water's (1/s).
    """
    p, strips, tails = n.plane, n.plane.strips, n.plane.tails
    X, Z, N, centre = 0.0, 0.0, 0.0, n.cob[0]
    for k in range(STRIPS):
        x = strips[k, 0]
        across = v - x * q - (x - centre) * shear
        fast = abs(across)
        force = (strips[k, 1] * fast + strips[k, 2] * math.sqrt(fast)) * across
        Z -= force
        N += x * force
    along = abs(u)
    x, area = tails[0], tails[1]
    if u <= 0.0:
        x, area = tails[2], tails[3]
    if along >= SLOWEST:
        drag = p.ahead if u > 0.0 else p.astern
        if p.friction_area > 0.0:
            drag += p.friction_area * friction_coefficient(along * p.friction_rate)
        X -= drag * along * u
        across = v - x * q - (x - centre) * shear
        speed = math.sqrt(u * u + across * across)
        force = area * along * math.sqrt(0.5 * (1.0 + along / speed)) * across
        Z -= force
        N += x * force
    x, creeping = n.centre, p.creeping
    across = v - x * q - (x - centre) * shear
    force = creeping[1] * across
    turning = q - creeping[3] * curl + (1.0 - 2.0 * creeping[3]) * shear
    X, Z, N = X - creeping[0] * u, Z - force, N + x * force - creeping[2] * turning
    if p.round_area > 0.0:
        speed = math.sqrt(u * u + across * across)
        if speed >= SLOWEST:
            force = p.round_area * sphere_excess(speed * p.round_rate) * speed
            X -= force * u
            Z -= force * across
            N += x * force * across
    lift = p.shear_mass * curl
    if lift != 0.0:
        F_x = lift * (v - centre * q)
        F_z = -lift * (u + n.cob[2] * q)
        X, Z, N = X + F_x, Z + F_z, N + n.cob[2] * F_x - centre * F_z
    return X, Z, N
