"""Fitness of one agent for several places: it passes all of them, or rides along a wall between them."""

from typing import Literal

import numpy as np

from driftform.builtin.closest_approach import ClosestApproach
from driftform.interfaces import Fitness
from driftform.types import Agent, FloatArray, Trajectory, Verdict
from driftform.util.options import Table, option
from driftform.water import Scenario

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
