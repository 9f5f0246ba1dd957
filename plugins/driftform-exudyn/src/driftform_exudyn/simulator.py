"""Flights of Exudyn's rigid body, with driftform's forces of water and wall."""

import math
from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np

from driftform.interfaces import Simulator, Table, option
from driftform.types import Agent, FloatArray, Trajectory
from driftform.water import Scenario

GUST_TIGHTENING = 1e-2
"""Least tolerance in gusts, relative to the initial one: a flight that needs less is chaotic."""

RATIO = 10.0
"""Ratio of the tolerances of the two flights that are compared; RK67 and RK44 take twice the step in the first."""

SAFETY_FACTOR = 2.0
"""Estimated error of a flight over its distance from the one with a larger tolerance."""

STEP_RATIO = RATIO**0.2
"""Ratio of the steps of DOPRI5 for that of the tolerances; also of the longest ones.

With equal steps, two flights would differ from the path between their samples alike, and not show it.
"""


class ExudynOptions(Table):
    """Options of the Exudyn backend."""

    integrator: Literal["DOPRI5", "RK67", "RK44"] = option(
        "DOPRI5", "explicit integrator: DOPRI5 controls its error, RK67 and RK44 take equal steps"
    )
    accuracy: float = option(
        1e-3,
        "largest estimated error of the position; the tolerance is reduced until this is met",
        "m",
        ge=1e-12,
        le=1e6,
    )
    tolerance: float = option(
        1e-6,
        "initial tolerance of a step at the release in every coordinate; it grows along the flight (DOPRI5)",
        "SI",
        ge=1e-15,
        le=1e-2,
    )
    tightest: float = option(1e-11, "tolerance below which a flight counts as not converged", "SI", ge=1e-15, le=1e-2)
    max_step: float = option(
        0.05,
        "longest time step and time between samples; RK67 and RK44 take all steps of this length",
        "s",
        ge=1e-5,
        le=10,
    )
    step_limit: int = option(200_000, "steps after which a flight counts as failed", "", gt=0, le=100_000_000)


class ExudynSimulator(Simulator[ExudynOptions]):
    """Flights by Exudyn's explicit solvers, of the system that :func:`driftform_exudyn.exudyn_system` returns.

    Exudyn knows a rigid body with its mass, its added mass and its loads, and asks driftform for the forces of water and wall.
    The error of a flight is twice its distance from a flight with ten times the tolerance. Nothing of driftform's integrator
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
        from driftform.motion import integrator, stepping

        # Exudyn takes longer to import than most flights take.
        from driftform_exudyn.integration import integrate_motion, make_settings

        o, horizon, model = self.options, scenario.flight.horizon, stepping.flight_model(agent, scenario)
        controlled = o.integrator == "DOPRI5"

        def integrate(tolerance: float, max_step: float) -> FloatArray:
            settings = make_settings(o.integrator, horizon, tolerance, max_step)
            return integrate_motion(agent, scenario, settings, o.step_limit)

        tolerance, max_step, least = o.tolerance, o.max_step, 0.0
        coarse = integrate(RATIO * tolerance, max_step if controlled else 2 * max_step)
        if matters is not None:
            screened = stepping.finish_trajectory(coarse, model, horizon, o.step_limit)
            if not matters(screened):
                return screened
        while True:
            max_step /= STEP_RATIO if controlled else 1.0
            fine = integrate(tolerance, max_step)
            distance = integrator.greatest_distance(coarse, fine, not scenario.has_gusts)
            # A distance that falls faster than the tolerance does so by chance.
            error, least = SAFETY_FACTOR * max(distance, least), distance / RATIO
            tolerance /= RATIO
            hopeless = all(len(s) > o.step_limit or not np.isfinite(s[-1]).all() for s in (coarse, fine))
            # A path in gusts that no tolerance fixes is one of many that the same gusts allow, as likely as any other.
            is_chaotic = scenario.has_gusts and tolerance < GUST_TIGHTENING * o.tolerance
            accepted = math.inf if is_chaotic else o.accuracy
            if error <= accepted or not controlled or tolerance < o.tightest or hopeless:
                return stepping.finish_trajectory(fine, model, horizon, o.step_limit, error, accepted, coarse)
            coarse = fine
