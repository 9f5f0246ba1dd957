"""The path between samples: closest approach, and how far its cubics are from the motion."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from driftform.motion.forces.state import SAMPLE
from driftform.motion.path.approach import closest_approach
from driftform.motion.path.curve import bound_cubic_error, evaluate_path, hermite_coefficients, world_velocity
from driftform.motion.path.thinning import select_spaced
from driftform.types import End, Trajectory


def make_trajectory(t, position, velocity):
    """A flight without rotation: body axes are world axes."""
    still = np.tile([1.0, 0, 0, 0], (len(t), 1))
    return Trajectory(t, position, still, np.hstack([velocity, np.zeros((len(t), 3))]), End.HORIZON)


def helix(t):
    position = np.column_stack([t, 0.3 * np.cos(2 * t), 0.3 * np.sin(2 * t)])
    velocity = np.column_stack([np.ones_like(t), -0.6 * np.sin(2 * t), 0.6 * np.cos(2 * t)])
    return position, velocity


def cubics(path):
    return hermite_coefficients(path.t, path.position, world_velocity(path))


def exact_distance(path, point):
    """The least distance there is: the square of the distance is of degree six, with its least values where its
    derivative has a root, or at an end."""
    squares = []
    for cubic in cubics(path):
        offset = (cubic - np.outer([1, 0, 0, 0], point))[::-1]
        square = sum(np.convolve(component, component) for component in offset.T)
        roots = np.roots(np.polyder(square))
        squares += [np.polyval(square, u) for u in (0, 1, *roots[np.abs(roots.imag) < 1e-6].real) if 0 <= u <= 1]
    return np.sqrt(min(squares))


@given(st.integers(2, 120), st.tuples(st.floats(-1, 6), st.floats(-1, 1), st.floats(-1, 1)), st.integers(0, 99))
def test_no_point_of_a_smooth_path_is_nearer(count, point, seed):
    rng = np.random.default_rng(seed)
    t = np.linspace(0, count * 0.04, count) + 0.01 * rng.random(count)
    path = make_trajectory(t, *helix(t))
    [distance], _ = closest_approach(path, np.array([point]))
    assert distance == pytest.approx(exact_distance(path, point), abs=1e-12)


@given(st.integers(2, 120), st.floats(0.001, 10), st.integers(0, 2**32 - 1))
def test_on_a_path_however_wild_no_station_is_passed_by(count, speed, seed):
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(0.01, 1, count))
    walk = np.cumsum(rng.normal(size=(count, 3)), axis=0)
    quaternion = rng.normal(size=(count, 4))
    quaternion /= np.linalg.norm(quaternion, axis=1, keepdims=True)
    path = Trajectory(t, walk, quaternion, speed * rng.normal(size=(count, 6)), End.HORIZON)
    points = rng.uniform(walk.min(), walk.max(), (5, 3))
    u = np.linspace(0, 1, 5)
    stations = np.einsum("gj,sji->sgi", u[:, None] ** np.arange(4), cubics(path)).reshape(-1, 3)
    for point, distance, time in zip(points, *closest_approach(path, points), strict=True):
        assert distance <= np.linalg.norm(stations - point, axis=1).min() * (1 + 1e-12)
        s = min(np.searchsorted(t, time, "right"), count - 1) - 1
        there = ((time - t[s]) / (t[s + 1] - t[s])) ** np.arange(4) @ cubics(path)[s]
        assert distance == pytest.approx(np.linalg.norm(there - point), rel=1e-9, abs=1e-9)


@given(st.integers(0, 199), st.floats(0.01, 5))
def test_a_path_that_comes_straight_up_and_goes_back_is_nearest_where_it_turns(turn, gap):
    t = np.arange(200.0)
    along = np.array([0.6, 0, 0.8])
    path = make_trajectory(t, np.outer(gap + 0.01 * np.abs(t - turn), along), np.outer(0.01 * np.sign(t - turn), along))
    [distance], [when] = closest_approach(path, np.zeros((1, 3)))
    assert (distance, when) == pytest.approx((gap, turn), rel=1e-12)


def test_a_flight_of_one_sample_is_a_point():
    path = make_trajectory(np.array([0.0]), np.zeros((1, 3)), np.zeros((1, 3)))
    distances, times = closest_approach(path, np.array([[3.0, 4.0, 0.0]]))
    assert (distances[0], times[0]) == (5.0, 0.0)


def test_body_velocities_are_turned_into_the_world():
    quarter = np.array([[np.sqrt(0.5), 0, np.sqrt(0.5), 0]])  # about y: body x points to -z
    path = Trajectory([0.0], np.zeros((1, 3)), quarter, [[2.0, 0, 0, 0, 0, 0]], End.HORIZON)
    assert world_velocity(path)[0] == pytest.approx([0, 0, -2], abs=1e-15)


@given(st.lists(st.floats(1e-4, 0.1), max_size=60))
def test_times_are_thinned_to_their_ends_and_what_lies_far_enough_apart(steps):
    t = np.concatenate([[0.0], np.cumsum(steps)])
    kept = select_spaced(t, 0.01)
    assert (kept[0], kept[-1]) == (0, len(t) - 1)
    if len(kept) > 2:
        assert np.diff(t[kept]).min() >= 0.01
    # No gap is longer than it must be.
    for first, second in pairwise(kept[:-1]):
        assert (t[first + 1 : second] - t[first] < 0.01).all()
    assert select_spaced(t[kept], 0.01).tolist() == list(range(len(kept)))


def along_z(t, height, velocity):
    """Raw samples of a motion along z."""
    samples = np.zeros((len(t), SAMPLE))
    samples[:, 0], samples[:, 3], samples[:, 4], samples[:, 10] = t, height, 1.0, velocity
    return samples


@pytest.mark.parametrize("steps", [20, 40])
def test_the_error_between_samples_is_that_of_a_cubic(steps):
    t = np.linspace(0, 2, steps + 1)
    samples = along_z(t, np.sin(3 * t), 3 * np.cos(3 * t))
    middles = t[:-1] + 1 / steps
    between = evaluate_path(t, samples[:, 1:4], samples[:, 8:11], middles)[:, 2]
    off = np.abs(between - np.sin(3 * middles)).max()
    assert bound_cubic_error(samples) == pytest.approx(off, rel=0.05)
    # A kink at a sample is part of the path, and so is a sample that occurs twice.
    after = np.maximum(t - 1, 0)
    assert bound_cubic_error(along_z(t, after**2, 2 * after)) < 1e-12
    assert bound_cubic_error(samples[np.repeat(np.arange(steps + 1), 2)]) == bound_cubic_error(samples)
    assert bound_cubic_error(samples[:2]) == 0.0
