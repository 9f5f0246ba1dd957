"""Flights by another implementation: Fossen's 6x6 matrices, quaternions, and scipy's DOP853.

This module shares no code with driftform's kernels. Inertial and relative velocity are separate, as in Fossen,
Handbook of Marine Craft Hydrodynamics and Motion Control (2011), theorem 3.2 and section 8.1, so that the
equations do not rely on a change of frame. They hold in a uniform current along x, or in the logarithmic law in a smooth
pipe along x, clear of any wall. Viscous forces, with the coefficients of :class:`driftform.types.Drag`, are written
with vectors, from the sources that :mod:`driftform.motion.forces.drag_coefficients` names.

This module needs scipy, which is not a dependency of driftform.
"""

from typing import ParamSpec, TypeVar

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from driftform.motion.path.interpolation import interpolate_positions
from driftform.testing.agents import Spheroid
from driftform.testing.simulator import largest_distance
from driftform.types import Agent, Coefficients, Drag, MassProperties
from driftform.water import Fluid, Scenario
from driftform.water.flow import LogLawFlow, UniformFlow
from driftform.water.scenario import FlightLimits, Release

P = ParamSpec("P")
R = TypeVar("R")

SPACING = 0.01
"""Greatest time (s) between the instants at which two flights are compared."""


def textbook_states(agent, scenario, times, rtol=1e-11, atol=1e-13):
    """Return position (world, m), quaternion, and velocity over ground (body axes, SI) at ``times`` (s, (k,)), (k, 13)."""
    arguments = _arguments(agent, scenario)
    U, profile = np.array([scenario.flow.speed, 0.0, 0.0]), _profile(scenario)
    turn = Rotation.from_euler("ZY", [scenario.release.yaw_deg, scenario.release.pitch_deg], degrees=True)
    attitude = turn.as_quat(scalar_first=True)
    released = scenario.release.velocity
    known = {"current": U, "rest": np.zeros(3)}
    velocity = known[released] if isinstance(released, str) else np.array(released)
    if len(profile) and released == "current":
        velocity = np.array([_axial_velocity(np.hypot(*scenario.release.position[1:]), profile)[0], 0.0, 0.0])
    start = np.concatenate([scenario.release.position, attitude, turn.inv().apply(velocity), np.zeros(3)])
    solution = solve_ivp(
        lambda _, y: _state_rate(y, *arguments),
        (0, times[-1]),
        start,
        method="DOP853",
        t_eval=times,
        rtol=rtol,
        atol=atol,
    )
    assert solution.success, solution.message
    return np.ascontiguousarray(solution.y.T, dtype=np.float64)


def textbook_rate(agent, scenario, state):
    """Return the time derivative (13,) of a state as :func:`textbook_states` returns it."""
    return np.asarray(_state_rate(np.asarray(state, dtype=np.float64), *_arguments(agent, scenario)))


def distance_from_textbook(trajectory, agent, scenario, until):
    """Return the greatest distance (m) from the textbook's flight between the release and ``until`` (s)."""
    times = np.linspace(0, until, int(until / SPACING) + 2)
    return largest_distance(interpolate_positions(trajectory, times), textbook_states(agent, scenario, times)[:, :3])


