"""The first flights of a run show what is wrong with its study, whatever the order in which they arrive."""

from collections.abc import Sequence

import numpy as np
import pytest

from driftform.search.early_warnings import FIRST, EarlyWarnings
from driftform.study import load_study
from driftform.types import End, Evaluation, Genome, Trajectory

SCENARIO = load_study("paper", ["targets={near=[2,0,0],far=[6,0,0.3]}", "flight.horizon=40"], run={"seed": 1}).scenario


def flight(length: float, end: End) -> Evaluation:
    """A flight of some length (m) along the axis."""
    t = np.linspace(0.0, 10.0, 50)
    still = np.zeros((50, 3))
    still[:, 0] = length * t / 10
    attitude = np.tile([1.0, 0.0, 0.0, 0.0], (50, 1))
    return Evaluation(Genome("g", ()), np.zeros(2), Trajectory(t, still, attitude, np.zeros((50, 6)), end))


def lines(evaluations: Sequence[Evaluation], seed: int = 0) -> list[str]:
    early_warnings, found = EarlyWarnings(SCENARIO), []
    for index in np.random.default_rng(seed).permutation(len(evaluations)):
        found += early_warnings.add(int(index), evaluations[index])
    return found


@pytest.mark.parametrize("seed", range(3))
def test_flights_that_all_last_to_the_horizon_are_said_with_how_far_they_came(seed: int) -> None:
    ended = [flight(7.0 + 0.05 * k, End.HORIZON) for k in range(FIRST)]
    [line] = lines(ended, seed)
    assert line.startswith(
        "20 of the first 20 flights last to flight.horizon = 40 s, and end 7000 mm to 7950 mm from the release"
    )


def test_a_target_that_no_flight_passes_is_named_with_the_distance() -> None:
    [line] = lines([flight(3.0, End.OUTLET)] * 10 + [flight(4.0, End.HORIZON)] * 10)
    assert line.startswith("none of the first 20 flights passes target far: the nearest ends 2022 mm before")


def test_flights_that_arrive_say_nothing_and_one_is_enough() -> None:
    assert lines([flight(9.0, End.OUTLET)] * 30) == []
    assert lines([flight(9.0, End.OUTLET)] + [flight(3.0, End.OUTLET)] * 19) == []


def test_failed_flights_are_no_evidence() -> None:
    failed = Evaluation(Genome("g", ()), np.zeros(2), failure="no body")
    assert lines([failed] * 15 + [flight(1.0, End.HORIZON)] * 5) == []
