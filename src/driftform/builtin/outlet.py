"""Fitness in branched pipes: whether a flight leaves by the outlet that it should take, and how close it comes otherwise."""

import numpy as np

from driftform.interfaces import Fitness
from driftform.types import Agent, FloatArray, Trajectory
from driftform.util.options import Table
from driftform.water import Scenario

PASSED_BY = 90.0
"""Fitness (%) below which flights stay that do not leave by their outlet: less than a point that is nearly reached."""


class OutletFitness(Fitness[Table]):
    """100 for a flight that leaves by its outlet, and at most 90 for one that does not.

    A target is the name of an outlet. The flight that does not leave there has ``90 (1 - d_min / d_max)``: the closer it
    comes to the outlet, the higher, so that a search is led there. Both are distances through the water, as those of
    ``closest-approach``, by which a target that is a point is scored.
    """

    name = "outlet"
    goal = "a flight that leaves by its outlet"
    share = "leave there %"

    def score(self, trajectory: Trajectory, scenario: Scenario, agent: Agent) -> FloatArray:
        """Return the fitness for each target, 0 to 100, (targets,)."""
        from driftform.motion.path.targets import approach_targets, farthest_distances, name_outlet

        d_min, _ = approach_targets(trajectory, scenario)
        closeness = np.maximum(0.0, 1 - d_min / farthest_distances(scenario))
        targets, outlet = list(scenario.targets.values()), name_outlet(trajectory, scenario)
        best = np.array([PASSED_BY if isinstance(target, str) else 100.0 for target in targets])
        leaves = np.array([isinstance(target, str) and target == outlet for target in targets], dtype=bool)
        return np.asarray(np.where(leaves, 100.0, best * closeness), dtype=np.float64)
