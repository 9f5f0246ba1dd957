"""Flights of Exudyn's rigid body, with driftform's forces of water and wall."""

import math
from collections.abc import Callable, Sequence
from typing import Literal

from driftform.interfaces import AccuracyOptions, Simulator, option
from driftform.types import Agent, FloatArray, Trajectory
from driftform.water import Scenario

STEP_ORDER = 5
"""Order of DOPRI5: its longest step falls with the tolerance as the step does that its error control chooses.

With equal longest steps, two flights would differ from the path between their samples alike, and not show it.
"""


class ExudynOptions(AccuracyOptions):
    """Options of the Exudyn backend."""

    integrator: Literal["DOPRI5", "RK67", "RK44"] = option(
        "DOPRI5", "explicit integrator: DOPRI5 controls its error, RK67 and RK44 take all steps of the length max_step"
    )


class ExudynSimulator(Simulator[ExudynOptions]):
    """Flights by Exudyn's explicit solvers, of the system that :func:`driftform_exudyn.system.exudyn_system` returns.

    Exudyn knows a rigid body with its mass, its added mass and its loads, and asks driftform for the forces of water and wall.
    The error of a flight follows from its distance from one with ten times the tolerance. Nothing of driftform's integrator
    is used: the two share only the forces.
    """

    name = "exudyn"
    Options = ExudynOptions

    def simulate(self, agent: Agent, scenario: Scenario) -> Trajectory:
        """Return the flight; it ends at the outlet, at the horizon, or when it is no longer finite."""
        return self._fly(agent, scenario)

    def screen_batch(
        self, agents: Sequence[Agent], scenarios: Sequence[Scenario], matters: Callable[[int, Trajectory], bool]
    ) -> list[Trajectory]:
        """Return the flights of many agents; of one that does not matter, the first of those that are compared."""
        return [
            self._fly(agent, scenario, lambda flight, index=index: matters(index, flight))  # type: ignore[misc]
            for index, (agent, scenario) in enumerate(zip(agents, scenarios, strict=True))
        ]

    def _fly(self, agent: Agent, scenario: Scenario, matters: Callable[[Trajectory], bool] | None = None) -> Trajectory:
        from driftform.motion import forces, solver

        # Exudyn takes longer to import than most flights take.
        from driftform_exudyn.integration import integrate_motion, make_settings

        o, horizon = self.options, scenario.flight.horizon
        controlled = o.integrator == "DOPRI5"
        # Equal steps have no tolerance to tighten: the two flights have steps of twice the length, and of that.
        tightest = o.tightest if controlled else math.inf
        accuracy = solver.Accuracy(o.accuracy, o.tolerance, tightest, o.max_step, o.step_limit)
        first = accuracy.loosen_for_gusts().tolerance if scenario.has_gusts else accuracy.tolerance

        def fly(tolerance: float) -> FloatArray:
            ratio = tolerance / (solver.TOLERANCE_RATIO * first)
            max_step = o.max_step * (ratio ** (1 / STEP_ORDER) if controlled else 1 + (ratio > 0.5))
            settings = make_settings(o.integrator, horizon, tolerance, max_step)
            return integrate_motion(agent, scenario, settings, o.step_limit)

        return solver.fly_checked(fly, forces.flight_model(agent, scenario), scenario, accuracy, matters)
