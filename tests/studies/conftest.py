"""What the studies share: worker processes, and how sensitive a flight is."""

import multiprocessing
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest

from driftform.motion.path.interpolation import interpolate_positions
from driftform.testing.simulator import largest_distance
from driftform_native.simulator import NativeOptions, NativeSimulator

NUDGE = 1e-8
"""m."""


@pytest.fixture(scope="session")
def workers():
    """Two worker processes; what they are to call must be of an installed package."""
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
        yield pool


@pytest.fixture(scope="session")
def sensitivity():
    """How many times farther than it was released off its place an agent gets off its path.

    Both flights are as exact as the native backend can make them. Where the answer is 1e7, an error of 1e-10 in one
    step becomes a millimetre: no tolerance that double precision allows for makes sure of such a flight.
    """
    exact = NativeSimulator(NativeOptions(tolerance=1e-10, accuracy=1e6))

    def times_farther(agent, scenario):
        x, y, z = scenario.release_position()
        aside = scenario.release.model_copy(update={"position": (x, y, z + NUDGE)})
        flights = [exact.simulate(agent, where) for where in (scenario, scenario.model_copy(update={"release": aside}))]
        times = np.arange(0.0, min(trajectory.t[-1] for trajectory in flights), 0.01)
        here, there = (interpolate_positions(trajectory, times) for trajectory in flights)
        return largest_distance(here, there) / NUDGE

    return times_farther
