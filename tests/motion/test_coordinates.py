"""Motion in coordinates: what an integrator that holds it so sees is what the equations say."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from driftform.motion.coordinates import Motion
from driftform.motion.flight import SAMPLE, has_left_pipe, release_state
from driftform.motion.model import flight_model
from driftform.motion.rates import fill_rate_in_space
from driftform.study import load_study
from driftform.util.rotations import quaternion_from_rotation_vector, rotation_vector_from_quaternion
from driftform.water import Fluid, Pipe, Scenario, Segment
from driftform.water.flow import TurbulentFlow
from driftform.water.scenario import Contact, Release

PIPELINE = load_study("paper").make_pipeline()
CALM = PIPELINE.scenario
SHEARED = CALM.model_copy(update={"flow": TurbulentFlow()})
WILD = CALM.model_copy(
    update={"flow": TurbulentFlow(), "fluid": Fluid(water_level=0.1), "contact": Contact(friction=0.3)}
)
NUMBERS = st.floats(-2, 2)


def model_of(seed, scenario):
    return flight_model(PIPELINE.make_agent(PIPELINE.grammar.random(np.random.default_rng(seed))), scenario)


def released(scenario, seed=3):
    model = model_of(seed, scenario)
    return model, Motion.of(model, release_state(model, scenario))


def sample_of(motion, coordinates, rates, t=0.5):
    row = np.full(SAMPLE, 7.0)
    return row, motion.fill_sample(row, t, np.array(coordinates), np.array(rates), motion.values)


@pytest.mark.parametrize("scenario", [SHEARED, WILD], ids=["sheared", "wild"])
@given(
    seed=st.integers(0, 10**6),
    place=st.tuples(st.floats(0, 9), st.floats(-0.1, 0.1), st.floats(-0.1, 0.1)),
    turn=st.tuples(NUMBERS, NUMBERS, NUMBERS),
    rates=st.tuples(*[NUMBERS] * 6),
)
def test_accelerations_in_space_are_those_of_the_state(scenario, seed, place, turn, rates):
    model = model_of(seed, scenario)
    motion = Motion.of(model, release_state(model, scenario))
    coordinates = np.array([*place, *turn])
    found = motion.accelerations(0.5, coordinates, np.array(rates), motion.values)
    quaternion = quaternion_from_rotation_vector(np.array([turn]))[0]
    expected = np.empty(13)
    fill_rate_in_space(0.5, np.array([*place, *quaternion, *rates]), model, expected)
    assert found == pytest.approx(expected[7:], rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("scenario", [CALM, SHEARED], ids=["calm", "sheared"])
def test_the_first_sample_is_the_release(scenario):
    tilted = scenario.model_copy(update={"release": Release(pitch_deg=30.0)})
    model = model_of(3, tilted)
    start = release_state(model, tilted)
    motion = Motion.of(model, start)
    row, goes_on = sample_of(motion, motion.coordinates, motion.rates, t=0.0)
    assert goes_on
    assert row == pytest.approx([0.0, *start[:13]], abs=1e-15)


@given(turn=st.tuples(NUMBERS, NUMBERS, NUMBERS))
def test_a_sample_in_space_has_the_quaternion_of_the_rotation_vector(turn):
    _, motion = released(SHEARED)
    row, _ = sample_of(motion, [1.0, 0.0, 0.0, *turn], [0.0] * 6)
    assert row[4:8] == pytest.approx(quaternion_from_rotation_vector(np.array([turn]))[0], abs=1e-12)
    again = rotation_vector_from_quaternion(row[4:8])
    if np.linalg.norm(turn) < 3.1:
        assert again == pytest.approx(turn, abs=1e-9)


SLOPING = Scenario(
    pipe=Pipe(segments=(Segment(start=(1.0, 0.0, 2.0), end=(7.0, 0.0, -6.0), radius=0.6),)),
    release=Release(position=(2.5, 0.0, 0.0)),
)


@given(x=st.floats(-3, 10), z=st.floats(-8, 4))
def test_a_flight_goes_on_while_it_is_in_the_pipe(x, z):
    model, motion = released(SLOPING)
    _, goes_on = sample_of(motion, [x, 0.0, z, 0.0, 0.3, 0.0], [1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    assert goes_on == (not has_left_pipe((x, 0.0, z), model.pipe))


def test_without_a_pipe_a_flight_goes_on_anywhere():
    _, motion = released(Scenario(pipe=Pipe(segments=())))
    assert sample_of(motion, [-1e3, 1e3, 0.0, 0.0, 0.0, 0.0], [1.0] * 6)[1]


@pytest.mark.parametrize("scenario", [CALM, SHEARED], ids=["calm", "sheared"])
@pytest.mark.parametrize("broken", [np.nan, np.inf])
def test_a_flight_ends_where_it_is_not_finite(scenario, broken):
    _, motion = released(scenario)
    for place in range(len(motion.rates)):
        rates = motion.rates.copy()
        rates[place] = broken
        assert not sample_of(motion, motion.coordinates, rates)[1]
