"""Contract of fitness functions."""

import pickle
from typing import Any, ClassVar

import numpy as np
import pytest

from driftform.interfaces import Fitness
from driftform.scenario import Pipe, Scenario, Segment, Vector
from driftform.types import End, FloatArray, Trajectory

TARGETS: dict[str, Vector] = {"near": (1.0, 0.0, -0.5), "middle": (4.0, 0.3, 0.2), "far": (8.5, 0.0, 0.4)}

PIPE = Pipe(segments=(Segment(start=(0.0, 0.0, 0.0), end=(9.0, 0.0, 0.0), radius=1.0),))
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


class FitnessContract:
    """Inherit this class, and make the fitness::

        class TestMyFitness(FitnessContract):
            rewards_closeness = True

            def plugin(self) -> MyFitness:
                return MyFitness(MyOptions())

    Attributes
    ----------
    rewards_closeness
        True if a flight through a target, and only such a flight, has a fitness of 100.
    """

    rewards_closeness: ClassVar[bool] = False

    def plugin(self) -> Fitness[Any]:
        """Return the fitness to be tested."""
        raise NotImplementedError

    def trajectories(self) -> list[Trajectory]:
        """Return trajectories through each target, past all of them, out of the pipe, and a failed one of a single sample."""
        times = np.linspace(0, 9, 31)
        through = [straight_trajectory((0, 0, 0), point, times) for point in TARGETS.values()]
        past = straight_trajectory((0, 0, 0), (9, 0, -0.9), times)
        gone = straight_trajectory((0, 0, 0), (-1, 50, 0), times)
        still = Trajectory(
            np.zeros(1), np.zeros((1, 3)), np.array([[1.0, 0, 0, 0]]), np.zeros((1, 6)), End.NON_FINITE
        )
        return [*through, past, gone, still]

    def scenario(self, *names: str) -> Scenario:
        """Return the pipe with the named targets, by default with all."""
        return Scenario(pipe=PIPE, targets={name: TARGETS[name] for name in names or TARGETS})

    @pytest.mark.parametrize("names", [("near",), ("far", "near"), ("near", "middle", "far")])
    def test_there_is_one_fitness_for_each_target(self, names: tuple[str, ...]) -> None:
        """The score is a vector over the scenario's targets, for one target or many."""
        for trajectory in self.trajectories():
            score = self.plugin().score(trajectory, self.scenario(*names))
            assert score.shape == (len(names),)
            assert score.dtype == np.float64

    def test_fitness_is_a_percentage(self) -> None:
        """100 is best and 0 is worst, as the roulette wheel and the error in percent require, also for failed flights."""
        for trajectory in self.trajectories():
            score = self.plugin().score(trajectory, self.scenario())
            assert ((score >= 0) & (score <= 100)).all()

    def test_a_flight_through_a_target_is_perfect_for_it(self) -> None:
        """Its fitness is 100 for that target only; the values are in the order of the scenario's targets."""
        if not self.rewards_closeness:
            pytest.skip("this fitness is not about closeness")
        for number, trajectory in enumerate(self.trajectories()[: len(TARGETS)]):
            score = self.plugin().score(trajectory, self.scenario())
            assert score[number] == pytest.approx(100, rel=1e-9)
            assert (np.delete(score, number) < 100).all()

    def test_values_follow_the_order_of_the_targets(self) -> None:
        """The same targets in another order have the same values, in that order."""
        for trajectory in self.trajectories():
            there = self.plugin().score(trajectory, self.scenario("near", "middle", "far"))
            back = self.plugin().score(trajectory, self.scenario("far", "middle", "near"))
            np.testing.assert_array_equal(there, back[::-1])

    def test_the_same_flight_has_the_same_fitness(self) -> None:
        """A pickled copy in a worker process scores the same, to the last bit."""
        copy = pickle.loads(pickle.dumps(self.plugin()))
        for trajectory in self.trajectories():
            again = copy.score(pickle.loads(pickle.dumps(trajectory)), self.scenario())
            np.testing.assert_array_equal(self.plugin().score(trajectory, self.scenario()), again)
