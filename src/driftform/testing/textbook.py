"""Flights by another implementation: Fossen's 6x6 matrices, quaternions, and scipy's DOP853.

This module shares no code with driftform's kernels. Inertial and relative velocity are separate, as in Fossen,
Handbook of Marine Craft Hydrodynamics and Motion Control (2011), theorem 3.2 and section 8.1, so that the
equations do not rely on a change of frame. They hold in a uniform current along x, clear of any wall.

This module needs scipy, which is not a dependency of driftform.
"""

from collections.abc import Callable
from typing import ParamSpec, TypeVar

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from driftform.scenario import FlightLimits, Fluid, Release, Scenario, UniformFlow
from driftform.testing.agents import Spheroid
from driftform.testing.simulator import largest_distance
from driftform.trajectory.interpolation import interpolate_positions
from driftform.types import Agent, Coefficients, FloatArray, MassProperties, Trajectory

P = ParamSpec("P")
R = TypeVar("R")

SPACING = 0.01
"""Greatest time (s) between the instants at which two flights are compared."""


def textbook_states(
    agent: Agent, scenario: Scenario, times: FloatArray, rtol: float = 1e-11, atol: float = 1e-13
) -> FloatArray:
    """Return position (world, m), quaternion, and velocity over ground (body axes, SI) at ``times`` (s, (k,)), (k, 13)."""
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
    arguments = (M_RB, M_A, H, *damping, mass.cog.copy(), mass.cob.copy(), W, B, U)

    turn = Rotation.from_euler("ZY", [scenario.release.yaw_deg, scenario.release.pitch_deg], degrees=True)
    attitude = turn.as_quat(scalar_first=True)
    released = scenario.release.velocity
    known = {"current": U, "rest": np.zeros(3)}
    velocity = known[released] if isinstance(released, str) else np.array(released)
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


def distance_from_textbook(trajectory: Trajectory, agent: Agent, scenario: Scenario, until: float) -> float:
    """Return the greatest distance (m) from the textbook's flight between the release and ``until`` (s)."""
    times = np.linspace(0, until, int(until / SPACING) + 2)
    return largest_distance(
        interpolate_positions(trajectory, times), textbook_states(agent, scenario, times)[:, :3]
    )


def random_case(seed: int, horizon: float = 3.0) -> tuple[Agent, Scenario]:
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


def _skew(a: FloatArray) -> FloatArray:
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def _compiled(function: Callable[P, R]) -> Callable[P, R]:
    # A tight tolerance takes 150 000 evaluations, so compile them; they still use matrices, as in the book.
    fast: Callable[P, R] = njit(cache=True)(function)
    return fast


@_compiled
def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


@_compiled
def _coriolis(M: FloatArray, nu: FloatArray) -> FloatArray:
    """Return C(nu) nu of theorem 3.2 for a symmetric 6x6 mass matrix."""
    force, moment = M[:3] @ nu, M[3:] @ nu
    out = np.empty(6)
    out[:3] = -_cross(force, nu[3:])
    out[3:] = -_cross(force, nu[:3]) - _cross(moment, nu[3:])
    return out


@_compiled
def _state_rate(
    y: FloatArray,
    M_RB: FloatArray,
    M_A: FloatArray,
    H: FloatArray,
    D_1: FloatArray,
    D_2: FloatArray,
    cog: FloatArray,
    cob: FloatArray,
    W: float,
    B: float,
    U: FloatArray,
) -> FloatArray:
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
    current[:3] = R.T @ U
    current_rate[:3] = -_cross(omega, current[:3])
    nu_r = nu - current
    local = H @ nu_r
    drag = D_1 @ local + D_2 @ (np.abs(local) * local)
    up = R[2].copy()
    hydrostatic = np.empty(6)
    hydrostatic[:3] = (B - W) * up
    hydrostatic[3:] = _cross(cob, B * up) - _cross(cog, W * up)
    tau = hydrostatic - H.T @ drag - _coriolis(M_RB, nu) - _coriolis(M_A, nu_r)
    out = np.empty(13)
    out[:3] = R @ nu[:3]
    out[3] = -0.5 * np.sum(q[1:] * omega)
    out[4:7] = 0.5 * (w * omega + _cross(q[1:], omega))
    out[7:] = np.linalg.solve(M_RB + M_A, tau + M_A @ current_rate)
    return out
