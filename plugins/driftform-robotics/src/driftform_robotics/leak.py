"""Fitness: how long a chemical sensor on the agent is in the plume of each leak."""

import numpy as np

from driftform.interfaces import Fitness, option
from driftform.types import Agent, FloatArray, Trajectory, Verdict
from driftform.water import Scenario
from driftform_robotics.options import SensorOptions


class LeakOptions(SensorOptions):
    """Rate of the leaks, and the sensor."""

    rate: float = option(0.001, "mass flow into the pipe at each leak", "kg/s", ge=1e-9, le=1000)
    threshold: float = option(
        2.5e-5, "concentration at which the sensor detects the leak half of the time", "kg/m3", ge=1e-15, le=1000
    )
    interval: float = option(0.05, "time between two readings of the sensor", "s", ge=1e-4, le=1)


class Leak(Fitness[LeakOptions]):
    """Time that the agent spends in the plume of each leak, in percent of the time that the water spends there.

    Every target is a leak, at the nearest point of the wall. A reading of the concentration C counts
    C / (C + threshold): almost 0 far from the plume, 0.5 at its edge, almost 1 deep inside. An agent that just misses
    the plume is therefore better than one that stays far away. The fitness is the integral over the flight, divided by
    the time that the water takes from the leak to the end of the pipe, and at most 100.
    """

    name = "leak"
    Options = LeakOptions
    heading = "time in the plume %"
    goal = "half of the time that the water spends in the plume"

    def judge(self, fitness: float) -> Verdict:
        """Return whether the sensor is in the plume for half of the time of the water; a tenth is nearly reached."""
        if fitness >= 50:
            return Verdict.REACHED
        return Verdict.NEAR if fitness >= 10 else Verdict.MISSED

    def score(self, trajectory: Trajectory, scenario: Scenario, agent: Agent) -> FloatArray:
        """Return the fitness for each target, 0 to 100, (targets,).

        Raises ValueError if the scenario has no pipe, or if its water is at rest.
        """
        from driftform.motion import path
        from driftform_robotics.plume import make_plume
        from driftform_robotics.sensors import point_positions

        flight, seen = path.resample(trajectory, 1 / self.options.interval), []
        where = point_positions(flight, np.array(self.options.sensor))
        for point in scenario.target_points().values():
            plume = make_plume(scenario, point, self.options.rate, self.options.diffusivity)
            C = plume.concentration(where)
            detected = np.trapezoid(C / (C + self.options.threshold), flight.t)
            seen.append(detected * plume.speed / max(plume.length, 1e-9))
        return np.clip(100 * np.array(seen, dtype=np.float64), 0.0, 100.0)
