"""A flight that goes on step by step."""

import math

import numpy as np
import pytest

import driftform as df
from driftform.errors import InputError
from driftform.types import End
from driftform.util.rotations import matrix_from_quaternion
from driftform.water import field

GENOME = "addB-tiltn-1-M-moveB-addB-tiltn-2-S-moveB-addB-tiltp-1-L-moveB"
OPEN = ("pipe.segments=[]", "targets={}", "flow.kind=uniform", "flow.speed=0", "release.pitch_deg=20")
STRAIGHT = ("flow.kind=uniform", "release.position=[1,0,0]", "release.pitch_deg=20")


@pytest.fixture(scope="module")
def design():
    """An agent of `paper` by the native simulator."""
    return df.open_agent(GENOME, scenario="paper")


def test_many_steps_end_where_one_flight_does(design):
    whole = design.under(*STRAIGHT, "flight.horizon=0.4", "release.roll_deg=30", "release.rates=[1, 2, 3]")
    flight, trajectory = whole.fly(), whole.trace()
    assert trajectory.contact is None
    np.testing.assert_array_equal(flight.velocity[3:], (1, 2, 3))
    for _ in range(100):
        flight.step(0.004)
    assert flight.time == pytest.approx(0.4, rel=1e-12)
    np.testing.assert_allclose(flight.position, trajectory.position[-1], atol=1e-6)
    np.testing.assert_allclose(flight.velocity, trajectory.velocity[-1], atol=1e-4)


@pytest.mark.parametrize("force", ["full", "paper"])
def test_a_current_that_changes_at_once_acts_as_one_that_accelerates_for_a_moment(design, force):
    """The limit is taken with flow.acceleration = 10 m/s2 for 0.1 ms; weight changes velocities by 1e-3 m/s meanwhile."""
    at_rest = design.under(
        *OPEN, f"fluid.flow_force={force}", "release.velocity=rest", "flight.horizon=1e-4", "fluid.gravity=0"
    )
    slowly = at_rest.under("flow.acceleration=10").trace()
    flight = at_rest.fly()
    flight.step(1e-6, current=(1e-3, 0.0, 0.0))
    np.testing.assert_allclose(flight.velocity, slowly.velocity[-1], rtol=1e-3, atol=1e-8)
    assert abs(flight.velocity[0]) > 1e-5


def test_a_current_acts_from_its_arrival(design):
    """As in a flight that is released in it with the velocity that the body has then."""
    flight = design.under(*OPEN).fly()
    flight.step(0.2)
    step = flight.step(0.1, current=(0.3, 0.4, 0.0))
    assert step.t[0] == pytest.approx(0.2) and flight.scenario.current().tolist() == [0.3, 0.4, 0.0]
    np.testing.assert_allclose(field.water_velocity([1, 2, 3], 0.0, flight.scenario), [[0.3, 0.4, 0.0]])
    again = flight.step(0.1)
    other = design.under(*OPEN, "flow.added=[0.3, 0.4, 0]")
    flown = other.pipeline.simulator.simulate(other.agent, other.scenario.resume(step, 0.1))
    np.testing.assert_array_equal(again.position, flown.position)


def test_the_current_that_the_body_is_in_already_changes_nothing_at_once(design):
    """In a shear the water at the middle of a body is not that at the origin of its axes."""
    flight = design.under("flow.kind=log_law", "release.position=[1, 0, 0.6]", "release.pitch_deg=90").fly()
    flight.step(0.05)
    before = flight.velocity
    cob = flight.position + matrix_from_quaternion(flight.quaternion) @ design.agent.mass.cob
    [water] = field.water_velocity(cob, flight.time, flight.scenario)
    flight.step(1e-6, current=water)
    np.testing.assert_allclose(flight.velocity, before, atol=1e-4)


def test_a_given_current_replaces_that_of_bends(design):
    parts = 'pipe.parts=[{length=2}, {kind="bend", radius=2}]'
    flight = design.under("targets={}", "pipe.segments=[]", "pipe.radius=1", parts, "flow.speed=0.5").fly()
    flight.step(0.05)
    flight.step(0.05, current=(0.1, 0.0, 0.05))
    assert flight.end is None
    np.testing.assert_allclose(field.water_velocity(flight.position, 0.0, flight.scenario), [[0.1, 0.0, 0.05]])


def test_steps_follow_a_current_that_accelerates(design):
    whole = design.under(*OPEN, "flow.acceleration=0.5", "flight.horizon=0.4")
    flight = whole.fly()
    for _ in range(4):
        flight.step(0.1)
    np.testing.assert_allclose(flight.position, whole.trace().position[-1], atol=1e-6)


def test_a_flight_ends_at_the_outlet_and_takes_no_further_step(design):
    flight = design.under("flow.kind=uniform", "release.position=[8.9, 0, 0]").fly()
    flight.step(0.5)
    assert flight.end is End.OUTLET
    assert flight.position[0] == pytest.approx(9.0, abs=1e-6) and flight.time < 0.5
    with pytest.raises(InputError, match=r"the flight has ended after"):
        flight.step(0.1)


@pytest.mark.parametrize("duration", [0.0, -1.0, math.nan, math.inf])
def test_a_step_needs_a_duration(design, duration):
    with pytest.raises(InputError, match=r"duration = .*: a step takes more than 0"):
        design.fly().step(duration)


@pytest.mark.parametrize("current", [(1.0,), (1.0, 2.0, math.nan), (0.0, 0.0, 1e9)])
def test_a_current_has_three_numbers(design, current):
    flight = design.fly()
    with pytest.raises(InputError, match=r"current = .*expected three numbers"):
        flight.step(0.1, current)
    assert flight.time == 0.0


def test_gusts_are_refused_with_the_next_step(design):
    with pytest.raises(InputError, match=r"gusts outlast a step; set gusts.strength = 0"):
        design.under("flow.kind=turbulent", "flow.speed=1").fly()


def test_an_added_current_is_steady_and_the_whole_one_in_bends(design):
    with pytest.raises(InputError, match=r"set flow.acceleration = 0"):
        design.under(*OPEN, "flow.added=[0, 1, 0]", "flow.acceleration=1")
    with pytest.raises(InputError, match=r"set flow.speed = 0"):
        design.under(
            "targets={}",
            "pipe.segments=[]",
            "pipe.radius=1",
            "pipe.parts=[{kind='bend', radius=2}]",
            "flow.added=[0, 1, 0]",
        )
