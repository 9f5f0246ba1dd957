"""Flights integrated by Exudyn, with driftform's equations of motion as the right-hand side."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from driftform.interfaces import Simulator, Table, option
from driftform.types import Agent, FloatArray, Trajectory
from driftform.water import Scenario

GUST_TIGHTENING = 1e-2
"""Least tolerance in gusts, relative to the initial one: a flight that needs less is chaotic."""

TIGHTENING = 0.1
"""Factor on the tolerance after a flight that is not accurate enough."""

REFERENCE_SHARE = 0.4
"""Initial accuracy of the reference flight, relative to the accuracy asked for."""


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
    tightest: float = option(
        1e-11, "tolerance below which a flight counts as not converged", "SI", ge=1e-15, le=1e-2
    )
    max_step: float = option(
        0.05,
        "longest time step and time between samples; RK67 and RK44 take all steps of this length",
        "s",
        ge=1e-5,
        le=10,
    )
    step_limit: int = option(200_000, "steps after which a flight counts as failed", "", gt=0, le=100_000_000)


class ExudynSimulator(Simulator[ExudynOptions]):
    """Flights by Exudyn's explicit solvers.

    Exudyn integrates unit masses whose forces are accelerations: the 6x6 mass matrix with its added mass is inverted
    once, exactly, in the body frame, where it is constant. The added mass therefore does not lag, and the mass matrix
    does not depend on the pose. The mass is a rigid body on a Lie-group node, for which no attitude is singular.

    The error of a flight is its distance from a flight by another integrator,
    :mod:`driftform.motion.integrator`, plus the error of that flight. The two share only the equations. In a search the
    other integrator, which is several times faster, also flies first, twice if that is not clear enough: Exudyn flies what
    matters to the search.
    """

    name = "exudyn"
    Options = ExudynOptions

    def simulate(self, agent: Agent, scenario: Scenario) -> Trajectory:
        """Return the flight; it ends at the outlet, at the horizon, or when it is no longer finite."""
        return self._fly(agent, scenario)

    def screen_batch(
        self,
        agents: Sequence[Agent],
        scenarios: Sequence[Scenario],
        matters: Callable[[int, Trajectory], bool],
    ) -> list[Trajectory]:
        """Return the flights of many agents; of one that does not matter, the reference, or the coarsest that it is made of."""
        return [
            self._fly(agent, scenario, lambda flight, index=index: matters(index, flight))  # type: ignore[misc]
            for index, (agent, scenario) in enumerate(zip(agents, scenarios, strict=True))
        ]

    def _fly(
        self, agent: Agent, scenario: Scenario, matters: Callable[[Trajectory], bool] | None = None
    ) -> Trajectory:
        from driftform.motion import Motion, integrator, stepping

        options, horizon = self.options, scenario.flight.horizon
        model = stepping.flight_model(agent, scenario)
        start = stepping.release_state(model, scenario)
        accuracy = integrator.Accuracy(REFERENCE_SHARE * options.accuracy, step_limit=options.step_limit)
        first: FloatArray | None = None
        if matters is not None:
            first = integrator.integrate_once(model, start, horizon, accuracy)
            screened = stepping.finish_trajectory(first, model, horizon, options.step_limit)
            if not matters(screened):
                return screened
        reference = integrator.integrate(model, start, horizon, accuracy, first)
        if matters is not None:
            screened = stepping.finish_trajectory(
                reference.samples, model, horizon, options.step_limit, reference.error, options.accuracy
            )
            if not matters(screened):
                return replace(screened, error=None)
        # Exudyn takes longer to import than most flights take.
        from driftform_exudyn.integration import integrate_motion, make_settings

        motion = Motion.of(model, start)
        tolerance = options.tolerance
        while True:
            settings = make_settings(options.integrator, horizon, tolerance, options.max_step)
            samples = integrate_motion(motion, settings, options.step_limit)
            error = reference.error + integrator.greatest_distance(reference.samples, samples)
            tolerance *= TIGHTENING
            flown = (reference.samples, samples)
            hopeless = all(len(s) > options.step_limit or not np.isfinite(s[-1]).all() for s in flown)
            # A path in gusts that no tolerance fixes is one of many that the same gusts allow, as likely as any other.
            accepted = (
                math.inf
                if scenario.has_gusts and tolerance < GUST_TIGHTENING * options.tolerance
                else options.accuracy
            )
            last = options.integrator != "DOPRI5" or tolerance < options.tightest or hopeless
            if error <= accepted or last:
                return stepping.finish_trajectory(
                    samples, model, horizon, options.step_limit, error, accepted, reference.samples
                )
            accuracy = replace(accuracy, position=TIGHTENING * accuracy.position)
            reference = integrator.integrate(model, start, horizon, accuracy, first)
