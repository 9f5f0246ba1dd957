"""The paper's fitness (equation 25): the closest approach to each target, relative to the farthest possible distance."""

import numpy as np

from driftform.interfaces import Fitness
from driftform.types import Agent, FloatArray, Trajectory, Verdict
from driftform.util.options import Table
from driftform.water import Scenario


class ClosestApproach(Fitness[Table]):
    """``100 (1 - d_min / d_max)``, in percent.

    d_min is the least distance of the core's centre from the target along the whole flight, also between samples;
    d_max is the distance from the target to the farthest point of the pipe's volume. ``100 - fitness`` is the
    error in percent of d_max. In a pipe with parts both are distances through the water
    (:mod:`driftform.motion.path.targets`).
    """

    name = "closest-approach"
    heading = "error % of d_max"
    goal = "an error of at most 1 % of the farthest distance in the pipe"
    judges_passing = True

    def measure(self, fitness: float) -> float:
        """Return the error, in percent of d_max."""
        return 100 - fitness

    def judge(self, fitness: float) -> Verdict:
        """Return whether the target is reached within 1 % of d_max, or nearly, within the paper's 5 %."""
        error = self.measure(fitness)
        if error <= 1:
            return Verdict.REACHED
        return Verdict.NEAR if error <= 5 else Verdict.MISSED

    def is_hit(self, fitness: float, miss: float, within: float) -> bool:
        """Return whether the flight passes its target near enough."""
        return miss <= within

    def score(self, trajectory: Trajectory, scenario: Scenario, agent: Agent) -> FloatArray:
        """Return the fitness for each target, 0 to 100, (targets,)."""
        from driftform.motion.path.targets import approach_targets, farthest_distances

        d_min, _ = approach_targets(trajectory, scenario)
        d_max = farthest_distances(scenario)
        return np.asarray(np.maximum(0.0, 100 * (1 - d_min / d_max)), dtype=np.float64)
