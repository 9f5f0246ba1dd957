"""The misses of disturbed flights: the median, and what 9 of 10 flights stay within."""

import numpy as np
import pytest

from driftform.runs.misses import Misses, estimate_quantile
from driftform.water.disturbances import draw_conditions
from driftform.water.scenario import Robustness


def test_a_further_draw_stays_within_the_promise_nine_times_of_ten():
    rng = np.random.default_rng(1)
    for count in (19, 60):
        drawn = rng.gamma(1.5, size=(count, 4000))
        promised = estimate_quantile(drawn, 0.9)
        assert np.mean(rng.gamma(1.5, size=4000) < promised) == pytest.approx(0.9, abs=0.015)


def test_with_few_flights_the_promise_is_the_largest_miss_and_not_beyond():
    assert estimate_quantile(np.array([[1.0], [4.0], [2.0]]), 0.9) == pytest.approx([4.0])
    assert estimate_quantile(np.array([[3.0]]), 0.5) == pytest.approx([3.0])


def test_a_quantile_lies_between_its_neighbours():
    values = np.arange(1.0, 21.0)[:, None]
    assert estimate_quantile(values, 0.5) == pytest.approx([10.5])
    assert estimate_quantile(values, 0.9) == pytest.approx([18.9])


def test_failed_flights_do_not_count_as_misses_and_are_counted_apart():
    offsets = np.zeros((10, 2, 3))
    offsets[..., 1], offsets[..., 2] = 0.06, -0.08
    offsets[:2] = np.nan
    offsets[2, 1] = np.nan
    misses = Misses(draw_conditions(Robustness(), 10, (1,)), offsets)
    assert misses.failed == 3
    assert misses.median == pytest.approx([0.1, 0.1])
    assert misses.promised == pytest.approx([0.1, 0.1])
    assert [misses.describe(target)["failed"] for target in (0, 1)] == [2, 3]


def test_nothing_is_promised_if_all_flights_failed():
    misses = Misses(draw_conditions(Robustness(), 3, (1,)), np.full((3, 1, 3), np.nan))
    assert misses.describe(0) == {"flights": 3, "failed": 3, "median": None, "p90": None}


def test_the_promise_in_known_gusts_stands_beside_that_in_gusts_that_are_in_doubt():
    offsets = np.zeros((19, 1, 3))
    offsets[:, 0, 2] = np.linspace(0.01, 0.19, 19)
    misses = Misses(draw_conditions(Robustness(), 19, (1,)), offsets, 0.75 * offsets)
    assert misses.describe(0)["p90"] == pytest.approx(0.18)
    assert misses.describe(0)["p90_known_gusts"] == pytest.approx(0.75 * 0.18)
    assert Misses(misses.conditions, offsets).promised_in_known_gusts is None
