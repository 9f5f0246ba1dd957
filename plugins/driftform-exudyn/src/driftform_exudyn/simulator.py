"""Flights of Exudyn's rigid body, with driftform's forces of water and wall."""

import math
from collections.abc import Callable, Sequence
from typing import Literal

from driftform.interfaces import Simulator, Table, option
from driftform.types import Agent, FloatArray, Trajectory
from driftform.water import Scenario

STEP_ORDER = 5
"""Order of DOPRI5: its longest step falls with the tolerance as the step does that its error control chooses.

With equal longest steps, two flights would differ from the path between their samples alike, and not show it.
"""


class ExudynOptions(Table):
    """Options of the Exudyn backend."""

    integrator: Literal["DOPRI5", "RK67", "RK44"] = option(
        "DOPRI5", "explicit integrator: DOPRI5 controls its error, RK67 and RK44 take equal steps"
    )
    accuracy: float = option(
        1e-3,
        "largest estimated error of the position, in gusts ten times as much up to 10 mm; the tolerance is reduced until "
        "this is met, in gusts only as long as that helps",
        "m",
        ge=1e-12,
        le=1e6,
    )
    tolerance: float = option(
        1e-6,
        "initial tolerance of a step at the release in every coordinate, ten times as much in gusts; it grows along the "
        "flight (DOPRI5)",
        "SI",
        ge=1e-15,
        le=1e-2,
    )
    tightest: float = option(1e-12, "tolerance below which it is not reduced", "SI", ge=1e-15, le=1e-2)
    max_step: float = option(
        0.05,
        "longest time step and time between samples; RK67 and RK44 take all steps of this length",
        "s",
        ge=1e-5,
        le=10,
    )
    step_limit: int = option(200_000, "steps after which a flight counts as failed", "", gt=0, le=100_000_000)


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