def random_case(seed, horizon=3.0):
    """Return an agent in open water with axisymmetric added mass and all centres off the origin; odd seeds have damping."""
    rng = np.random.default_rng(seed)
    body = Spheroid(rng.uniform(0.03, 0.1), rng.uniform(0.012, 0.025)).agent().body
    volume = 4 / 3 * np.pi * (body.length / 2) * (body.max_diameter / 2) ** 2
    mass = 1024 * volume * rng.uniform(0.8, 1.2)
    size = mass * (body.length / 2) ** 2
    along, across, turning = (
        mass * rng.uniform(0.05, 0.5),
        mass * rng.uniform(0.6, 1.2),
        size * rng.uniform(0.05, 0.2),
    )
    added = np.diag([along, across, across, 0.0, turning, turning])
    coupling = rng.uniform(-0.3, 0.3) * np.sqrt(across * turning)
    added[1, 5] = added[5, 1] = coupling
    added[2, 4] = added[4, 2] = -coupling
    assert np.linalg.eigvalsh(added).min() > -1e-15
    skewed = rng.normal(size=(3, 3))
    inertia = size * (np.diag([0.05, 0.2, 0.22]) + 0.003 * (skewed + skewed.T))
    damped = seed % 2
    coefficients = Coefficients(
        added,
        origin=np.array([rng.uniform(-0.01, 0.01), 0, 0]),
        linear_damping=damped * np.diag(rng.uniform(0.01, 0.1, 6) * [1, 1, 1, 1e-4, 1e-3, 1e-3]),
        quadratic_damping=damped * np.diag(rng.uniform(0.1, 1.0, 6) * [1, 1, 1, 1e-6, 1e-5, 1e-5]),
    )
    agent = Agent(
        body,
        MassProperties(mass, rng.uniform(-3e-3, 3e-3, 3), inertia, volume, rng.uniform(-3e-3, 3e-3, 3)),
        coefficients,
    )
    x, y, z = rng.uniform(-0.3, 0.3, 3) + np.array([1, 0, 0])
    scenario = Scenario(
        flow=UniformFlow(speed=1.0),
        fluid=Fluid(density=1024.0, gravity=9.81),
        release=Release(velocity=(float(x), float(y), float(z)), pitch_deg=float(rng.uniform(-45, 45))),
        flight=FlightLimits(horizon=horizon),
    )
    return agent, scenario


def _arguments(agent, scenario):
    """Return what :func:`_state_rate` needs besides the state."""
    mass, coefficients = agent.mass, agent.coefficients
    m, S = mass.mass, _skew(mass.cog)
    M_RB = np.block([[m * np.eye(3), -m * S], [m * S, mass.inertia - m * S @ S]])
    # H maps the velocity of the body's origin to that of the coefficients' origin; its transpose maps forces back.
    H = np.block([[np.eye(3), -_skew(coefficients.origin)], [np.zeros((3, 3)), np.eye(3)]])
    M_A = H.T @ coefficients.added_mass @ H
    U = np.array([scenario.flow.speed, 0.0, 0.0])
    W = m * scenario.fluid.gravity
    B = scenario.fluid.density * mass.volume * scenario.fluid.gravity
    damping = (coefficients.linear_damping.copy(), coefficients.quadratic_damping.copy())
    water = np.array([scenario.fluid.density, scenario.fluid.viscosity])
    drag = _drag_numbers(coefficients.drag or Drag(np.empty((0, 4))))
    centres = mass.cog.copy(), mass.cob.copy()
    return M_RB, M_A, H, *damping, *centres, W, B, U, _profile(scenario), water, *drag


def _profile(scenario):
    """Return bulk speed, u* / kappa (m/s) and radius of a smooth pipe, (3,); (0,) in a uniform current."""
    if not isinstance(scenario.flow, LogLawFlow):
        return np.empty(0)
    U, radius = scenario.flow.speed, scenario.pipe.segments[0].radius
    reynolds = 2 * radius * U / scenario.fluid.viscosity
    # Prandtl's law for f, and u* = U sqrt(f / 8).
    f = brentq(lambda f: 1 / np.sqrt(f) - 2 * np.log10(reynolds * np.sqrt(f) / 2.51), 1e-3, 1.0, xtol=1e-15)
    return np.array([U, U * np.sqrt(f / 8) / 0.4, radius])


def _drag_numbers(drag):
    """Return all numbers but the strips, and the strips."""
    numbers = [drag.friction_area, drag.length, drag.ahead, drag.astern, drag.round_area, drag.diameter]
    numbers += [drag.centre, *drag.wake_ahead, *drag.wake_astern, drag.spin, drag.shear_volume]
    numbers += [*drag.spread, drag.blocking, *drag.creeping, drag.rubbing]
    return np.array(numbers), drag.strips.copy()


