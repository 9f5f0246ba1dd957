"""Equation 25: closest approach over the farthest distance there could be."""

import numpy as np
import pytest

from driftform.builtin.fitness import ClosestApproach
from driftform.testing import FitnessContract
from driftform.testing.agents import sphere_agent
from driftform.testing.fitness import straight_trajectory
from driftform.types import End, Trajectory, Verdict
from driftform.util.options import Table
from driftform.water import Pipe, Scenario, Segment

PIPE = Pipe(segments=(Segment(start=(0, 0, 0), end=(9, 0, 0), radius=1.0),))


class TestClosestApproach(FitnessContract):
    rewards_closeness = True

    def plugin(self):
        return ClosestApproach(Table())


def score(trajectory, *targets, pipe=PIPE):
    scenario = Scenario(pipe=pipe, targets={f"T{i}": target for i, target in enumerate(targets)})
    return ClosestApproach(Table()).score(trajectory, scenario, sphere_agent(0.01, 0.05))


def test_a_straight_path_that_passes_between_two_samples_has_its_closed_form():
    trajectory = straight_trajectory((0, 0, 0), (9, 0, 0), np.array([0.0, 9.0]))
    # The foot of the perpendicular is 2.3 m down the pipe, 0.5 m from the target; the farthest point of the pipe
    # is on the outlet's rim, right across the axis.
    expected = 100 * (1 - 0.5 / np.hypot(9 - 2.3, 0.5 + 1))
    assert score(trajectory, (2.3, 0.3, -0.4)) == pytest.approx([expected], rel=1e-12)


@pytest.mark.parametrize("axis", [(9.0, 0.0, 0.0), (3.0, -2.0, 1.0), (0.0, 0.0, 0.4)])
@pytest.mark.parametrize("seed", range(3))
def test_d_max_is_the_distance_of_the_farthest_point_of_the_pipe(axis, seed):
    rng = np.random.default_rng(seed)
    start, along, radius = np.array([0.5, -1.0, 2.0]), np.array(axis), 0.7
    pipe = Pipe(segments=(Segment(start=tuple(start), end=tuple(start + along), radius=radius),))
    unit = along / np.linalg.norm(along)
    _, _, (_, e1, e2) = np.linalg.svd(unit[None])
    share, angle = rng.random(200_000), rng.uniform(0, 2 * np.pi, 200_000)
    # Uniform over the volume, and as many on the rims, where the farthest point must be.
    for r in (radius * np.sqrt(rng.random(200_000)), radius):
        ring = r * np.cos(angle) * e1[:, None] + r * np.sin(angle) * e2[:, None]
        inside = start + (share[:, None] if r is not radius else np.round(share)[:, None]) * along + ring.T
        target = start + rng.random() * along
        found = np.linalg.norm(inside - target, axis=1).max()
        exact = pipe.farthest_distance(target)
        assert found <= exact * (1 + 1e-12)
    assert found == pytest.approx(exact, rel=1e-6)
    off_axis = start + 0.3 * along + 0.6 * e1
    ends = np.vstack([start + ring.T, start + along + ring.T])
    assert pipe.farthest_distance(off_axis) == pytest.approx(np.linalg.norm(ends - off_axis, axis=1).max(), rel=1e-6)


def test_the_same_target_is_scored_anew_in_another_pipe():
    trajectory = straight_trajectory((0, 0, 0), (9, 0, 0), np.array([0.0, 9.0]))
    for length in (9.0, 12.0, 9.0):
        pipe = Pipe(segments=(Segment(start=(0, 0, 0), end=(length, 0, 0), radius=1.0),))
        expected = 100 * (1 - 0.5 / np.hypot(length - 2.3, 0.5 + 1))
        assert score(trajectory, (2.3, 0.3, -0.4), pipe=pipe) == pytest.approx([expected], rel=1e-12)


def test_a_flight_that_leaves_the_pipe_far_behind_has_no_fitness_and_not_less():
    gone = straight_trajectory((0, 0, 0), (0, 100, 0), np.array([0.0, 1.0]))
    away = Trajectory(gone.t, gone.position - np.array([50, 0, 0]), gone.quaternion, gone.velocity, End.INLET)
    assert score(away, (4.0, 0.0, 0.0)) == [0.0]


def test_its_words_are_those_of_the_error_in_percent_of_d_max():
    fitness = ClosestApproach(Table())
    assert fitness.heading == "error % of d_max"
    assert fitness.describe(97.5) == "2.50 %"
    assert [fitness.judge(f) for f in (99.5, 99.0, 98.9, 95.0, 94.9)] == [
        *(Verdict.REACHED, Verdict.REACHED),
        *(Verdict.NEAR, Verdict.NEAR),
        Verdict.MISSED,
    ]
