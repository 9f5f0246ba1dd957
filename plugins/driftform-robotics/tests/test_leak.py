"""The fitness of what a chemical sensor sees, and the search for a leak by it."""

import numpy as np
import pytest

from driftform.testing import FitnessContract
from driftform.testing.agents import sphere_agent
from driftform.testing.fitness import straight_trajectory
from driftform.water import Pipe, Scenario, Segment
from driftform.water.flow import UniformFlow
from driftform_robotics.leak import Leak, LeakOptions
from driftform_robotics.plume import make_plume

FLOAT = sphere_agent(0.01, 0.05)

PIPE = Pipe(segments=(Segment(start=(0.0, 0.0, 0.0), end=(16.0, 0.0, 0.0), radius=0.5),))


def scenario(*leaks, speed=1.0):
    targets = {f"L{i}": leak for i, leak in enumerate(leaks)}
    return Scenario(pipe=PIPE, targets=targets, flow=UniformFlow(speed=speed))


def along(y, z, seconds=16.0):
    return straight_trajectory((0.0, y, z), (16.0, y, z), np.linspace(0, seconds, 41))


class TestLeakContract(FitnessContract):
    def plugin(self):
        return Leak(LeakOptions())


def test_drifting_along_the_leaking_wall_is_almost_perfect():
    """With a sensor of a threshold far below what is there, each reading counts one."""
    leak = Leak(LeakOptions(threshold=1e-9))
    [score] = leak.score(along(0.49, 0.0), scenario((2.0, 0.5, 0.0)), FLOAT)
    assert score == pytest.approx(100, abs=1)


def test_a_reading_at_the_threshold_counts_half():
    """An agent that stays where the concentration is C, while the water takes 14 s to the end of the pipe."""
    there, surroundings = (5.0, 0.3, 0.1), scenario((2.0, 0.5, 0.0))
    C = make_plume(surroundings, (2.0, 0.5, 0.0), 0.001).concentration(np.array([there]))[0]
    still = straight_trajectory(there, there, np.linspace(0, 7.0, 8))
    for share, expected in ((1.0, 25.0), (3.0, 37.5), (1 / 3, 12.5)):
        leak = Leak(LeakOptions(threshold=C / share))
        assert leak.score(still, surroundings, FLOAT) == pytest.approx([expected], rel=1e-6)


def test_nearer_to_the_plume_is_better_also_outside_of_it():
    leak, surroundings = Leak(LeakOptions()), scenario((2.0, 0.5, 0.0))
    scores = [leak.score(along(0.0, z), surroundings, FLOAT)[0] for z in (0.48, 0.4, 0.3, 0.2, 0.1, 0.0)]
    assert scores == sorted(scores) and len(set(scores)) == len(scores)
    assert 0 < scores[0] < 0.5 * scores[-1]


def test_every_leak_has_a_plume_of_its_own():
    leak = Leak(LeakOptions())
    both = scenario((2.0, 0.5, 0.0), (2.0, -0.5, 0.0))
    left, right = leak.score(along(0.4, 0.0), both, FLOAT)
    assert left > 2 * right
    assert leak.score(along(-0.4, 0.0), both, FLOAT) == pytest.approx([right, left])


def test_the_sensor_is_where_it_is_mounted():
    surroundings = scenario((2.0, 0.5, 0.0))
    at_side = Leak(LeakOptions(sensor=(0.0, 0.2, 0.0))).score(along(0.1, 0.0), surroundings, FLOAT)
    assert at_side == pytest.approx(Leak(LeakOptions()).score(along(0.3, 0.0), surroundings, FLOAT))


def test_an_agent_that_stays_longer_sees_more_but_never_more_than_all():
    leak, surroundings = Leak(LeakOptions()), scenario((2.0, 0.5, 0.0))
    slow = leak.score(along(0.4, 0.0, seconds=20.0), surroundings, FLOAT)
    assert slow > leak.score(along(0.4, 0.0), surroundings, FLOAT)
    assert leak.score(along(0.4, 0.0, seconds=100.0), surroundings, FLOAT) == [100.0]


def test_the_result_hardly_depends_on_how_often_the_sensor_is_read():
    surroundings = scenario((2.0, 0.5, 0.0))
    often, seldom = (
        Leak(LeakOptions(interval=interval)).score(along(0.35, 0.1), surroundings, FLOAT) for interval in (0.01, 0.05)
    )
    assert often == pytest.approx(seldom, rel=2e-3)