def _skew(a):
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def _compiled(function):
    # A tight tolerance takes 150 000 evaluations, so compile them; they still use matrices, as in the book.
    fast = njit(cache=True)(function)
    return fast


@_compiled
def _cross(a, b):
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


@_compiled
def _coriolis(M, nu):
    """Return C(nu) nu of theorem 3.2 for a symmetric 6x6 mass matrix."""
    force, moment = M[:3] @ nu, M[3:] @ nu
    out = np.empty(6)
    out[:3] = -_cross(force, nu[3:])
    out[3:] = -_cross(force, nu[:3]) - _cross(moment, nu[3:])
    return out


@_compiled
def _axial_velocity(r, profile):
    """Return the velocity of the logarithmic law and its derivative, r from the axis."""
    U, scale, radius = profile[0], profile[1], profile[2]
    return U + scale * (1.5 + np.log(1 - r / radius)), -scale / (radius - r)


@_compiled
def _water(place, axis, profile, numbers):
    """Return the water's velocity, averaged over the body, and its gradient du_i/dx_j."""
    velocity, gradient = np.zeros(3), np.zeros((3, 3))
    # The mean square distance from the pipe's axis is that of the centre and that of the body about its centre.
    covariance = numbers[13] * np.eye(3) + (numbers[14] - numbers[13]) * np.outer(axis, axis)
    r = np.sqrt(place[1] ** 2 + place[2] ** 2 + covariance[1, 1] + covariance[2, 2])
    velocity[0], slope = _axial_velocity(r, profile)
    if r > 0:
        gradient[0] = slope * np.array([0.0, place[1], place[2]]) / r
    return velocity, gradient


@_compiled
def _skin_friction(Re):
    if Re < 5e5:
        return float(1.328 / np.sqrt(Re))
    A = 5e5 * (0.075 / (np.log10(5e5) - 2) ** 2 - 1.328 / np.sqrt(5e5))
    return float(0.075 / (np.log10(Re) - 2) ** 2 - A / Re)


@_compiled
def _viscous(nu_r, cob, shear, curl, water, radius, n, strips):
    """Return force and moment of drag and lift in body axes, (6,)."""
    rho, viscosity = water
    v, omega, x_axis = nu_r[:3].copy(), nu_r[3:].copy(), np.array([1.0, 0.0, 0.0])
    tau, other = np.zeros(6), np.zeros(6)
    for k in range(len(strips)):
        x, d, dx, factor = strips[k]
        at = x * x_axis
        local = v + _cross(omega, at) - (x - cob[0]) * shear
        local[0] = 0.0
        speed = np.sqrt(np.sum(local**2))
        if speed > 0:
            Re = speed * d / viscosity
            C = 1.18 + n[20] * 1.96 * Re**-0.5
            force = -0.5 * rho * C * factor * d * dx * speed * local
            tau[:3] += force
            tau[3:] += _cross(at, force)
    u = v[0]
    if u != 0:
        area = n[2] if u > 0 else n[3]
        tau[0] -= 0.5 * rho * (area + _skin_friction(abs(u) * n[1] / viscosity) * n[0]) * u * abs(u)
    at = n[6] * x_axis
    local = v + _cross(omega, at) - (n[6] - cob[0]) * shear
    local[0] = u
    speed = np.sqrt(np.sum(local**2))
    if n[4] > 0 and speed > 0:
        Re = speed * n[5] / viscosity
        C = 24 / Re * 0.15 * Re**0.687 + 0.42 / (1 + 42500 / Re**1.16)
        force = -0.5 * rho * C * n[4] * speed * local
        tau[:3] += force
        tau[3:] += _cross(at, force)
    # Stokes resistance, and Jeffery's couple: the strain of the water turns the axis x' by x' x (S x').
    force = -rho * viscosity * np.array([n[16], n[17], n[17]]) * local
    strain = shear - 0.5 * _cross(curl, x_axis)
    turn = omega - 0.5 * curl - (1 - 2 * n[19]) * _cross(x_axis, strain)
    tau[:3] += force
    tau[3:] += _cross(at, force) - rho * viscosity * n[18] * np.array([0.0, turn[1], turn[2]])
    b = min(0.95, n[15] / (2 * radius))
    tau *= (1 + 1.45 * b**4.5) / (1 - b**2) ** 2
    x, area = (n[7], n[8]) if u > 0 else (n[9], n[10])
    at = x * x_axis
    local = v + _cross(omega, at) - (x - cob[0]) * shear
    local[0] = 0.0
    angle = np.arctan2(np.sqrt(np.sum(local**2)), abs(u))
    force = -rho * area * abs(u) * np.cos(angle / 2) * local
    other[:3] += force
    other[3:] += _cross(at, force)
    p = abs(omega[0])
    if n[11] > 0 and p > 0:
        Re = p * n[5] ** 2 / 4 / viscosity
        C = (3.507 * np.log10(max(Re, 40.0)) - 2.565) ** -2 * max(Re, 40.0) / Re
        other[3] -= 0.5 * rho * C * n[11] * omega[0] * p
    # Auton: rho V C_L (u - v) x curl u at the centre of buoyancy, for a shear that is weak beside the slip.
    slip = -(v + _cross(omega, cob))
    speed, difference = np.sqrt(np.sum(slip**2)), n[5] * np.sqrt(np.sum(curl**2))
    force = rho * n[12] * _cross(slip, curl) / (1 + (difference / max(speed, 1e-30)) ** 4)
    other[:3] += force
    other[3:] += _cross(cob, force)
    return tau + other


