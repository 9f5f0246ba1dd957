"""Flights against another implementation: Fossen's 6x6 matrices, quaternions, and scipy's DOP853.

Nothing here is shared with driftform's kernels. Inertial and relative velocity are kept apart, as in Fossen,
Handbook of Marine Craft Hydrodynamics and Motion Control (2011), theorem 3.2 and section 8.1, so that the
equations do not lean on a change of frame.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from driftform.scenario import Contact, Flight, Fluid, Pipe, Release, Scenario, Segment, UniformFlow
from driftform.testing.agents import Spheroid, sphere
from driftform.testing.bodies import spheroid_body
from driftform.testing.simulator import apart, positions_at
from driftform.types import Agent, Coefficients, End, MassProperties
from driftform_exudyn.simulator import ExudynOptions, ExudynSimulator

HORIZON = 3.0
TIMES = np.linspace(0, HORIZON, 151)


def skew(a):
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def coriolis(M, nu):
    """Theorem 3.2: C(nu) from a symmetric 6x6 mass matrix."""
    force = skew(M[:3, :3] @ nu[:3] + M[:3, 3:] @ nu[3:])
    moment = skew(M[3:, :3] @ nu[:3] + M[3:, 3:] @ nu[3:])
    return -np.block([[np.zeros((3, 3)), force], [force, moment]])


def textbook_path(agent: Agent, scenario: Scenario, times):
    """Positions of the body's origin in the world frame, (k, 3)."""
    mass, coefficients = agent.mass, agent.coefficients
    rg, rb, o = mass.cog, mass.cob, coefficients.origin
    m, S = mass.mass, skew(mass.cog)
    M_RB = np.block([[m * np.eye(3), -m * S], [m * S, mass.inertia - m * S @ S]])
    # Velocity of the coefficients' origin from that of the body's origin; forces go back with its transpose.
    H = np.block([[np.eye(3), -skew(o)], [np.zeros((3, 3)), np.eye(3)]])
    M_A = H.T @ coefficients.added_mass @ H
    U = np.array([scenario.flow.speed, 0, 0])
    W = m * scenario.fluid.gravity
    B = scenario.fluid.density * mass.volume * scenario.fluid.gravity

    def rate(_, y):
        q, nu = y[3:7] / np.linalg.norm(y[3:7]), y[7:]
        w, x, yy, z = q
        R = np.array(
            [
                [w * w + x * x - yy * yy - z * z, 2 * (x * yy - w * z), 2 * (x * z + w * yy)],
                [2 * (x * yy + w * z), w * w - x * x + yy * yy - z * z, 2 * (yy * z - w * x)],
                [2 * (x * z - w * yy), 2 * (yy * z + w * x), w * w - x * x - yy * yy + z * z],
            ]
        )
        omega = nu[3:]
        current = np.concatenate([R.T @ U, np.zeros(3)])
        current_rate = np.concatenate([-np.cross(omega, R.T @ U), np.zeros(3)])
        nu_r = nu - current
        local = H @ nu_r
        drag = coefficients.linear_damping @ local + coefficients.quadratic_damping @ (np.abs(local) * local)
        up = R.T @ np.array([0, 0, 1])
        hydrostatic = np.concatenate([(B - W) * up, np.cross(rb, B * up) - np.cross(rg, W * up)])
        tau = hydrostatic - H.T @ drag - coriolis(M_RB, nu) @ nu - coriolis(M_A, nu_r) @ nu_r
        nu_dot = np.linalg.solve(M_RB + M_A, tau + M_A @ current_rate)
        q_dot = 0.5 * np.array([-q[1:] @ omega, *(q[0] * omega + np.cross(q[1:], omega))])
        return np.concatenate([R @ nu[:3], q_dot, nu_dot])

    half = np.deg2rad(scenario.release.pitch_deg) / 2
    attitude = np.array([np.cos(half), 0, np.sin(half), 0])
    turn = Rotation.from_quat(attitude, scalar_first=True)
    velocity = U if scenario.release.velocity == "current" else np.array(scenario.release.velocity)
    start = np.concatenate([scenario.release.position, attitude, turn.inv().apply(velocity), np.zeros(3)])
    solution = solve_ivp(rate, (0, times[-1]), start, method="DOP853", t_eval=times, rtol=1e-11, atol=1e-13)
    assert solution.success
    return solution.y[:3].T


def random_flight(seed: int) -> tuple[Agent, Scenario]:
    """An agent with axisymmetric added mass, everything off centre, and every other one damped."""
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
    scenario = Scenario(
        flow=UniformFlow(speed=1.0),
        fluid=Fluid(density=1024.0, gravity=9.81),
        release=Release(
            velocity=tuple(rng.uniform(-0.3, 0.3, 3) + np.array([1, 0, 0])), pitch_deg=rng.uniform(-45, 45)
        ),
        flight=Flight(horizon=HORIZON),
    )
    return agent, scenario


@cache
def expected_path(seed: int):
    path = textbook_path(*random_flight(seed), TIMES)
    assert np.linalg.norm(np.diff(path, axis=0), axis=1).sum() > 1.0, "it has to go somewhere"
    return path


def error(seed: int, **options) -> float:
    """Largest distance (m) of a flight from the textbook's."""
    flight = ExudynSimulator(ExudynOptions(**options)).simulate(*random_flight(seed))
    assert flight.end == End.HORIZON
    return apart(positions_at(flight, TIMES), expected_path(seed))


@pytest.mark.parametrize("seed", range(10))
def test_a_flight_agrees_with_fossens_equations_to_a_millimetre(seed):
    assert error(seed) < 1e-3


@pytest.mark.parametrize("seed", range(10))
def test_with_a_tight_tolerance_it_agrees_to_a_micrometre(seed):
    assert error(seed, tolerance=1e-10) < 1e-6


@pytest.mark.parametrize("integrator", ["RK67", "RK44"])
def test_the_other_integrators_fly_the_same(integrator):
    assert error(1, integrator=integrator, max_step=1e-3) < 1e-6


def test_samples_are_never_further_apart_than_the_longest_step():
    agent, scenario = random_flight(0)
    for step in (0.02, 0.005):
        flight = ExudynSimulator(ExudynOptions(max_step=step)).simulate(agent, scenario)
        assert np.diff(flight.t).max() <= step * (1 + 1e-9)


def test_too_many_steps_are_a_failed_flight():
    agent, scenario = random_flight(0)
    flight = ExudynSimulator(ExudynOptions(step_limit=20)).simulate(agent, scenario)
    assert flight.end == End.STEP_LIMIT
    assert flight.end.failed
    assert 0 < flight.t[-1] < HORIZON


def test_a_wall_without_damping_throws_the_agent_back_as_fast_as_it_came():
    agent = sphere(0.01, 1024 * 4 / 3 * np.pi * 1e-6)
    # So few edges that its widest rim alone touches: others would set it spinning.
    agent = replace(agent, body=spheroid_body(0.01, 0.01, edges=4))
    scenario = Scenario(
        pipe=Pipe(segments=(Segment(start=(0, 0, 0), end=(9, 0, 0), radius=0.2),)),
        release=Release(velocity=(1.0, 0.3, 0.4)),
        contact=Contact(damping_ratio=0.0),
        flight=Flight(horizon=0.6),
    )
    flight = ExudynSimulator(ExudynOptions(tolerance=1e-8)).simulate(agent, scenario)
    turn = Rotation.from_quat(flight.quaternion[-1], scalar_first=True)
    assert turn.apply(flight.velocity[-1, :3].copy()) == pytest.approx([1.0, -0.3, -0.4], abs=1e-5)
