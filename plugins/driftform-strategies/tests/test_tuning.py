"""The secant of tuning finds the weight with which a body hits."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from driftform_strategies.tuning import find_next, root_weight, square_root_weight


@given(st.floats(-1, 1))
def test_the_root_of_a_net_weight_keeps_its_sign_and_squares_to_it(weight):
    assert square_root_weight(root_weight(weight)) == pytest.approx(weight, rel=1e-12, abs=1e-300)


@given(
    root=st.floats(-0.3, 0.3),
    slope=st.floats(-30, -0.5),
    guess=st.floats(0.2, 5),
    bend=st.floats(-0.5, 0.5),
    start=st.floats(-0.05, 0.05),
)
def test_any_falling_response_is_solved_to_a_millimetre(root, slope, guess, bend, start):
    def fly(at):
        away = at - root
        return slope * away * (1 + bend * away / (1 + abs(away)))

    points = [(start, fly(start))]
    while abs(points[-1][1]) > 1e-3 and len(points) < 12:
        following = find_next(points, guess * slope)
        points.append((following, fly(following)))
    assert abs(points[-1][1]) <= 1e-3


def test_a_response_that_is_nearly_a_step_is_solved_in_few_flights():
    def fly(at):
        return -0.8 * math.tanh((at - 0.137) / 0.004) - 0.3 * (at - 0.137)

    points = [(0.3, fly(0.3)), (-0.2, fly(-0.2))]
    while abs(points[-1][1]) > 1e-3 and len(points) < 20:
        following = find_next(points, -10.0)
        points.append((following, fly(following)))
    # Bisection alone takes 14 flights to halve half a meter's root to the width of the step's millimetre.
    assert len(points) <= 14


def test_a_body_that_rides_the_wall_does_not_respond_and_is_left():
    assert find_next([(0.10, 0.27), (0.15, 0.27 + 1e-5)], -10.0) is None


@pytest.mark.parametrize(
    ("points", "slope", "found"),
    [
        # Between two flights that pass on either side.
        ([(0.0, 0.5), (0.1, -0.1), (-0.2, 0.6)], -10.0, 0.1 * 0.5 / 0.6),
        # Two flights with the same weight count as one.
        ([(0.1, 0.2), (0.1, 0.2001)], -10.0, 0.1 + 0.02001),
        # The last flight has brought the nearer end little nearer: half-way.
        ([(0.0, 1.0), (1.0, -1.0), (0.2, 0.7)], -1.0, 0.6),
        # One end is all but hit: a step that brings the other near.
        ([(0.0, 1.0), (1.0, -0.001)], -1.0, 0.98),
        ([(0.0, 0.001), (1.0, -1.0)], -1.0, 0.02),
        # Both are far to one side: three times as far as they are apart, and no farther.
        ([(0.0, 1.0), (0.1, 0.99)], -1.0, 0.1 + 0.3),
    ],
)
def test_the_next_flight_is_where_the_secant_says_and_no_end_stays_far(points, slope, found):
    assert find_next(points, slope) == pytest.approx(found, rel=1e-12)
