"""Motion in the vertical plane: the same as in space, wherever it is used."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from driftform.motion.flight import release_state
from driftform.motion.integrator import Accuracy, greatest_distance, integrate
from driftform.motion.model import flight_model
from driftform.motion.plane import STATE_INDICES, fill_plane, fill_rate_in_plane, stays_in_plane
from driftform.motion.rates import fill_rate_in_space
from driftform.study import load_study
from driftform.testing.agents import sphere_agent
from driftform.types import Drag
from driftform.water import Fluid, Pipe, Scenario, Segment
from driftform.water.flow import DevelopingFlow, LogLawFlow, PowerLawFlow, TurbulentFlow, UniformFlow
from driftform.water.scenario import Contact, Release

HORIZON = 9.0
FLAT_ROUNDING = np.sqrt(np.finfo(float).eps)
RELEASE = Release(position=(0.5, 0.0, 0.0))

PIPELINE = load_study("paper", use={"simulator": "native"}).make_pipeline()
DRAGGED = load_study("paper", ["hydrodynamics.drag=strips"], use={"simulator": "native"}).make_pipeline()


def agent_of(seed, pipeline=PIPELINE):
    return pipeline.make_agent(pipeline.grammar.random(np.random.default_rng(seed)))


def scenario_of(end=(9.0, 0.0, 0.0), radius=1.0, **parts):
    pipe = Pipe(segments=(Segment(start=(0.0, 0.0, 0.0), end=end, radius=radius),))
    return Scenario(**{"pipe": pipe, "flow": UniformFlow(speed=1.0), "release": RELEASE} | parts)


def in_plane(agent, scenario):
    model = flight_model(agent, scenario)
    return stays_in_plane(release_state(model, scenario), model)


SLOPING = pytest.mark.parametrize("end", [(9.0, 0.0, 0.0), (7.0, 0.0, -5.0), (0.0, 0.0, 9.0), (-6.0, 0.0, 2.0)])


@pytest.mark.long
@SLOPING
@pytest.mark.parametrize("pipeline", [PIPELINE, DRAGGED], ids=["ideal", "drag"])
@pytest.mark.parametrize("flow", [UniformFlow(), LogLawFlow(roughness=1e-3), PowerLawFlow()], ids=lambda f: f.kind)
@given(
    seed=st.integers(0, 10**6),
    along=st.floats(-1, 8),
    off=st.floats(-1.03, 1.03),
    attitude=st.floats(0, 2 * np.pi),
    velocity=st.tuples(st.floats(-2, 2), st.floats(-2, 2)),
    q=st.floats(-20, 20),
    friction=st.sampled_from([0.0, 0.3]),
    bent=st.floats(-1, 1),
)
def test_the_rate_of_a_state_is_what_it_is_in_space(
    end, pipeline, flow, seed, along, off, attitude, velocity, q, friction, bent
):
    axis, start = np.array(end) / np.linalg.norm(end), np.zeros(13)
    release = Release(position=tuple(axis), frame="world")
    scenario = scenario_of(end, release=release, flow=flow, contact=Contact(friction=friction))
    model = flight_model(agent_of(seed, pipeline), scenario)
    start[:3] = along * axis + off * np.array([-axis[2], 0.0, axis[0]])
    start[3], start[5] = np.cos(attitude / 2), np.sin(attitude / 2)
    start[7], start[9], start[11] = *velocity, q
    assert stays_in_plane(start, model)
    places = list(STATE_INDICES)
    # Bristles bend along the pipe.
    count = len(model.bristles) // 2
    bristles = bent * np.linspace(1.0, 2.0, count)
    state, flat = (np.concatenate([start, np.outer(bristles, axis).ravel()]), np.concatenate([start[places], bristles]))
    whole, part = np.empty(len(state)), np.empty(len(flat))
    fill_rate_in_space(0.0, state, model, whole)
    fill_plane(model)
    room = np.empty(2 * count)
    fill_rate_in_plane(flat, model.numbers[0], model.surfaces, model.touches, room, part)
    # Rounding, of a weight and a lift that cancel each other all but a thousandth, and of a micrometre's depth.
    error = 1e-9 + 1e-7 * np.abs(whole).max()
    if abs(axis @ [np.cos(attitude), 0.0, -np.sin(attitude)]) < 1e-6:
        # Flat on the wall the tilt follows from 1 - s^2, and is exact to the root of a number's precision only.
        rates = np.empty((2, len(state)))
        for rate, angle in zip(rates, (attitude - FLAT_ROUNDING, attitude + FLAT_ROUNDING), strict=True):
            turned = state.copy()
            turned[3], turned[5] = np.cos(angle / 2), np.sin(angle / 2)
            fill_rate_in_space(0.0, turned, model, rate)
        error += np.abs(rates[1] - rates[0]).max()
    assert part[:7] == pytest.approx(whole[places], rel=1e-6, abs=error)
    assert np.outer(part[7:], axis).ravel() == pytest.approx(whole[13:], rel=1e-6, abs=error)
    assert np.delete(whole[:13], places) == pytest.approx(np.zeros(6), abs=0 if not count else error)


@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("seed", range(8))
def test_a_flight_is_the_same_in_the_plane_and_in_space(seed, friction):
    agent, scenario = agent_of(seed), scenario_of(contact=Contact(friction=friction))
    model = flight_model(agent, scenario)
    start = release_state(model, scenario)
    damped = model._replace(numbers=model.numbers.copy())
    # Damping whose every coefficient is zero: it changes nothing but that the motion is integrated in space.
    damped.numbers["is_damped"] = 1.0
    assert stays_in_plane(start, model)
    assert not stays_in_plane(start, damped)
    # Bounces without damping are chaotic: only flights far more accurate than a millimetre are the same.
    accuracy = Accuracy(position=1e-5)
    flown, also = (integrate(m, start, HORIZON, accuracy) for m in (model, damped))
    assert greatest_distance(flown.samples, also.samples) < 1e-5
    assert flown.samples.shape[1] == 14
    assert not flown.samples[:, [2, 5, 7, 9, 11, 13]].any()


def test_level_agents_in_calm_water_stay_in_the_plane():
    assert in_plane(agent_of(3), scenario_of())
    assert in_plane(agent_of(3), scenario_of((8.0, 0.0, 3.0), contact=Contact(frequency=90.0)))
    assert in_plane(agent_of(3), scenario_of(release=Release(position=(0.5, 0.0, 0.2), pitch_deg=30.0)))
    assert in_plane(agent_of(3), Scenario(pipe=Pipe(segments=())))
    assert in_plane(agent_of(3, DRAGGED), scenario_of(flow=LogLawFlow()))
    assert in_plane(agent_of(3), scenario_of(contact=Contact(friction=0.3)))


@pytest.mark.parametrize(
    "parts",
    [
        {"release": Release(position=(0.5, 0.1, 0.0))},
        {"release": Release(position=(0.5, 0.0, 0.0), yaw_deg=1.0)},
        {"release": Release(position=(0.5, 0.0, 0.0), velocity=(1.0, 0.001, 0.0))},
        {"end": (9.0, 0.1, 0.0)},
        {"radius": 0.05},
        {"flow": DevelopingFlow()},
        {"flow": TurbulentFlow()},
        {"flow": LogLawFlow(), "fluid": Fluid(flow_force="paper")},
        {"flow": UniformFlow(speed=1.0, acceleration=0.1)},
        {"fluid": Fluid(water_level=0.4)},
    ],
    ids=lambda parts: next(iter(parts)),
)
def test_anything_that_the_plane_does_not_know_is_flown_in_space(parts):
    assert not in_plane(agent_of(3), scenario_of(**parts))


def test_a_body_that_couples_the_plane_with_what_is_across_is_flown_in_space():
    agent, scenario = sphere_agent(0.02, 0.05), scenario_of()
    assert in_plane(agent, scenario)
    cog = replace(agent, mass=replace(agent.mass, cog=np.array([0.0, 1e-9, 0.0])))
    assert not in_plane(cog, scenario)
    coupled = np.diag(np.full(6, 0.01))
    coupled[0, 1] = coupled[1, 0] = 1e-6
    bent = replace(agent, coefficients=replace(agent.coefficients, added_mass=coupled))
    assert not in_plane(bent, scenario)
    strips = Drag(np.array([[0.0, 0.04, 0.04, 1.0]]))
    assert not in_plane(replace(agent, coefficients=replace(agent.coefficients, drag=strips)), scenario)
