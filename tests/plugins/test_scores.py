"""A fitness scores by any real numbers, of which more or less is better; the search knows them in percent."""

import numpy as np
import pytest

from driftform.builtin.fitness import ClosestApproach
from driftform.errors import WorkFailedError
from driftform.interfaces import Fitness
from driftform.plugins.seams import check_wording, require_scores
from driftform.util.options import Table


class Miss(Fitness[Table]):
    """The closest approach, m: less is better."""

    name, heading, unit, worst, best = "miss", "miss m", "m", 50.0, 0.0

    def score(self, trajectory, scenario, agent):
        path = np.linalg.norm(trajectory.position[:, None] - scenario.target_array(), axis=2)
        return np.minimum(path.min(axis=0), self.worst)


def test_less_may_be_better_and_people_read_what_was_scored():
    fitness = require_scores(np.array([0.0, 50.0, 12.5]), 3, Miss(Table()))
    assert fitness.tolist() == [100, 0, 75]
    assert [Miss(Table()).measure(value) for value in fitness.tolist()] == [0, 50, 12.5]
    assert Miss(Table()).describe(75.0) == "12.50 m"


def test_percents_stay_as_they_are_to_the_last_bit():
    scores = np.random.default_rng(0).uniform(0, 100, 1000)
    np.testing.assert_array_equal(require_scores(scores, 1000, ClosestApproach(Table())), scores)
    assert [Fitness.measure(ClosestApproach(Table()), value) for value in scores.tolist()] == scores.tolist()


def test_a_score_out_of_its_bounds_and_bounds_that_are_none_are_refused(monkeypatch):
    with pytest.raises(
        WorkFailedError, match=r"returned \[-1\.0\] from score\(\), expected an array of 1 number from 0 to 50"
    ):
        require_scores([-1.0], 1, Miss(Table()))
    for worst in (0.0, float("inf"), "50"):
        monkeypatch.setattr(Miss, "worst", worst)
        with pytest.raises(
            WorkFailedError, match=r"'miss' has worst = .* and best = 0\.0, expected two finite numbers"
        ):
            check_wording(Miss(Table()))
