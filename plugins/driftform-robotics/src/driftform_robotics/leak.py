"""How much a chemical sensor on the agent sees of each leak."""

from typing import TYPE_CHECKING

import numpy as np

from driftform.interfaces import Fitness
from driftform.options import Table, option
from driftform.scenario import Scenario, Vector
from driftform.types import FloatArray, Trajectory

if TYPE_CHECKING:
    from driftform_robotics.plume import Plume


class LeakOptions(Table):
    """What leaks, how it spreads, and what the sensor makes of it."""

    rate: float = option(0.001, "what comes in at each leak", "kg/s", gt=0)
    diffusivity: float | None = option(
        None, "turbulent diffusivity across the pipe; by default that of its wall friction", "m2/s", gt=0
    )
    threshold: float = option(
        2.5e-5, "concentration at which the sensor tells of the leak half the time", "kg/m3", gt=0
    )
    sensor: Vector = option((0.0, 0.0, 0.0), "where the sensor is in the body", "m")
    interval: float = option(0.05, "time between two readings of the sensor", "s", gt=0, le=1)


class Leak(Fitness[LeakOptions]):
    """How long the agent is in the plume of each leak, in percent of the time that the water itself is.

    Every target is a leak: at the place of the wall nearest to it. A reading of the concentration C counts
    C / (C + threshold): almost nothing far from the plume, a half at its edge, one deep inside, so that an agent that
    just misses the plume is better than one that stays far away. The fitness is the sum over the flight, over the time
    that water takes from the leak to the end of the pipe; what is more than that is 100.
    """

    name = "leak"
    Options = LeakOptions

    def score(self, trajectory: Trajectory, scenario: Scenario) -> FloatArray:
        """Return the fitness for each target, 0 to 100, (targets,).

        Raises
        ------
        ValueError
            where the scenario's water carries no plume.
        """
        t, readings = self._read_sensor(trajectory, scenario)
        seen = [
            np.trapezoid(C / (C + self.options.threshold), t) * plume.speed / max(plume.length, 1e-9)
            for plume, C in readings
        ]
        return np.clip(100 * np.array(seen, dtype=np.float64), 0.0, 100.0)

    def seconds_in_plume(self, trajectory: Trajectory, scenario: Scenario) -> FloatArray:
        """Return for each leak how long the sensor reads more than the threshold, s, (targets,)."""
        t, readings = self._read_sensor(trajectory, scenario)
        threshold = self.options.threshold
        inside = [np.trapezoid(np.where(threshold < C, 1.0, 0.0), t) for _, C in readings]
        return np.array(inside, dtype=np.float64)

    def _read_sensor(
        self, trajectory: Trajectory, scenario: Scenario
    ) -> tuple[FloatArray, list[tuple["Plume", FloatArray]]]:
        """Times of the readings, s, and for each leak its plume and what is read of it, kg/m3."""
        from driftform.trajectory.resampling import resample
        from driftform_robotics.plume import make_plume
        from driftform_robotics.sensors import point_positions

        flight = resample(trajectory, 1 / self.options.interval)
        where = point_positions(flight, np.array(self.options.sensor))
        plumes = [
            make_plume(scenario, point, self.options.rate, self.options.diffusivity)
            for point in scenario.targets.values()
        ]
        return flight.t, [(plume, plume.concentration(where)) for plume in plumes]
