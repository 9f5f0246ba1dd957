"""The misses of disturbed flights: the median, what 9 of 10 flights stay within, and the causes that divide their spread."""

import numpy as np
import pytest

from driftform.runs.misses import MIN_FLIGHTS, REST, Misses, estimate_quantile
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


ROBUSTNESS = Robustness()


def misses_of(flights, offset, noise=0.0, seed=1):
    conditions = draw_conditions(ROBUSTNESS, flights, (seed,))
    rng = np.random.default_rng(seed)
    offsets = np.array([offset(c) for c in conditions]) + noise * rng.standard_normal((flights, 3))
    return Misses(conditions, offsets[:, None])


def effects_of(misses):
    found = misses.list_effects(0)
    assert found is not None
    return {effect.name: effect.deviation for effect in found}


def test_each_quantity_has_the_spread_that_it_causes():
    def offset(c):
        return [0.5 + 2 * (c.current - 1), 3 * (c.drag - 1), 4 * (c.mass - 1) + 0.5 * c.across[1]]

    effects = effects_of(misses_of(200, offset))
    deviation = 0.98658  # of a standard normal cut off at three
    assert effects["current"] == pytest.approx(deviation * 2 * 0.03, rel=0.02)
    assert effects["drag"] == pytest.approx(deviation * 3 * 0.2, rel=0.02)
    assert effects["weight of the print"] == pytest.approx(deviation * 4 * 0.01, rel=0.02)
    assert effects["release point"] == pytest.approx(deviation * 0.5 * 0.02, rel=0.02)
    assert effects["release angle"] == pytest.approx(0, abs=1e-9)
    assert effects[REST] == pytest.approx(0, abs=1e-9)


def test_what_no_quantity_explains_is_left_to_gusts():
    effects = effects_of(misses_of(400, lambda c: [0, 0, 0.5 * (c.drag - 1)], noise=0.1))
    assert effects[REST] == pytest.approx(np.sqrt(3) * 0.1, rel=0.1)
    assert effects["drag"] == pytest.approx(0.1, rel=0.15)
    # Chance alone explains 0.1 sqrt(3 / 400) = 9 mm for each number that is fitted.
    assert sum(effects[name] ** 2 for name in ("current", "water density", "release point")) < 0.02**2


def test_chance_is_no_effect_on_average_and_does_not_make_the_rest_smaller():
    drawn = [effects_of(misses_of(200, lambda _: [0, 0, 0], noise=0.1, seed=seed)) for seed in range(60)]
    # Sums of three squares are below their mean in 61 % of all draws (chi-squared), a little less if columns are correlated.
    for name in ("drag", "current"):
        assert np.mean([effects[name] == 0 for effects in drawn]) > 0.3
    # Of 540 squares or so the relative deviation is 6 %, and that of the mean over 60 draws 0.8 %.
    assert np.mean([effects[REST] ** 2 for effects in drawn]) == pytest.approx(3 * 0.1**2, rel=0.04)


def test_the_squares_of_all_effects_add_up_to_the_variance():
    misses = misses_of(300, lambda c: [c.current, 0.3 * c.drag, 2 * c.pitch], noise=0.05)
    variance = misses.offsets[:, 0].var(axis=0).sum()
    assert sum(d**2 for d in effects_of(misses).values()) == pytest.approx(variance, rel=0.05)


def test_the_largest_effect_comes_first_and_the_rest_last():
    found = misses_of(100, lambda c: [c.drag, c.current, 0], noise=0.01).list_effects(0)
    assert found is not None
    assert [effect.name for effect in found[:2]] == ["drag", "current"]
    assert found[-1].name == REST


def test_failed_flights_are_left_out_and_few_flights_divide_nothing():
    misses = misses_of(MIN_FLIGHTS + 2, lambda c: [c.drag, 0, 0])
    misses.offsets[:2] = np.nan
    assert effects_of(misses)["drag"] > 0.1
    misses.offsets[:3] = np.nan
    assert misses.list_effects(0) is None
