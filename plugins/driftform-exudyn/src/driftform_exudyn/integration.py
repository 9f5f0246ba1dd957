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

    The tolerance grows along the flight, as in :mod:`driftform.motion.solver.control`. Where a step of DOPRI5 passed over a
    touch of the wall, the flight goes back to the beginning of that step, and takes one that ends at the touch.
    """
    system = exudyn_system(agent, scenario)
    mbs, water, integration = system.mbs, system.water, settings.timeIntegration
    tolerance, horizon = integration.absoluteTolerance, integration.endTime
    longest = horizon / integration.numberOfSteps
    samples, count, due = np.empty((1024, SAMPLE)), 0, 0.0
    # The last step's end: the numbers of the flight and their rates, and Exudyn's coordinates.
    size = SAMPLE + len(water.inner_rates)
    last, ends, kept = np.empty((2, size)), np.empty((2, size)), [np.empty(0)] * 3
    touch: tuple[float, float] | None = None
    finds_touches = integration.solverType == exudyn.DynamicSolverType.DOPRI5

    def after_step(_: Any, t: float) -> bool:
        nonlocal samples, count, due, touch
        system.tries[0] = 0
        if t >= due:
            # Exudyn reads this at every step.
            integration.absoluteTolerance = solver.grow_tolerance(tolerance, t)
            due = t + TOLERANCE_PERIOD
        water.straighten(coordinates, inner)
        if count == len(samples):
            samples = np.concatenate([samples, np.empty_like(samples)])
        proceeds = water.fill_sample(samples[count], t, coordinates, rates)
        if finds_touches and proceeds:
            water.fill_numbers(t, samples[count], inner, ends[0], ends[1])
            if count > 0:
                share, stay = solver.find_touch(
                    t - samples[count - 1, 0], last[0], last[1], ends[0], ends[1], water.model
                )
                if share < 1.0:
                    touch = share * (t - samples[count - 1, 0]), stay
                    return False
            last[:] = ends
            kept[:] = coordinates.copy(), rates.copy(), inner.copy()
        count += 1
        return proceeds and count <= limit

    def solve(begin: float, end: float, first: float) -> None:
        integration.startTime, integration.endTime, integration.initialStepSize = begin, end, first
        integration.numberOfSteps = max(1, math.ceil((end - begin) / longest - 1e-9))
        # Exudyn raises an error if the error control fails, and returns True after NaN: the samples show both.
        with contextlib.suppress(exudyn.SolverError):
            try:
                mbs.SolveDynamic(settings)
            except exudyn.ModelError as error:
                # An interrupt is raised in the running Python code, usually a function that Exudyn calls.
                raise error.__cause__ or error from None

    def go_back() -> None:
        initial = exudyn.ConfigurationType.Initial
        mbs.systemData.SetODE2Coordinates(kept[0], initial)
        mbs.systemData.SetODE2Coordinates_t(kept[1], initial)
        mbs.systemData.SetODE1Coordinates(kept[2], initial)

    mbs.Assemble()
    # Live views of the memory that the last Assemble laid out.
    coordinates: Any = mbs.systemData.GetODE2Coordinates(copy=False)
    rates: Any = mbs.systemData.GetODE2Coordinates_t(copy=False)
    inner: Any = mbs.systemData.GetODE1Coordinates(copy=False)
    after_step(mbs, 0.0)
    mbs.SetPostStepUserFunction(after_step)
    try:
        solve(0.0, horizon, 0.0)
        while touch is not None:
            (ahead, stay), touch = touch, None
            begin = samples[count - 1, 0]
            go_back()
            solve(begin, begin + ahead, ahead)
            if touch is None and samples[count - 1, 0] > begin:
                go_back()
                solve(samples[count - 1, 0], horizon, min(longest, solver.TOUCH_SHARE * stay))
    finally:
        integration.absoluteTolerance, integration.startTime, integration.endTime = tolerance, 0.0, horizon
        integration.initialStepSize, integration.numberOfSteps = 0.0, round(horizon / longest)
    return samples[:count]
