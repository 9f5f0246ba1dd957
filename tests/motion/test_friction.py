"""Friction that sticks: bodies that slide, roll, and stay where they are."""

import math
from dataclasses import replace

import numpy as np
import pytest

from driftform.motion.forces.model import flight_model
from driftform.motion.forces.state import release_state
from driftform.motion.solver.error import Accuracy, integrate
from driftform.study import load_study
from driftform.testing.agents import DENSITY, Spheroid, sphere_agent
from driftform.testing.bodies import spheroid_body
from driftform.water import Fluid, Pipe, Scenario, Segment
from driftform.water.flow import UniformFlow
from driftform.water.scenario import Contact, FlightLimits, Release

RADIUS = 0.02
VOLUME = 4 / 3 * math.pi * RADIUS**3
ACCURACY = Accuracy(position=1e-4)


def scenario_of(horizon, friction, *, slope=0.0, radius=0.5, **release):
    end = (9 * math.cos(slope), 0.0, -9 * math.sin(slope))
    return Scenario(
        pipe=Pipe(segments=(Segment(start=(0, 0, 0), end=end, radius=radius),)),
        flow=UniformFlow(speed=0.0),
        fluid=Fluid(density=DENSITY),
        release=Release(**release),
        contact=Contact(friction=friction),
        flight=FlightLimits(horizon=horizon),
    )


def flown(agent, scenario):
    model = flight_model(agent, scenario)
    return integrate(model, release_state(model, scenario), scenario.flight.horizon, ACCURACY).samples


def heavy_sphere(edges=24):
    return replace(sphere_agent(RADIUS, 2 * DENSITY * VOLUME), body=spheroid_body(RADIUS, RADIUS, edges))


@pytest.mark.parametrize("edges", [24, 144])
@pytest.mark.parametrize("yaw", [0.0, 45.0, 90.0])
def test_a_sphere_that_slides_ends_rolling_as_fast_whatever_its_axis(edges, yaw):
    # The friction conserves the angular momentum about the line of contact: v (m + m_f / 2 + I / r^2) = v_0 (m + m_f / 2).
    scenario = scenario_of(3.0, 0.3, position=(1.0, 0.0, RADIUS - 0.5), velocity=(0.3, 0.0, 0.0), yaw_deg=yaw)
    end = flown(heavy_sphere(edges), scenario)[-1]
    rolling = 0.3 * (2 + 0.5) / (2 + 0.5 + 0.8)
    assert end[8] == pytest.approx(rolling, rel=1e-4)
    across = np.array([np.sin(np.deg2rad(yaw)), np.cos(np.deg2rad(yaw))])
    assert end[11:13] == pytest.approx(rolling / RADIUS * across, rel=1e-3, abs=1e-3)
    assert abs(end[13]) < 1e-6 * rolling / RADIUS


def test_a_sphere_rolls_down_a_slope_with_the_acceleration_of_rolling():
    scenario = scenario_of(1.0, 0.3, slope=0.1, position=(1.0, 0.0, RADIUS - 0.5), velocity="rest")
    samples = flown(heavy_sphere(), scenario)
    along = samples[:, 8] * math.cos(0.1) - samples[:, 10] * math.sin(0.1)
    expected = (2 - 1) * 9.81 * math.sin(0.1) / (2 + 0.5 + 0.8)
    assert along[-1] / samples[-1, 0] == pytest.approx(expected, rel=1e-3)


def test_a_sphere_rolls_without_friction_nowhere():
    scenario = scenario_of(1.0, 0.0, slope=0.1, position=(1.0, 0.0, RADIUS - 0.5), velocity="rest", yaw_deg=30)
    assert np.abs(flown(heavy_sphere(), scenario)[-1, 11:]).max() < 1e-9


def pressed_spheroid(weight):
    """A spheroid that is so much heavier (N) than water."""
    agent = Spheroid(0.06, 0.03).agent()
    displaced = DENSITY * agent.mass.volume
    return replace(agent, mass=replace(agent.mass, mass=displaced + weight / 9.81))


@pytest.mark.parametrize("weight", [6.0, 9.0])
def test_an_agent_pressed_to_a_sloping_wall_sticks(weight):
    # tan(slope) = 0.2 < 0.3.
    scenario = scenario_of(20.0, 0.3, slope=math.atan(0.2), position=(1.0, 0.0, 0.03 - 0.5), velocity="rest")
    samples = flown(pressed_spheroid(weight), scenario)
    # Within a second it has settled, from where it touched without a load.
    settled = samples[np.searchsorted(samples[:, 0], 1.0) :]
    assert np.linalg.norm(settled[:, 1:4] - settled[0, 1:4], axis=1).max() < 1e-3
    assert np.linalg.norm(samples[:, 1:4] - samples[0, 1:4], axis=1).max() < 10e-3


def test_an_agent_on_a_wall_that_is_steeper_than_its_friction_slides():
    slope = math.atan(0.5)
    scenario = scenario_of(1.5, 0.3, slope=slope, position=(1.0, 0.0, 0.03 - 0.5), velocity="rest")
    agent = pressed_spheroid(6.0)
    samples = flown(agent, scenario)
    along = samples[:, 8] * math.cos(slope) - samples[:, 10] * math.sin(slope)
    mass = agent.mass.mass + agent.coefficients.added_mass[0, 0]
    expected = 6.0 * (math.sin(slope) - 0.3 * math.cos(slope)) / mass
    # Friction and the water's moment set it rocking, which takes a tenth of the speed.
    assert 0.85 * expected < along[-1] / samples[-1, 0] < 1.01 * expected


def test_bodies_that_have_settled_on_the_wall_move_on_as_their_equations_say():
    # Wide, thin hulls, of which some stop and some slide on.
    wide = ["builder.pressure=0", "builder.max_radius=0", "builder.pockets.diameter=0", "release.port=0"]
    study = load_study("pipe-inspection", wide, use={"simulator": "native"}, run={"seed": 1})
    pipeline, rng, ends = study.make_pipeline(), np.random.default_rng(1), []
    agents = [pipeline.make_agent(pipeline.grammar.random(rng)) for _ in range(5)]
    for agent, yaw in [*((agent, 0.0) for agent in agents), (agents[1], 20.0), (agents[1], 90.0)]:
        release = pipeline.scenario.release.model_copy(update={"yaw_deg": yaw})
        # Water that gains a micrometre a second in eleven days has all of its steps integrated.
        steady, changing = (
            flown(agent, pipeline.scenario.model_copy(update={"flow": flow, "release": release}))
            for flow in (UniformFlow(speed=0.6), UniformFlow(speed=0.6, acceleration=1e-12))
        )
        assert np.diff(steady[:, 0]).max() <= ACCURACY.max_step * (1 + 1e-9)
        assert steady[-1, 0] == changing[-1, 0] == pipeline.scenario.flight.horizon
        assert steady[-1, 1:4] == pytest.approx(changing[-1, 1:4], abs=1e-4)
        assert steady[-1, 8:11] == pytest.approx(changing[-1, 8:11], abs=1e-6)
        # Constant to the last bit: those steps were not integrated.
        assert np.ptp(steady[-200:, 8:11], axis=0).max() == 0.0 < np.ptp(changing[-200:, 8:11], axis=0).max()
        ends.append(steady[-1, 8])
    assert any(speed < 1e-6 for speed in ends)
    assert any(speed > 0.05 for speed in ends)
