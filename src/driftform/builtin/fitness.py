"""Fitness by the closest approach to each target (the paper's equation 25), by outlets, and for groups of targets."""

from typing import Literal

import numpy as np

from driftform.interfaces import Fitness
from driftform.types import Agent, FloatArray, Trajectory, Verdict
from driftform.util.options import Table, option
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

    def is_hit(self, fitness: float, miss: float, within: float) -> bool:
        """Return whether the flight passes its target near enough."""
        return miss <= within

    def score(self, trajectory: Trajectory, scenario: Scenario, agent: Agent) -> FloatArray:
        """Return the fitness for each target, 0 to 100, (targets,)."""
        from driftform.motion.path.targets import approach_targets, farthest_distances

        d_min, _ = approach_targets(trajectory, scenario)
        d_max = farthest_distances(scenario)
        return np.asarray(np.maximum(0.0, 100 * (1 - d_min / d_max)), dtype=np.float64)


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


HIT = 95.0
"""Fitness (%) from which a flight passes all places: the paper's 5 % of the farthest distance at worst."""

STATIONS = 200
"""Points of the path between two targets at which its distance from the wall is measured."""


class GroupOptions(Table):
    """Which places belong together, and how a flight should pass between them."""

    groups: tuple[tuple[str, ...], ...] = option(
        (), "names of the targets that one flight should pass, for each group; one group of all targets by default"
    )
    ride: Literal["none", "crown", "floor"] = option(
        "none",
        "'crown' or 'floor': the flight should also stay at the highest or the lowest wall of a straight pipe between the "
        "first and the last target of the group along the pipe",
    )


class GroupFitness(Fitness[GroupOptions]):
    """The closest approach to the target of a group that a flight misses most: one agent passes all of them.

    Each target of a group has the fitness of the group, ``100 (1 - d / d_max)`` of its worst target. With ``ride``, the largest
    distance of the path from the crown or the floor between two targets counts too, relative to the bore.
    """

    name = "group"
    Options = GroupOptions
    heading = "worst error % of d_max"
    goal = "all targets of its group within 5 % of the farthest distance in the pipe"
    share = "pass all %"

    def measure(self, fitness: float) -> float:
        """Return the error at the worst target, in percent of d_max."""
        return 100 - fitness

    def judge(self, fitness: float) -> Verdict:
        """Return whether all targets of the group are passed within the paper's 5 % of d_max; within 10 % is near."""
        if fitness >= HIT:
            return Verdict.REACHED
        return Verdict.NEAR if fitness >= 2 * HIT - 100 else Verdict.MISSED

    def score(self, trajectory: Trajectory, scenario: Scenario, agent: Agent) -> FloatArray:
        """Return for each target the fitness of its group, 0 to 100, (targets,).

        Raises ValueError if a group names no target, a target is in none or in two, or the pipe has no crown to
        ride along.
        """
        names, points = scenario.target_names, scenario.target_array()
        each = ClosestApproach(Table()).score(trajectory, scenario, agent)
        groups = self.options.groups or (names,)
        if sorted(name for group in groups for name in group) != sorted(names):
            raise ValueError(f"[fitness] groups must name each of the targets once: {', '.join(names)}")
        fitness = np.empty(len(names))
        for group in groups:
            at = [names.index(name) for name in group]
            worst = float(each[at].min())
            if self.options.ride != "none":
                worst = min(worst, self._score_ride(trajectory, scenario, points[at]))
            fitness[at] = worst
        return fitness

    def _score_ride(self, trajectory: Trajectory, scenario: Scenario, points: FloatArray) -> float:
        pipe = scenario.pipe.straight
        if pipe is None:
            raise ValueError("[fitness] ride needs a straight pipe")
        start, way = np.array(pipe.start), np.subtract(pipe.end, pipe.start)
        axis = way / np.linalg.norm(way)
        up = np.array([0.0, 0.0, 1.0]) - axis[2] * axis
        if np.linalg.norm(up) < 1e-3:
            raise ValueError("[fitness] ride: a vertical pipe has no crown and no floor")
        side = (1.0 if self.options.ride == "crown" else -1.0) * pipe.radius * up / np.linalg.norm(up)
        along = (trajectory.position - start) @ axis
        between = (points - start) @ axis
        wanted = np.linspace(float(between.min()), float(between.max()), STATIONS)
        if along.max() < wanted.max():
            return 0.0
        order = np.argsort(along, kind="stable")
        path = np.column_stack([np.interp(wanted, along[order], c[order]) for c in trajectory.position.T])
        off = np.linalg.norm(path - (start + wanted[:, None] * axis + side), axis=1)
        return float(max(0.0, 100 * (1 - off.max() / (2 * pipe.radius))))
