"""Bodies that hit, leave and rest on a wall: the restitution, the depth at rest, and the energy."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from driftform.motion.forces.contact import deepest_depth
from driftform.motion.forces.impact import DEEPEST
from driftform.motion.forces.model import flight_model
from driftform.motion.forces.rates import fill_rate
from driftform.motion.forces.state import release_state
from driftform.motion.path.trajectory import energies
from driftform.motion.solver.error import Accuracy, integrate
from driftform.testing.agents import DENSITY, Spheroid, sphere_agent
from driftform.testing.bodies import cylinder_body, spheroid_body
from driftform.testing.simulator import water_scenario
from driftform.types import Agent, Coefficients, MassProperties
from driftform.util.rotations import rotation_from_quaternion
from driftform.water import Fluid
from driftform.water.scenario import Release

VISCOSITY = 1e-6
SPHERE_MASS = 1.2 * DENSITY * 4 / 3 * math.pi * 0.01**3
TIGHT = Accuracy(position=math.inf, tolerance=1e-10, tightest=1e-11)


def cylinder_agent(length=0.1, radius=0.01):
    volume = math.pi * radius**2 * length
    mass = 1.2 * DENSITY * volume
    inertia = mass * np.diag([radius**2 / 2, *[(3 * radius**2 + length**2) / 12] * 2])
    added = DENSITY * volume * np.diag([0.06, 0.9, 0.9, 0.0, *[0.8 * length**2 / 12] * 2])
    properties = MassProperties(mass, np.zeros(3), inertia, volume, np.zeros(3))
    return Agent(cylinder_body(length, radius), properties, Coefficients(added))


def spheroid_agent(edges):
    return replace(Spheroid(0.06, 0.01).agent(), body=spheroid_body(0.06, 0.01, edges))


BODIES = {
    "sphere of 24 edges": (sphere_agent(0.01, SPHERE_MASS), 0.0),
    "cylinder broadside": (cylinder_agent(), 0.0),
    "spheroid of 24 edges": (spheroid_agent(24), 0.0),
    "spheroid of 144 edges": (spheroid_agent(144), 0.0),
}


def hit(agent, speed, restitution, pitch=0.0, radius=0.3):
    """Samples of a body that meets the crown at a speed, and the model; there is no weight."""
    height = radius - agent.body.max_diameter / 2 - 0.002 - 0.06 * math.sin(abs(math.radians(pitch)))
    there = {"position": (1.0, 0.0, height), "pitch_deg": pitch, "pipe": (9.0, radius), "restitution": restitution}
    fluid = Fluid(density=DENSITY, gravity=0.0, viscosity=VISCOSITY)
    scenario = water_scenario(0.02 / speed + 0.1, (0.0, 0.0, speed), **there, fluid=fluid)
    model = flight_model(agent, scenario)
    return integrate(model, release_state(model, scenario), scenario.flight.horizon, TIGHT).samples, model


def depths(samples, model):
    """How deep the body is in the wall at each sample, m."""
    return np.array([deepest_depth(tuple(row[1:4]), rotation_from_quaternion(*row[4:8]), model) for row in samples])


def law(model, agent, speed, restitution):
    """e_dry exp(-35 / St), St = m v / (6 pi mu R^2), with the mass that moves across the axis."""
    mass, radius = model.numbers[0]["mass"][2, 2], agent.body.max_diameter / 2
    return restitution * math.exp(-35 * 6 * math.pi * VISCOSITY * DENSITY * radius**2 / (mass * speed))


@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize("speed", [0.02, 0.1, 0.3, 1.0])
@pytest.mark.parametrize("restitution", [0.3, 0.7, 0.97])
def test_a_body_that_hits_the_wall_broadside_returns_with_the_restitution_of_its_stokes_number(
    body, speed, restitution
):
    agent, pitch = BODIES[body]
    samples, model = hit(agent, speed, restitution, pitch=pitch)
    assert samples[-1, 10] < 0, "it leaves"
    assert -samples[-1, 10] / speed == pytest.approx(law(model, agent, speed, restitution), abs=0.05)


@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize("pitch", [0.0, 3.0, 30.0])
@pytest.mark.parametrize("restitution", [1.0, 0.7])
def test_the_energy_never_rises_over_a_contact(body, pitch, restitution):
    samples, model = hit(BODIES[body][0], 1.0, restitution, pitch=pitch)
    kinetic = np.array([energies(row, model)[0] for row in samples])
    free = kinetic[depths(samples, model) == 0]
    # Springs hold energy in between: what counts is how far the kinetic energy gets above its least since then.
    assert len(free) < len(kinetic) and kinetic.max() <= kinetic[0] * 1.002
    assert (free[1:] <= free[:-1] + 0.002 * kinetic[0]).all()


@pytest.mark.parametrize("body", BODIES)
def test_a_body_sinks_into_the_wall_by_less_than_a_millimetre(body):
    for speed in (0.3, 1.0, 3.0):
        samples, model = hit(BODIES[body][0], speed, 0.7)
        assert 0 < depths(samples, model).max() < DEEPEST * (1.0 if speed <= 1 else 1.5)


# At rest.


@pytest.mark.parametrize("edges", [24, 144])
@pytest.mark.parametrize("attitude", [(0.0, 0.0), (40.0, 0.0), (90.0, 0.0), (25.0, 70.0), (-60.0, 130.0)])
def test_a_homogeneous_sphere_rests_on_the_floor_in_any_attitude(edges, attitude):
    radius, weight = 0.5, 2.0
    mass = weight * DENSITY * 4 / 3 * math.pi * 0.02**3
    agent = replace(sphere_agent(0.02, mass), body=spheroid_body(0.02, 0.02, edges))
    release = Release(position=(1.0, 0.0, 0.02 - radius), pitch_deg=attitude[0], yaw_deg=attitude[1])
    scenario = water_scenario(1.0, pipe=(9.0, radius), release=release)
    model = flight_model(agent, scenario)
    end = integrate(model, release_state(model, scenario), 1.0, TIGHT).samples[-1]
    [depth] = depths([end], model)
    # k d = (m - m_f) g with k = (m + m_f / 2) omega^2: 0.04 mm, and a little stiffer than that.
    expected = (2.0 - 1.0) * 9.81 / 2.5 / scenario.contact.frequency**2
    assert depth == pytest.approx(expected, rel=0.02)
    assert depth < 1e-4
    rate = np.empty(13)
    fill_rate(0.0, end[1:], model, rate)
    assert np.abs(rate[10:] * model.numbers[0]["mass"][4, 4]).max() < 1e-9, "no torque"
    assert np.abs(end[11:]).max() < 1e-9, "it does not turn"


def test_a_sphere_bounces_as_scipy_integrates_the_law_of_the_page():
    """The law, written down again from docs/physics.md: m omega^2 d (1 + (d / 0.2 mm)^4) times the damper's factor."""
    restitution, radius, weight, omega = 0.8, 0.3, 0.2 * SPHERE_MASS / 1.2 * 9.81, 300.0
    mass = SPHERE_MASS + 0.5 * SPHERE_MASS / 1.2
    film = 35 * 6 * math.pi * VISCOSITY * DENSITY * 0.01**2 * math.sqrt(restitution)

    def rate(_, y):
        depth, w = y
        if depth <= 0:
            return [w, weight / mass]
        square = omega**2 * depth**2 * (1 + (depth / 2e-4) ** 4 / 3)
        wet = film / (mass * math.hypot(w, math.sqrt(square)))
        loss = min(2.3, -math.log(restitution) + wet * (1 + 0.33 * wet) / (1 + 0.7 * wet + 0.02 * wet**2))
        zeta = loss * (0.415 + 0.052 * loss**2)
        factor = max(0.0, 1 + 2 * zeta * w / math.sqrt(square + w**2 / 16))
        return [w, weight / mass - omega**2 * depth * (1 + (depth / 2e-4) ** 4) * factor]

    there = {"position": (1.0, 0.0, 0.06 - radius), "pitch_deg": 20.0, "pipe": (9.0, radius)}
    fluid = Fluid(density=DENSITY, viscosity=VISCOSITY)
    scenario = water_scenario(2.0, "rest", **there, restitution=restitution, fluid=fluid)
    model = flight_model(BODIES["sphere of 24 edges"][0], scenario)
    samples = integrate(model, release_state(model, scenario), 2.0, TIGHT).samples
    times = samples[:, 0]
    book = solve_ivp(rate, (0, 2.0), [0.01 - 0.06, 0.0], t_eval=times, rtol=1e-10, atol=1e-13, max_step=2e-3)
    assert np.abs(book.y[0] - (0.01 - radius - samples[:, 3])).max() < 1e-5
    assert (np.diff(np.sign(samples[:, 10])) != 0).sum() > 4, "it bounces several times"
