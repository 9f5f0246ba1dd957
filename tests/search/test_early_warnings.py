"""The first flights of a run show that agents come to rest."""

import numpy as np
import pytest

from driftform.search.early_warnings import FIRST, warn_of_rest
from driftform.types import End, Evaluation, Genome, Trajectory


def flight(length, end):
    """A flight of some length (m) along the axis."""
    t = np.linspace(0.0, 10.0, 50)
    position = np.column_stack([7.0 + length * t / 10, 0 * t, 0 * t])
    attitude = np.tile([1.0, 0.0, 0.0, 0.0], (50, 1))
    return Evaluation(Genome("g", ()), np.zeros(2), Trajectory(t, position, attitude, np.zeros((50, 6)), end))


FAILED = Evaluation(Genome("g", ()), np.zeros(2), failure="no body")


def test_flights_that_nearly_all_last_to_the_horizon_are_said_with_how_far_they_came():
    held = [flight(2.0 + 0.01 * k, End.HORIZON) for k in range(FIRST - 2)]
    line = warn_of_rest([*held, flight(9.0, End.OUTLET), FAILED], 40.0)
    assert line is not None
    assert line.startswith(
        "18 of the first 19 flights last to flight.horizon = 40 s, and half of them end within 2085 mm of the release"
    )


@pytest.mark.parametrize(
    "first",
    [
        [flight(9.0, End.OUTLET)] * FIRST,
        [flight(9.0, End.OUTLET)] * 3 + [flight(3.0, End.HORIZON)] * 17,
        [FAILED] * 15 + [flight(1.0, End.HORIZON)] * 5,
    ],
    ids=["all arrive", "three arrive", "most failed"],
)
def test_flights_that_arrive_or_fail_are_no_evidence(first):
    assert warn_of_rest(first, 40.0) is None
