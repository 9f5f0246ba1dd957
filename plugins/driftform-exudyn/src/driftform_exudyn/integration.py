"""Motions integrated by Exudyn, which calls driftform's equations for the accelerations.

It is that of a unit mass on a rigid body's node, with a force function.
"""

import contextlib
import math
from typing import Any

import numpy as np

from driftform.motion import Motion, integrator
from driftform.types import FloatArray
from driftform_exudyn.headless import exudyn
from driftform_exudyn.headless import items as typed_items

items: Any = typed_items  # the type hints of exudyn's items do not match their arguments

SAMPLE = 14
"""Numbers of a raw sample."""

MAX_TRIES = 5_000
"""Evaluations within one step after which the flight fails.

Halving the longest step down to the shortest takes some 300 evaluations. If forces are unphysically large, Exudyn's
error control can loop for ever, alternating between longer and shorter steps.
"""

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


def integrate_motion(motion: Motion, settings: Any, limit: int) -> FloatArray:
    """Return the raw samples of a flight, (k, 14): the release and the ends of at most ``limit`` steps.

    The tolerance grows along the flight, as in :mod:`driftform.motion.integrator`.
    """
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    values, b, states = motion.values, motion.bristles, len(motion.inner)
    integration = settings.timeIntegration
    tolerance = integration.absoluteTolerance
    nowhere = (np.nan,) * 6
    samples = np.empty((1024, SAMPLE))
    count, tries, due = 0, 0, 0.0
    known: tuple[float, ...] | None = None

    def inner_rates(_: Any, t: float, *__: Any) -> FloatArray:
        nonlocal known
        values[motion.inner] = inner
        known = motion.accelerations(t, coordinates, rates, values)
        return values[motion.inner_rates]

    def force(_: Any, t: float, *__: Any) -> tuple[float, ...]:
        nonlocal tries, known
        tries += 1
        if tries > MAX_TRIES:
            return nowhere
        if known is None:
            return motion.accelerations(t, coordinates, rates, values)
        # Exudyn asks for the rates of the inner states first, and they are computed together.
        found, known = known, None
        return found

    def after_step(_: Any, t: float) -> bool:
        nonlocal samples, count, tries, due
        tries = 0
        if t >= due:
            # Exudyn reads this at every step.
            integration.absoluteTolerance = integrator.grow_tolerance(tolerance, t)
            due = t + TOLERANCE_PERIOD
        if b and motion.touches is not None and not motion.touches(coordinates, values):
            inner[:b] = 0.0
        if count == len(samples):
            samples = np.concatenate([samples, np.empty_like(samples)])
        proceeds = motion.fill_sample(samples[count], t, coordinates, rates, values)
        count += 1
        return proceeds and count <= limit

    _add_mass(mbs, motion, force)
    if states:
        zeros = [0.0] * states
        node = mbs.AddNode(
            items.NodeGenericODE1(
                referenceCoordinates=zeros, initialCoordinates=zeros, numberOfODE1Coordinates=states
            )
        )
        mbs.AddObject(items.ObjectGenericODE1(nodeNumbers=[node], rhsUserFunction=inner_rates))
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


def _add_mass(mbs: Any, motion: Motion, force: Any) -> None:
    node = mbs.AddNode(
        items.NodeRigidBodyRotVecLG(
            referenceCoordinates=[0.0] * 6,
            initialCoordinates=motion.coordinates.tolist(),
            initialVelocities=motion.rates.tolist(),
        )
    )
    mbs.AddObject(items.ObjectGenericODE2(nodeNumbers=[node], massMatrix=np.eye(6), forceUserFunction=force))
