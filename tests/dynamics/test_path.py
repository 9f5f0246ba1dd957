"""Closest approach between samples."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar

from driftform.dynamics.path import closest_approach, world_velocity
from driftform.types import End, Trajectory


def flight(t, position, velocity):
    """A flight without rotation: body axes are world axes."""
    still = np.tile([1.0, 0, 0, 0], (len(t), 1))
    return Trajectory(t, position, still, np.hstack([velocity, np.zeros((len(t), 3))]), End.HORIZON)


def helix(t):
    position = np.column_stack([t, 0.3 * np.cos(2 * t), 0.3 * np.sin(2 * t)])
    velocity = np.column_stack([np.ones_like(t), -0.6 * np.sin(2 * t), 0.6 * np.cos(2 * t)])
    return position, velocity


@given(st.tuples(st.floats(0.5, 4.5), st.floats(-1, 1), st.floats(-1, 1)))
def test_a_straight_path_passes_a_point_at_the_length_of_the_perpendicular(point):
    t = np.array([0.0, 0.4, 1.7, 2.0, 5.0])
    path = flight(t, np.outer(t, [1.0, 0, 0]), np.tile([1.0, 0, 0], (5, 1)))
    [distance], [when] = closest_approach(path, np.array([point]))
    assert distance == pytest.approx(np.hypot(point[1], point[2]), abs=1e-12)
    assert when == pytest.approx(point[0], abs=1e-6)


@given(st.tuples(st.floats(0, 5), st.floats(-1, 1), st.floats(-1, 1)))
def test_a_curved_path_agrees_with_a_brute_force_search_on_the_true_curve(point):
    t = np.linspace(0, 5, 101)
    [distance], _ = closest_approach(flight(t, *helix(t)), np.array([point]))

    def true_distance(s):
        return float(np.linalg.norm(helix(np.atleast_1d(s))[0][0] - point))

    fine = np.linspace(0, 5, 5001)
    guess = fine[np.argmin(np.linalg.norm(helix(fine)[0] - point, axis=1))]
    best = minimize_scalar(
        true_distance, bounds=(max(0, guess - 0.01), min(5, guess + 0.01)), method="bounded"
    )
    # Hermite error of a stretch h: h^4 / 384 max |x''''| = 0.05^4 / 384 * 0.3 * 2^4 = 8e-8 m.
    assert distance == pytest.approx(min(best.fun, true_distance(0), true_distance(5)), abs=2e-7)


def test_the_ends_of_the_path_count():
    t = np.array([0.0, 1.0])
    path = flight(t, np.outer(t, [1.0, 0, 0]), np.tile([1.0, 0, 0], (2, 1)))
    distances, times = closest_approach(path, np.array([[-1.0, 0, 0], [3.0, 0, 0]]))
    assert distances == pytest.approx([1, 2])
    assert times == pytest.approx([0, 1])


def test_a_flight_of_one_sample_is_a_point():
    path = flight(np.array([0.0]), np.zeros((1, 3)), np.zeros((1, 3)))
    distances, times = closest_approach(path, np.array([[3.0, 4.0, 0.0]]))
    assert (distances[0], times[0]) == (5.0, 0.0)


def test_body_velocities_are_turned_into_the_world():
    quarter = np.array([[np.sqrt(0.5), 0, np.sqrt(0.5), 0]])  # about y: body x points to -z
    path = Trajectory([0.0], np.zeros((1, 3)), quarter, [[2.0, 0, 0, 0, 0, 0]], End.HORIZON)
    assert world_velocity(path)[0] == pytest.approx([0, 0, -2], abs=1e-15)
