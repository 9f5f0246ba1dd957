"""One agent for several places: the target that it misses most decides."""

import math
from dataclasses import replace

import numpy as np
import pytest

from driftform.builtin.fitness import ClosestApproach, GroupFitness, GroupOptions
from driftform.testing import FitnessContract
from driftform.testing.agents import sphere_agent
from driftform.types import End, Trajectory, Verdict
from driftform.util.options import Table
from driftform.water import Pipe, Scenario, Segment

PIPE = Pipe(segments=(Segment(start=(0.0, 0.0, 0.0), end=(9.0, 0.0, 0.0), radius=1.0),))
SCENARIO = Scenario(pipe=PIPE, targets={"A": (2.0, 0.0, 0.5), "B": (5.0, 0.0, 0.5), "C": (8.0, 0.0, -0.5)})
AGENT = sphere_agent(0.01, 0.004)


class TestGroup(FitnessContract):
    def plugin(self):
        return GroupFitness(GroupOptions())


def fly(*heights):
    """A flight through heights at x = 0, 1, 2, ... 9 m."""
    t = np.arange(len(heights), dtype=float)
    position = np.column_stack([t, np.zeros_like(t), heights])
    turn, velocity = np.tile([1.0, 0, 0, 0], (len(t), 1)), np.tile([1.0, 0, 0, 0, 0, 0], (len(t), 1))
    return Trajectory(t, position, turn, velocity, End.OUTLET)


LEVEL = fly(*[0.5] * 10)


def test_all_targets_of_a_group_have_the_fitness_of_the_worst():
    each = ClosestApproach(Table()).score(LEVEL, SCENARIO, AGENT)
    found = GroupFitness(GroupOptions()).score(LEVEL, SCENARIO, AGENT)
    assert found.tolist() == [each.min()] * 3
    apart = GroupFitness(GroupOptions(groups=(("A", "B"), ("C",)))).score(LEVEL, SCENARIO, AGENT)
    assert apart.tolist() == pytest.approx([each[:2].min(), each[:2].min(), each[2]])
    assert apart[0] > 99.9 > apart[2]


def test_a_group_that_forgets_a_target_is_refused():
    with pytest.raises(ValueError, match="must name each of the targets once: A, B, C"):
        GroupFitness(GroupOptions(groups=(("A", "B"),))).score(LEVEL, SCENARIO, AGENT)


def test_a_ride_is_as_far_off_the_crown_as_its_lowest_point_between_the_targets():
    scenario = SCENARIO.model_copy(update={"targets": {"A": (2.0, 0.0, 0.9), "B": (7.0, 0.0, 0.9)}})
    crown = GroupFitness(GroupOptions(ride="crown"))
    # It touches the crown but for x = 5, where it is .4 m below, a fifth of the bore.
    dips = fly(0, 0, 0.99, 0.99, 0.99, 0.6, 0.99, 0.99, 0, 0)
    assert crown.score(dips, scenario, AGENT)[0] == pytest.approx(80, abs=0.5)
    assert GroupFitness(GroupOptions(ride="floor")).score(dips, scenario, AGENT)[0] < 5
    assert crown.score(fly(0.99, 0.99, 0.99, 0.99), scenario, AGENT)[0] == 0.0


def test_a_ride_along_the_crown_of_a_pipe_that_rises_from_anywhere_is_perfect():
    start, way = np.array([4.0, 2.0, 1.0]), np.array([math.cos(0.5), 0.0, math.sin(0.5)])
    pipe = Pipe(segments=(Segment(start=tuple(start), end=tuple(start + 9 * way), radius=0.5),))
    crown = start + np.arange(10.0)[:, None] * way + 0.5 * np.array([-math.sin(0.5), 0.0, math.cos(0.5)])
    ends = {name: tuple(0.9 * crown[at] + 0.1 * (start + at * way)) for name, at in (("A", 2), ("B", 7))}
    scenario = Scenario(pipe=pipe, targets=ends)
    ride = replace(LEVEL, position=crown)
    assert GroupFitness(GroupOptions(ride="crown")).score(ride, scenario, AGENT)[0] > 98


def test_within_five_percent_is_reached_and_within_ten_is_near():
    group = GroupFitness(GroupOptions())
    assert [group.judge(fitness) for fitness in (95.5, 91.0, 89.0)] == [Verdict.REACHED, Verdict.NEAR, Verdict.MISSED]
