"""Contract of fitness functions."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import permutations
from typing import Any, ClassVar

import numpy as np
import pytest

from driftform.interfaces import Fitness
from driftform.plugins.seams import require, require_scores
from driftform.testing.agents import first_samples, sphere_agent, straight_pipe
from driftform.testing.contract import AnsweringContract, Question
from driftform.types import Agent, End, FloatArray, Trajectory, Verdict
from driftform.util.rotations import matrix_from_quaternion
from driftform.water import Pipe, Scenario, Segment
from driftform.water.pipe import Vector

TARGETS: dict[str, Vector] = {"near": (1.0, 0.0, -0.5), "middle": (4.0, 0.3, 0.2), "far": (8.5, 0.0, 0.4)}

PIPE = straight_pipe(9.0, 1.0)
"""A level pipe, 9 m long, with a radius of 1 m."""


def straight_trajectory(start: Vector, end: Vector, times: FloatArray) -> Trajectory:
    """Return a trajectory at constant velocity from ``start`` to ``end`` (world frame, m), sampled at ``times`` (s, from 0)."""
    first, last = np.array(start), np.array(end)
    velocity = (last - first) / times[-1]
    k = len(times)
    return Trajectory(
        t=times,
        position=first + times[:, None] * velocity,
        quaternion=np.tile([1.0, 0.0, 0.0, 0.0], (k, 1)),
        velocity=np.tile([*velocity, 0.0, 0.0, 0.0], (k, 1)),
        end=End.OUTLET,
    )


def tumble(trajectory: Trajectory) -> Trajectory:
    """Return a level flight along the same path whose body rolls at 1 rad/s and pitches by up to 40 degrees."""
    t = trajectory.t
    pitch, rate, (sine, cosine) = 0.7 * np.sin(t), 0.7 * np.cos(t), (np.sin(t), np.cos(t))
    along, across = np.cos(pitch / 2), np.sin(pitch / 2)
    quaternion = np.column_stack(
        [along * np.cos(t / 2), along * np.sin(t / 2), across * np.cos(t / 2), -across * np.sin(t / 2)]
    )
    carried = np.einsum("kij,ki->kj", matrix_from_quaternion(quaternion), trajectory.velocity[:, :3])
    velocity = np.column_stack([carried, np.ones_like(t), rate * cosine, -rate * sine])
    return replace(trajectory, quaternion=quaternion, velocity=velocity)


class FitnessContract(AnsweringContract[Fitness[Any]]):
    """The contract of fitness functions.

    Attributes:
        rewards_closeness: True if a flight through a target, and only such a flight, has a fitness of 100.
        rewards_attitude: True if a flight along the same path in another attitude may have another fitness.
    """

    rewards_closeness: ClassVar[bool] = False
    rewards_attitude: ClassVar[bool] = False

    def questions(self) -> Sequence[Question]:
        """Return the score of each trajectory."""
        return [("score", flight, self.scenario(), self.agent()) for flight in self.trajectories()]

    def agent(self) -> Agent:
        """Return what flies: a sphere of 50 g with a radius of 10 mm."""
        return sphere_agent(0.01, 0.05)

    def trajectories(self) -> list[Trajectory]:
        """Return trajectories through each target, past all of them, out of the pipe, and a failed one of a single sample."""
        times = np.linspace(0, 9, 31)
        through = [straight_trajectory((0, 0, 0), point, times) for point in TARGETS.values()]
        past = straight_trajectory((0, 0, 0), (9, 0, -0.9), times)
        gone = straight_trajectory((0, 0, 0), (-1, 50, 0), times)
        return [*through, past, gone, replace(first_samples(past), end=End.NON_FINITE)]

    def scenario(self, *names: str) -> Scenario:
        """Return the pipe with the named targets, by default with all."""
        return Scenario(pipe=PIPE, targets={name: TARGETS[name] for name in names or TARGETS})

    def score(self, trajectory: Trajectory, *names: str) -> FloatArray:
        """Return the fitness (%) of a trajectory for the named targets, by default for all."""
        fitness = self.plugin()
        found = fitness.score(trajectory, self.scenario(*names), self.agent())
        return require_scores(found, len(names or TARGETS), fitness)

    @pytest.mark.parametrize("names", [("near",), ("far", "near"), ("near", "middle", "far")])
    def test_there_is_one_fitness_for_each_target(self, names: tuple[str, ...]) -> None:
        """The score is a vector over the scenario's targets, for one target or many."""
        for trajectory in self.trajectories():
            self.score(trajectory, *names)

    def test_a_flight_through_a_target_is_perfect_for_it(self) -> None:
        """Its fitness is 100 for that target only, in the order of the targets; if the fitness ``rewards_closeness``."""
        through = self.trajectories()[: len(TARGETS)] if self.rewards_closeness else []
        for number, trajectory in enumerate(through):
            score = self.score(trajectory)
            assert score[number] == pytest.approx(100, rel=1e-9)
            assert (np.delete(score, number) < 100).all()

    def test_values_follow_the_order_of_the_targets(self) -> None:
        """The same three targets in each other order have the same values, in that order."""
        for trajectory in self.trajectories():
            values = dict(zip(TARGETS, self.score(trajectory), strict=True))
            for names in permutations(TARGETS):
                np.testing.assert_array_equal(self.score(trajectory, *names), [values[name] for name in names])

    def test_the_body_frame_is_not_taken_for_the_world(self) -> None:
        """A flight along the same path that pitches and rolls scores the same, unless the fitness ``rewards_attitude``."""
        for trajectory in [] if self.rewards_attitude else self.trajectories():
            assert self.score(tumble(trajectory)) == pytest.approx(self.score(trajectory), abs=1e-9)

    def test_a_world_that_is_turned_about_the_vertical_is_the_same(self) -> None:
        """Pipe, targets and flight that are turned together by 120 degrees score the same: the pipe need not run along x."""
        turn, (w, z) = np.array([[-0.5, -(0.75**0.5), 0], [0.75**0.5, -0.5, 0], [0, 0, 1]]), (0.5, 0.75**0.5)
        end, *points = (turn @ np.array([(9.0, 0.0, 0.0), *TARGETS.values()]).T).T.tolist()
        pipe = Pipe(segments=(Segment(start=(0.0, 0.0, 0.0), end=end, radius=1.0),))
        scenario, fitness = Scenario(pipe=pipe, targets=dict(zip(TARGETS, points, strict=True))), self.plugin()
        product = np.array([[w, 0, 0, -z], [0, w, -z, 0], [0, z, w, 0], [z, 0, 0, w]])
        for trajectory in map(tumble, self.trajectories()):
            position, quaternion = trajectory.position @ turn.T, trajectory.quaternion @ product.T
            turned = replace(trajectory, position=position, quaternion=quaternion)
            found = require_scores(fitness.score(turned, scenario, self.agent()), len(points), fitness)
            assert found == pytest.approx(self.score(trajectory), abs=1e-6)

    def test_what_comes_after_a_target_counts_unless_the_fitness_judges_passing(self) -> None:
        """A flight that ends a bore after a target scores the same for it as the whole flight, if it ``judges_passing``."""
        ends: list[Vector] = [(9.0, 0.9, -0.3), (9.0, 0.0, -0.9)] if self.plugin().judges_passing else []
        for end in ends:
            whole = straight_trajectory((0, 0, 0), end, np.linspace(0, 9, 91))
            short = replace(first_samples(whole, 31), end=whole.end)
            assert self.score(short, "near")[0] == pytest.approx(self.score(whole, "near")[0], rel=1e-12)

    def test_people_read_a_number_with_its_unit_and_a_verdict(self) -> None:
        """Every fitness has a finite measure, a text of one line with its unit, and a verdict."""
        fitness = self.plugin()
        assert fitness.heading
        assert fitness.goal
        measured = np.array([fitness.measure(value) for value in np.linspace(0, 100, 201).tolist()])
        assert (np.diff(measured) >= 0).all() or (np.diff(measured) <= 0).all(), "it goes in one direction"
        for value in np.linspace(0, 100, 101).tolist():
            assert np.isfinite(fitness.measure(value))
            require(fitness.judge(value), Verdict, fitness, "judge")
            text = require(fitness.describe(value), str, fitness, "describe")
            assert fitness.unit in text
            assert text == " ".join(text.split())

    def test_a_larger_fitness_never_has_a_worse_verdict(self) -> None:
        """From 0 to 100 the verdict goes from missed over near to reached, and never back."""
        order = [Verdict.MISSED, Verdict.NEAR, Verdict.REACHED]
        grades = [order.index(self.plugin().judge(value)) for value in np.linspace(0, 100, 201).tolist()]
        assert grades == sorted(grades) and (grades[0], grades[-1]) == (0, 2)
