"""Motions integrated by Exudyn, of the system that :mod:`driftform_exudyn.system` makes."""

import contextlib
import math
from typing import Any

import numpy as np

from driftform.motion import solver
from driftform.types import Agent, FloatArray
from driftform.water import Scenario
from driftform_exudyn.headless import exudyn
from driftform_exudyn.system import exudyn_system

SAMPLE = 14
"""Numbers of a raw sample."""

STEP_SAFETY = 0.75
"""Step size relative to the largest that the error control estimates to be possible.

With Exudyn's default of 0.9 every fourth step is rejected, and the same error takes a fifth more evaluations.
"""

TOLERANCE_PERIOD = 0.1
"""Time between two changes of the tolerance, s: each takes as long as two evaluations."""


def make_settings(integrator: str, horizon: float, tolerance: float, max_step: float) -> Any:
    """Return Exudyn's settings for a flight of at most ``horizon`` s.

    ``tolerance`` is that of a step of DOPRI5 at the release, in every coordinate. RK67 and RK44 take equal steps of at
    most ``max_step`` s; steps of DOPRI5 are not longer either.
    """
    settings = exudyn.SimulationSettings()
    settings.solution.file.write = False
    integration = settings.timeIntegration
    integration.endTime = horizon
    integration.numberOfSteps = max(1, math.ceil(horizon / max_step))
    integration.verboseMode = 0
    integration.solverType = getattr(exudyn.DynamicSolverType, integrator)
    integration.absoluteTolerance = tolerance
    # Exudyn adds the relative tolerance times the number, not its size: a number near -1 would leave none.
    integration.relativeTolerance = 0.0
    integration.minimumStepSize = 1e-10
    integration.stepSizeSafety = STEP_SAFETY
    integration.explicit.computeEndOfStepAccelerations = False
    return settings


def integrate_motion(agent: Agent, scenario: Scenario, settings: Any, limit: int) -> FloatArray:
    """Return the raw samples of a flight, (k, 14): the release and the ends of at most ``limit`` steps.

    The tolerance grows along the flight, as in :mod:`driftform.motion.solver.error`.
    """
    system = exudyn_system(agent, scenario)
    mbs, water = system.mbs, system.water
    integration = settings.timeIntegration
    tolerance = integration.absoluteTolerance
    samples, count, due = np.empty((1024, SAMPLE)), 0, 0.0

    def after_step(_: Any, t: float) -> bool:
        nonlocal samples, count, due
        system.tries[0] = 0
        if t >= due:
            # Exudyn reads this at every step.
            integration.absoluteTolerance = solver.grow_tolerance(tolerance, t)
            due = t + TOLERANCE_PERIOD
        water.straighten(coordinates, inner)
        if count == len(samples):
            samples = np.concatenate([samples, np.empty_like(samples)])
        proceeds = water.fill_sample(samples[count], t, coordinates, rates)
        count += 1
        return proceeds and count <= limit

    mbs.Assemble()
    # Live views of the memory that the last Assemble laid out.
    coordinates: Any = mbs.systemData.GetODE2Coordinates(copy=False)
    rates: Any = mbs.systemData.GetODE2Coordinates_t(copy=False)
    inner: Any = mbs.systemData.GetODE1Coordinates(copy=False)
    after_step(mbs, 0.0)
    mbs.SetPostStepUserFunction(after_step)
    # Exudyn raises an error if the error control fails, and returns True after NaN: the samples show both.
    with contextlib.suppress(exudyn.SolverError):
        try:
            mbs.SolveDynamic(settings)
        except exudyn.ModelError as error:
            # An interrupt is raised in the running Python code, usually a function that Exudyn calls.
            raise error.__cause__ or error from None
        finally:
            integration.absoluteTolerance = tolerance
    return samples[:count]
