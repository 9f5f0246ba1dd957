"""Flights with drag in the logarithmic law against the textbook: a few of those that the studies fly."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from solids import solid_agent
from textbook import distance_from_textbook, textbook_rate

from driftform.motion.forces.body_drag import estimate_drag
from driftform.motion.forces.model import flight_model
from driftform.motion.forces.rates import fill_rate
from driftform.study import load_study
from driftform.testing.bodies import spheroid_body

MILLIMETRE = 1e-3
SETTINGS = ["flow.kind=log_law", "hydrodynamics.use=panels", "hydrodynamics.drag=strips"]


def pipeline_of(simulator, *settings):
    return load_study("paper", [*SETTINGS, *settings], use={"simulator": simulator}).make_pipeline()


@pytest.mark.parametrize("simulator", ["native", "exudyn"])
@pytest.mark.parametrize("yaw_deg", [0.0, 35.0])
def test_random_agents_with_drag_fly_as_the_textbook_says_up_to_the_wall(simulator, yaw_deg):
    pipeline = pipeline_of(simulator, f"release.yaw_deg={yaw_deg}")
    rng = np.random.default_rng(4)
    for _ in range(3):
        agent = pipeline.make_agent(pipeline.grammar.random(rng))
        flight = pipeline.fly([agent])[0]
        until = flight.t[-1] if flight.contact is None else flight.contact
        assert distance_from_textbook(flight, agent, pipeline.scenario, until) < MILLIMETRE


TERMS = ("sphere", "ends", "wake", "roll", "lift", "bore")
PIPELINE = pipeline_of("native")
vectors = st.tuples(*[st.floats(-1, 1)] * 3)


@cache
def near_sphere(without=()):
    """A body with every term: nearly a sphere, in a pipe that it fills by a tenth."""
    body, fluid = spheroid_body(0.11, 0.1, edges=60), PIPELINE.scenario.fluid
    coefficients = PIPELINE.hydrodynamics.coefficients(body, fluid)
    drag = estimate_drag(body, fluid.viscosity, 0.7, without)
    assert without or drag.round_area > 0 < drag.wake_ahead[1]
    return solid_agent(body, 1.02 * fluid.density, replace(coefficients, drag=drag), 0.001)


def rates(agent, turn, place, velocity, omega):
    """Linear and angular acceleration (world and body frame) of the kernels and of the textbook."""
    R = Rotation.from_rotvec(np.multiply(3, turn))
    start = np.array(
        [1.0, *np.multiply(0.5, place[1:]), *R.as_quat(scalar_first=True), *velocity, *np.multiply(20, omega)]
    )
    own = np.empty(13)
    fill_rate(0.0, start, flight_model(agent, PIPELINE.scenario), own)
    state = np.concatenate([start[:7], R.inv().apply(start[7:10]), start[10:]])
    book = textbook_rate(agent, PIPELINE.scenario, state)
    return own[7:], np.concatenate([R.apply(book[7:10] + np.cross(start[10:], state[7:10])), book[10:]])


@pytest.mark.long
@given(st.sampled_from(["agent", "near sphere"]), vectors, vectors, vectors, vectors)
def test_every_motion_is_accelerated_as_the_textbook_says(which, turn, place, velocity, omega):
    agent = (
        near_sphere()
        if which == "near sphere"
        else PIPELINE.make_agent(PIPELINE.grammar.random(np.random.default_rng(0)))
    )
    own, book = rates(agent, turn, place, velocity, omega)
    assert own == pytest.approx(book, rel=1e-7, abs=1e-7 * np.abs(book).max())


@pytest.mark.parametrize("term", TERMS)
def test_no_term_is_too_small_to_be_seen_in_this(term):
    motion = (0.2, -0.4, 0.3), (0.0, 0.5, 0.6), (0.7, 0.3, -0.2), (0.4, 0.1, 0.2)
    whole, part = rates(near_sphere(), *motion), rates(near_sphere((term,)), *motion)
    assert np.abs(whole[0] - part[0]).max() > 1e-5 * np.abs(whole[0]).max()
    assert part[0] == pytest.approx(part[1], rel=1e-7, abs=1e-7 * np.abs(part[1]).max())


def test_a_body_that_is_nearly_a_sphere_flies_as_the_textbook_says():
    pipeline = pipeline_of("native", "flight.horizon=3.0")
    body, fluid = spheroid_body(0.021, 0.02, edges=60), pipeline.scenario.fluid
    coefficients = pipeline.hydrodynamics.coefficients(body, fluid)
    coefficients = replace(coefficients, drag=estimate_drag(body, fluid.viscosity))
    assert coefficients.drag.round_area > 0 < coefficients.drag.friction_area
    agent = solid_agent(body, 1.05 * fluid.density, coefficients, 0.001)
    release = pipeline.scenario.release.model_copy(update={"position": (0.0, 0.4, 0.3), "yaw_deg": 20.0})
    scenario = pipeline.scenario.model_copy(update={"release": release})
    flight = pipeline.simulator.simulate(agent, scenario)
    until = flight.t[-1] if flight.contact is None else flight.contact
    assert distance_from_textbook(flight, agent, scenario, until) < MILLIMETRE
