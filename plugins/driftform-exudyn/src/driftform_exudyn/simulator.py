"""Flights integrated by Exudyn, with driftform's own equations of motion as the right-hand side."""

import contextlib
import math
from typing import Any, Literal

import numpy as np

from driftform.interfaces import Simulator
from driftform.options import Table, option
from driftform.scenario import Scenario
from driftform.types import Agent, FloatArray, Trajectory

PATIENCE = 5_000
"""Evaluations within one step after which it has failed.

Halving the longest step down to the shortest takes some 300. Where forces are absurd, Exudyn's error control can
go on for ever, trying longer and shorter steps in turn.
"""

SAFETY = 0.75
"""Share of the step that its error control takes for the longest possible.

With Exudyn's own 0.9 every fourth step is rejected; the same error takes a fifth more evaluations then.
"""

TIGHTENING = 0.1
"""What the tolerance is multiplied by where a flight is not accurate enough."""

REFERENCE = 0.2
"""Share of the accuracy that the flight it is held against may be off, to begin with."""


class ExudynOptions(Table):
    """Options of the Exudyn backend."""

    integrator: Literal["DOPRI5", "RK67", "RK44"] = option(
        "DOPRI5", "explicit integrator: DOPRI5 controls its error, RK67 and RK44 take equal steps"
    )
    accuracy: float = option(
        1e-3, "largest estimated error of the position; the tolerance is tightened until it is met", "m", gt=0
    )
    tolerance: float = option(
        3e-6,
        "relative and absolute tolerance of a step in every coordinate, to begin with (DOPRI5)",
        "SI",
        gt=0,
    )
    tightest: float = option(1e-9, "tolerance below which a flight counts as not converged", "SI", gt=0)
    max_step: float = option(
        0.05,
        "longest time step and gap between samples; RK67 and RK44 take every step of this length",
        "s",
        gt=0,
    )
    step_limit: int = option(200_000, "steps after which a flight counts as failed", "", gt=0)


class ExudynSimulator(Simulator[ExudynOptions]):
    """A free rigid body on a Lie-group node, so that no attitude is singular.

    Exudyn sees a unit mass matrix, and the force function returns accelerations: the 6x6 mass with its added mass
    is inverted once, exactly, in the body frame, where it is constant. There is no lag and no mass matrix that
    depends on the pose.

    A flight's error is how far it is from one by another integrator, that of :mod:`driftform.dynamics.integrator`,
    plus what that one's may be. The two share no more than the equations.
    """

    name = "exudyn"
    Options = ExudynOptions

    def simulate(self, agent: Agent, scenario: Scenario) -> Trajectory:
        """Return the flight; it ends at the outlet, the horizon, or where it is no longer finite."""
        from driftform.dynamics.flight import finished_flight, release_state
        from driftform.dynamics.integrator import Accuracy, greatest_distance, integrate
        from driftform.dynamics.model import flight_model, packed

        options, horizon = self.options, scenario.flight.horizon
        model = flight_model(agent, scenario)
        values, start = packed(model), release_state(model, scenario)
        tolerance, share = options.tolerance, REFERENCE
        while True:
            known = Accuracy(share * options.accuracy, step_limit=options.step_limit)
            other = integrate(model, start, horizon, known)
            settings = self._settings(horizon, tolerance)
            samples = _integrated(values, start, settings, options.step_limit)
            error = other.error + greatest_distance(other.samples, samples)
            tolerance, share = TIGHTENING * tolerance, TIGHTENING * share
            equal_steps = options.integrator != "DOPRI5"
            if error <= options.accuracy or equal_steps or tolerance < options.tightest:
                return finished_flight(samples, model, horizon, options.step_limit, error, options.accuracy)

    def _settings(self, horizon: float, tolerance: float) -> Any:
        from driftform_exudyn.headless import exudyn

        settings = exudyn.SimulationSettings()
        settings.solution.file.write = False
        integration = settings.timeIntegration
        integration.endTime = horizon
        integration.numberOfSteps = max(1, math.ceil(horizon / self.options.max_step))
        integration.verboseMode = 0
        integration.solverType = getattr(exudyn.DynamicSolverType, self.options.integrator)
        integration.absoluteTolerance = tolerance
        integration.relativeTolerance = tolerance
        integration.minimumStepSize = 1e-10
        integration.stepSizeSafety = SAFETY
        integration.explicit.computeEndOfStepAccelerations = False
        return settings


def _integrated(model: FloatArray, start: FloatArray, settings: Any, limit: int) -> FloatArray:
    """Return the raw samples of a flight, (k, 14): the release and the end of every step."""
    from driftform.dynamics.equations import fill_accelerations
    from driftform.dynamics.flight import SAMPLE, record
    from driftform.dynamics.rotations import rotation_vector_from_quaternion
    from driftform_exudyn.headless import exudyn, items

    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    free_body: Any = items.NodeRigidBodyRotVecLG  # exudyn's items are partly typed, and not by what they take
    unit_mass: Any = items.ObjectGenericODE2
    node = mbs.AddNode(
        free_body(
            referenceCoordinates=[0.0] * 6,
            initialCoordinates=[*start[:3], *rotation_vector_from_quaternion(start[3:7])],
            initialVelocities=[*start[7:]],
        )
    )
    out = np.zeros(6)
    samples = np.empty((1024, SAMPLE))
    count = tries = 0

    def force(_: Any, t: float, *__: Any) -> FloatArray:
        nonlocal tries
        tries += 1
        fill_accelerations(t, pose, speed, model, out)
        if tries > PATIENCE:
            out.fill(np.nan)
        return out

    def after_step(_: Any, t: float) -> bool:
        nonlocal samples, count, tries
        tries = 0
        if count == len(samples):
            samples = np.concatenate([samples, np.empty_like(samples)])
        goes_on = record(samples[count], t, pose, speed, model)
        count += 1
        return goes_on and count <= limit

    mbs.AddObject(unit_mass(nodeNumbers=[node], massMatrix=np.eye(6), forceUserFunction=force))
    mbs.Assemble()
    # Live views of the memory that the last Assemble laid out.
    pose: Any = mbs.systemData.GetODE2Coordinates(copy=False)
    speed: Any = mbs.systemData.GetODE2Coordinates_t(copy=False)
    after_step(mbs, 0.0)
    mbs.SetPostStepUserFunction(after_step)
    # Exudyn raises where the error control cannot go on, and returns True after NaN: the samples tell.
    with contextlib.suppress(exudyn.SolverError):
        mbs.SolveDynamic(settings)
    return samples[:count]
