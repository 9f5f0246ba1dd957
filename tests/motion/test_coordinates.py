"""The forces of water and wall on a rigid body that another program integrates."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from driftform.motion.forces.inertia import added_mass_at, rigid_body_mass
from driftform.motion.forces.model import flight_model
from driftform.motion.forces.rates import fill_rate
from driftform.motion.forces.state import SAMPLE, release_state
from driftform.motion.forces.water_forces import WaterForces
from driftform.study import load_study
from driftform.util.rotations import quaternion_from_rotation_vector
from driftform.water import Fluid, Pipe, Scenario, Segment
from driftform.water.flow import TurbulentFlow
from driftform.water.outlets import has_left_pipe
from driftform.water.scenario import Contact, Release

PIPELINE = load_study("paper").make_pipeline()
CALM = PIPELINE.scenario
SHEARED = CALM.model_copy(update={"flow": TurbulentFlow()})
WILD = CALM.model_copy(
    update={"flow": TurbulentFlow(), "fluid": Fluid(water_level=0.1), "contact": Contact(friction=0.3)}
)
NUMBERS = st.floats(-2, 2)


def make_agent(seed):
    return PIPELINE.make_agent(PIPELINE.grammar.random(np.random.default_rng(seed)))


def sample_of(water, coordinates, rates, t=0.5):
    row = np.full(SAMPLE, 7.0)
    return row, water.fill_sample(row, t, np.array(coordinates), np.array(rates))


@pytest.mark.parametrize("scenario", [CALM, SHEARED, WILD], ids=["calm", "sheared", "wild"])
@given(
    seed=st.integers(0, 10**6),
    place=st.tuples(st.floats(0, 9), st.floats(-0.1, 0.1), st.floats(-0.1, 0.1)),
    turn=st.tuples(NUMBERS, NUMBERS, NUMBERS),
    rates=st.tuples(*[NUMBERS] * 6),
)
def test_a_dry_body_with_these_forces_accelerates_as_the_state_does(scenario, seed, place, turn, rates):
    """Newton and Euler for the dry body about the core's centre, in the coordinates that Exudyn uses."""
    agent = make_agent(seed)
    water, model = WaterForces.of(agent, scenario), flight_model(agent, scenario)
    coordinates, speeds = np.array([*place, *turn]), np.array(rates)
    force, added = np.array(water.force(0.5, coordinates, speeds, np.zeros(len(water.inner_rates)))), np.empty((6, 6))
    water.fill_mass(coordinates, added)
    R, omega, dry = Rotation.from_rotvec(turn).as_matrix(), speeds[3:], rigid_body_mass(agent.mass)
    axes = np.block([[R, np.zeros((3, 3))], [np.zeros((3, 3)), np.eye(3)]])
    assert added == pytest.approx(axes @ added_mass_at(agent.coefficients, np.zeros(3)) @ axes.T, rel=1e-9, abs=1e-12)
    up, mass = R[2], agent.mass
    weight = -mass.mass * scenario.fluid.gravity
    loads = (weight + water.lift) * np.array([0.0, 0.0, 1.0])
    moments = np.cross(mass.cog, weight * up) + np.cross(mass.cob, water.lift * up)
    spin = mass.mass * R @ np.cross(omega, np.cross(omega, mass.cog))
    right = force + np.concatenate([loads - spin, moments - np.cross(omega, dry[3:, 3:] @ omega)])
    quaternion, expected = quaternion_from_rotation_vector(np.array([turn]))[0], np.empty(13)
    fill_rate(0.5, np.array([*place, *quaternion, *rates]), model, expected)
    left = (axes @ dry @ axes.T + added) @ expected[7:]
    assert left == pytest.approx(right, rel=1e-9, abs=1e-9 * np.abs(force).max() + 1e-12)


@pytest.mark.parametrize("scenario", [CALM, SHEARED], ids=["calm", "sheared"])
def test_the_first_sample_is_the_release(scenario):
    tilted = scenario.model_copy(update={"release": Release(pitch_deg=30.0)})
    water = WaterForces.of(make_agent(3), tilted)
    row, goes_on = sample_of(water, water.coordinates, water.rates, t=0.0)
    assert goes_on
    assert row == pytest.approx([0.0, *release_state(water.model, tilted)[:13]], abs=1e-15)


SLOPING = Scenario(
    pipe=Pipe(segments=(Segment(start=(1.0, 0.0, 2.0), end=(7.0, 0.0, -6.0), radius=0.6),)),
    release=Release(position=(2.5, 0.0, 0.0)),
)


@given(x=st.floats(-3, 10), z=st.floats(-8, 4))
def test_a_flight_goes_on_while_it_is_in_the_pipe(x, z):
    water = WaterForces.of(make_agent(3), SLOPING)
    _, goes_on = sample_of(water, [x, 0.0, z, 0.0, 0.3, 0.0], [1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    assert goes_on == (not has_left_pipe((x, 0.0, z), water.model.pipe))


@pytest.mark.parametrize("broken", [np.nan, np.inf])
def test_a_flight_ends_where_it_is_not_finite(broken):
    water = WaterForces.of(make_agent(3), SHEARED)
    for place in range(6):
        rates = water.rates.copy()
        rates[place] = broken
        assert not sample_of(water, water.coordinates, rates)[1]
