"""Repeats of searches, and their statistics."""

import numpy as np

from driftform.search.comparison import Outcome, compare_values, write_values


def test_the_interval_of_a_difference_covers_it_as_often_as_it_says():
    rng, covered = np.random.default_rng(0), 0
    for _ in range(60):
        found = compare_values(rng.normal(1.0, 1.0, 30), rng.normal(0.0, 1.0, 30))
        covered += found["low"] <= 1.0 <= found["high"]
    # A share of 0.95 of 60, within three standard deviations.
    assert covered >= 52


def test_ranks_of_the_same_search_differ_by_chance_alone():
    rng = np.random.default_rng(1)
    found = [compare_values(rng.normal(size=10), rng.normal(size=10))["p"] for _ in range(100)]
    assert np.mean(np.array(found) < 0.05) <= 0.05 + 3 * np.sqrt(0.05 * 0.95 / 100)
    found = compare_values(np.arange(10.0), np.arange(10.0) + 10)
    assert found["p"] < 1e-3 and found["difference"] == -10.0


def test_texts_that_a_spreadsheet_takes_for_formulas_are_warned_of(tmp_path, capsys):
    outcome = Outcome(("leak",), np.ones((1, 1, 1)), {"fitness": np.ones((1, 1))}, 0)
    write_values(tmp_path / "values.csv", {"=1+1": outcome}, [1])
    assert "warning: texts in search begin with =, +, - or @" in capsys.readouterr().err
    write_values(tmp_path / "values.csv", {"tuned": outcome}, [1])
    assert capsys.readouterr().err == ""


def test_what_is_not_known_says_nothing():
    assert compare_values(np.array([1.0, np.nan]), np.array([1.0, 2.0]))["median"] is None
