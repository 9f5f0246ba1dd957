"""Touches of the wall that are shorter than a step: a heavy sphere that is thrown at the ceiling and barely reaches it."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from driftform.motion.forces import compute_rate, flight_model, release_state
from driftform.motion.path import finish_trajectory
from driftform.motion.solver.dense import quintic_between, quintic_point
from driftform.motion.solver.error import Accuracy, integrate
from driftform.testing.agents import DENSITY, GRAVITY, sphere_agent
from driftform.testing.simulator import water_scenario

BORE, RADIUS, MASS = 0.2, 0.02, 0.1
DISPLACED = DENSITY * 4 / 3 * math.pi * RADIUS**3
FALL = (MASS - DISPLACED) * GRAVITY / (MASS + DISPLACED / 2)
"""Acceleration of the sphere in an ideal fluid, m/s2: Newton's law with half of the displaced mass added."""

ROOM = BORE - RADIUS
DEPTHS = np.geomspace(1e-7, 3e-4, 10).tolist()
"""How far (m) the parabola would lead into the ceiling: the sphere would be there for 0.4 to 20 ms."""


def thrown(depth):
    """A throw whose parabola ends at a depth (m) in the ceiling, and when it reaches the ceiling, s."""
    speed = math.sqrt(2 * FALL * (ROOM + depth))
    scenario = water_scenario(0.6, (0.0, 0.0, speed), position=(1.0, 0.0, 0.0), pipe=(9.0, BORE), restitution=0.7)
    return scenario, (speed - math.sqrt(max(0.0, speed**2 - 2 * FALL * ROOM))) / FALL


def fly(scenario, accuracy):
    model = flight_model(sphere_agent(RADIUS, MASS), scenario)
    horizon = scenario.flight.horizon
    flown = integrate(model, release_state(model, scenario), horizon, accuracy)
    return finish_trajectory(flown.samples, model, horizon, accuracy.step_limit, flown.error)


@pytest.mark.parametrize("depth", DEPTHS)
def test_a_touch_between_the_ends_of_a_step_is_found_and_pushes_as_in_short_steps(depth):
    scenario, time = thrown(depth)
    flight = fly(scenario, Accuracy())
    arrival = math.sqrt(2 * FALL * depth)
    assert flight.contact == pytest.approx(time, abs=1e-8 / arrival)
    exact = fly(scenario, Accuracy(tolerance=1e-10, max_step=2e-4))
    assert abs(flight.position[-1, 2] - exact.position[-1, 2]) <= flight.error
    # The ceiling returns most of the speed at once, and gravity only later.
    assert flight.position[-1, 2] < scenario.release_position()[2] + ROOM - 1e-3


def test_a_throw_that_does_not_reach_the_ceiling_follows_its_parabola():
    scenario, _ = thrown(-1e-7)
    flight = fly(scenario, Accuracy())
    speed = scenario.release.velocity[2]
    assert flight.contact is None
    assert flight.position[:, 2] == pytest.approx(speed * flight.t - FALL * flight.t**2 / 2, abs=1e-9)


@pytest.mark.parametrize("depth", [0.2, 0.13685766449422396])
def test_a_throw_that_bounces_is_as_exact_as_it_states(depth):
    """At the second depth two integrations err alike, and differ by an eighth of their error."""
    scenario, _ = thrown(depth)
    model, horizon = flight_model(sphere_agent(RADIUS, MASS), scenario), scenario.flight.horizon
    flight = fly(scenario, Accuracy())
    truth = solve_ivp(
        lambda t, y: compute_rate(t, y, model),
        (0.0, horizon),
        release_state(model, scenario),
        "DOP853",
        rtol=1e-11,
        atol=1e-12,
        max_step=1e-3,
    )
    assert flight.position[-1, 2] == pytest.approx(truth.y[2, -1], abs=flight.error)


VECTORS = st.tuples(*[st.floats(-2, 2)] * 3)


@given(coefficients=st.tuples(*[VECTORS] * 6), h=st.floats(1e-3, 1.0), u=st.floats(0, 1))
def test_the_dense_output_of_a_motion_of_fifth_order_is_exact(coefficients, h, u):
    powers = np.array(coefficients)

    def state(t):
        """Value, rate and rate of the rate of the polynomial at a time, s."""
        value = sum(c * t**k for k, c in enumerate(powers))
        rate = sum(k * c * t ** (k - 1) for k, c in enumerate(powers) if k)
        change = sum(k * (k - 1) * c * t ** (k - 2) for k, c in enumerate(powers) if k > 1)
        return tuple(tuple(np.asarray(v, float).tolist()) for v in (value, rate, change))

    found = quintic_point(quintic_between(state(0.0), state(h), h), u)
    assert found == pytest.approx(state(u * h)[0], abs=1e-11)
