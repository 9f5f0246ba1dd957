"""The clearance of a flight is the distance from its agent's surface to the wall, in closed form where there is one."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from solids import solid_agent

from driftform.motion.path.clearance import wall_clearances
from driftform.study import load_study
from driftform.testing.agents import sphere_agent
from driftform.testing.bodies import cylinder_body
from driftform.types import Coefficients, End, Trajectory
from driftform.util.rotations import quaternion_from_rotation_vector
from driftform.water import Scenario

RADIUS = 0.5
PIPE = Scenario.model_validate({"pipe": {"radius": RADIUS, "parts": [{"length": 4.0}]}})
BEND = Scenario.model_validate(
    {"pipe": {"radius": 0.1, "parts": [{"length": 0.5}, {"kind": "bend", "radius": 0.3}, {"length": 0.5}]}}
)
SPHERE = sphere_agent(0.05, 0.5)
ROD = solid_agent(cylinder_body(0.2, 0.02), 1100.0, Coefficients(np.diag([0.005, 0.02, 0.02, 0, 4e-6, 4e-6])))

offsets = st.floats(0.0, 0.3)
angles = st.floats(-math.pi, math.pi)


def rest(position, turn=(0.0, 0.0, 0.0)):
    """Return a flight at rest at a position (m), turned by a rotation vector (rad) from the x axis."""
    quaternion = quaternion_from_rotation_vector(np.array([turn]))[0]
    return Trajectory(
        t=np.array([0.0, 1.0]),
        position=np.tile(position, (2, 1)),
        quaternion=np.tile(quaternion, (2, 1)),
        velocity=np.zeros((2, 6)),
        end=End.HORIZON,
    )


@given(offsets, angles, angles)
def test_a_sphere_is_as_far_from_the_wall_as_its_centre_less_its_radius(off, around, turn):
    flight = rest((1.0, off * math.cos(around), off * math.sin(around)), (0.0, turn, 0.3))
    expected = RADIUS - off - 0.05
    np.testing.assert_allclose(wall_clearances(flight, PIPE, SPHERE), expected, atol=3e-4)


@given(offsets, st.floats(-1.5, 1.5))
def test_a_rod_that_is_pitched_comes_nearest_at_a_rim(off, pitch):
    """The point t of the upper rim is at y = r sin t, z = h + r cos p cos t; its distance from the axis has one maximum."""
    flight = rest((1.0, 0.0, off), (0.0, pitch, 0.0))
    height, rim, sine, cosine = off + 0.1 * abs(math.sin(pitch)), 0.02, math.sin(pitch), math.cos(pitch)
    t = min(1.0, height * cosine / max(rim * sine**2, 1e-12))
    farthest = math.hypot(height + rim * cosine * t, rim * math.sqrt(1 - t**2))
    np.testing.assert_allclose(wall_clearances(flight, PIPE, ROD), RADIUS - farthest, atol=1e-4)


@given(offsets)
def test_a_rod_across_the_pipe_comes_nearest_at_its_upper_corners(off):
    flight = rest((1.0, 0.0, off), (0.0, 0.0, math.pi / 2))
    np.testing.assert_allclose(wall_clearances(flight, PIPE, ROD), RADIUS - math.hypot(0.1, off + 0.02), atol=1e-4)


def test_the_inner_wall_of_a_bend_is_nearest_to_the_middle_of_a_rod():
    """The bend turns upward: its centre is at (0.5, 0, 0.3), and its inner wall 0.2 m from that."""
    middle = np.array([0.5, 0.0, 0.3]) + 0.28 * np.array([math.sin(0.7), 0.0, -math.cos(0.7)])
    flight = rest(middle, (0.0, -0.7, 0.0))
    np.testing.assert_allclose(wall_clearances(flight, BEND, ROD), 0.28 - 0.02 - 0.2, atol=5e-4)


def test_a_body_in_the_wall_has_a_negative_clearance():
    assert wall_clearances(rest((1.0, 0.0, 0.49)), PIPE, SPHERE) == pytest.approx(-0.04, abs=1e-4)


def test_open_water_has_no_wall():
    assert np.isinf(wall_clearances(rest((1.0, 0.0, 0.0)), Scenario(), SPHERE)).all()


@settings(deadline=None, max_examples=8)
@given(st.sampled_from(["t-junction", "pipe-inspection"]), st.integers(0, 1000))
def test_a_flight_is_clear_of_the_wall_until_its_first_contact(name, seed):
    pipeline = load_study(name, use={"simulator": "native"}).make_pipeline()
    agent = pipeline.make_agent(pipeline.grammar.random(np.random.default_rng(seed)))
    flight = pipeline.simulator.simulate(agent, pipeline.scenario)
    clearances = wall_clearances(flight, pipeline.scenario, agent)
    before = flight.t < (np.inf if flight.contact is None else flight.contact)
    assert (clearances[before] > -1e-4).all()
    if flight.contact is not None:
        nearest = int(np.argmin(np.abs(flight.t - flight.contact)))
        assert clearances[nearest] < 0.02


def test_a_flight_is_judged_at_each_of_its_times():
    flight = rest((1.0, 0.0, 0.0))
    moved = replace(flight, position=np.array([[1.0, 0.0, 0.0], [2.0, 0.0, 0.2]]))
    np.testing.assert_allclose(wall_clearances(moved, PIPE, SPHERE), [0.45, 0.25], atol=3e-4)