@_compiled
def _state_rate(y, M_RB, M_A, H, D_1, D_2, cog, cob, W, B, U, profile, water, numbers, strips):
    q, nu = y[3:7] / np.sqrt(np.sum(y[3:7] ** 2)), y[7:].copy()
    w, x, yy, z = q
    R = np.array(
        [
            [w * w + x * x - yy * yy - z * z, 2 * (x * yy - w * z), 2 * (x * z + w * yy)],
            [2 * (x * yy + w * z), w * w - x * x + yy * yy - z * z, 2 * (yy * z - w * x)],
            [2 * (x * z - w * yy), 2 * (yy * z + w * x), w * w - x * x - yy * yy + z * z],
        ]
    )
    omega = nu[3:]
    current, current_rate = np.zeros(6), np.zeros(6)
    stream, gradient, radius = U, np.zeros((3, 3)), np.inf
    if len(profile) > 0:
        stream, gradient = _water(y[:3] + R @ cob, R[:, 0].copy(), profile, numbers)
        radius = profile[2]
    current[:3] = R.T @ stream
    current_rate[:3] = -_cross(omega, current[:3])
    nu_r = nu - current
    local = H @ nu_r
    drag = D_1 @ local + D_2 @ (np.abs(local) * local)
    up = R[2].copy()
    hydrostatic = np.empty(6)
    hydrostatic[:3] = (B - W) * up
    hydrostatic[3:] = _cross(cob, B * up) - _cross(cog, W * up)
    tau = hydrostatic - H.T @ drag - _coriolis(M_RB, nu) - _coriolis(M_A, nu_r)
    if len(strips) > 0:
        shear = R.T @ (gradient @ R[:, 0].copy())
        curl = R.T @ np.array([0.0, gradient[0, 2], -gradient[0, 1]])
        tau += _viscous(nu_r, cob, shear, curl, water, radius, numbers, strips)
    out = np.empty(13)
    out[:3] = R @ nu[:3]
    out[3] = -0.5 * np.sum(q[1:] * omega)
    out[4:7] = 0.5 * (w * omega + _cross(q[1:], omega))
    out[7:] = np.linalg.solve(M_RB + M_A, tau + M_A @ current_rate)
    return out
