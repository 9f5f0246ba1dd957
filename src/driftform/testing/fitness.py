"""What every fitness must do."""

import pickle
from typing import Any, ClassVar

import numpy as np
import pytest

from driftform.interfaces import Fitness
from driftform.scenario import Pipe, Scenario, Segment, Vector
from driftform.types import End, FloatArray, Trajectory

TARGETS: dict[str, Vector] = {"near": (1.0, 0.0, -0.5), "middle": (4.0, 0.3, 0.2), "far": (8.5, 0.0, 0.4)}

PIPE = Pipe(segments=(Segment(start=(0.0, 0.0, 0.0), end=(9.0, 0.0, 0.0), radius=1.0),))
"""A level one, 9 m long, of 1 m radius."""


def straight_trajectory(start: Vector, end: Vector, times: FloatArray) -> Trajectory:
    """A flight at constant velocity from one point to another of the world, sampled at ``times`` (s, from 0)."""
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
    """Inherit, and say how the fitness is made::

        class TestMyFitness(FitnessContract):
            rewards_closeness = True

            def plugin(self) -> MyFitness:
                return MyFitness(MyOptions())

    Attributes
    ----------
    rewards_closeness
        true where a flight right through a target, and no other, has a fitness of 100.
    """

    rewards_closeness: ClassVar[bool] = False

    def plugin(self) -> Fitness[Any]:
        """Return the fitness to be tested."""
        raise NotImplementedError

    def trajectories(self) -> list[Trajectory]:
        """Flights of many kinds: through a target, past all, out of the pipe, a single sample, a failed one."""
        times = np.linspace(0, 9, 31)
        through = [straight_trajectory((0, 0, 0), point, times) for point in TARGETS.values()]
        past = straight_trajectory((0, 0, 0), (9, 0, -0.9), times)
        gone = straight_trajectory((0, 0, 0), (-1, 50, 0), times)
        still = Trajectory(
            np.zeros(1), np.zeros((1, 3)), np.array([[1.0, 0, 0, 0]]), np.zeros((1, 6)), End.NON_FINITE
        )
        return [*through, past, gone, still]

    def scenario(self, *names: str) -> Scenario:
        """The pipe with some of the targets, or with all."""
        return Scenario(pipe=PIPE, targets={name: TARGETS[name] for name in names or TARGETS})

    @pytest.mark.parametrize("names", [("near",), ("far", "near"), ("near", "middle", "far")])
    def test_there_is_one_fitness_for_each_target(self, names: tuple[str, ...]) -> None:
        """A vector over the scenario's targets, whether one or many."""
        for flight in self.trajectories():
            score = self.plugin().score(flight, self.scenario(*names))
            assert score.shape == (len(names),)
            assert score.dtype == np.float64

    def test_fitness_is_a_percentage(self) -> None:
        """100 is best and 0 is worst, as a roulette wheel and an error in percent need it; also where flights fail."""
        for flight in self.trajectories():
            score = self.plugin().score(flight, self.scenario())
            assert ((score >= 0) & (score <= 100)).all()

    def test_a_flight_through_a_target_is_perfect_for_it(self) -> None:
        """And for that target alone: the order of values is that of the scenario's targets."""
        if not self.rewards_closeness:
            pytest.skip("this fitness is not about closeness")
        for number, flight in enumerate(self.trajectories()[: len(TARGETS)]):
            score = self.plugin().score(flight, self.scenario())
            assert score[number] == pytest.approx(100, rel=1e-9)
            assert (np.delete(score, number) < 100).all()

    def test_values_follow_the_order_of_the_targets(self) -> None:
        """The same targets in another order have the same values in that order."""
        for flight in self.trajectories():
            there = self.plugin().score(flight, self.scenario("near", "middle", "far"))
            back = self.plugin().score(flight, self.scenario("far", "middle", "near"))
            np.testing.assert_array_equal(there, back[::-1])

    def test_the_same_flight_has_the_same_fitness(self) -> None:
        """A pickled copy in a worker process scores the same, to the last bit."""
        copy = pickle.loads(pickle.dumps(self.plugin()))
        for flight in self.trajectories():
            again = copy.score(pickle.loads(pickle.dumps(flight)), self.scenario())
            np.testing.assert_array_equal(self.plugin().score(flight, self.scenario()), again)
