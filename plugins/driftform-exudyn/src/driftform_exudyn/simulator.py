"""Flights integrated by Exudyn, with driftform's own equations of motion as the right-hand side."""

import contextlib
import math
from typing import Any, Literal

import numpy as np

from driftform.dynamics.equations import fill_accelerations
from driftform.dynamics.flight import SAMPLE, finished_flight, first_contact, record, release_state
from driftform.dynamics.integrator import Accuracy, greatest_distance, integrate
from driftform.dynamics.model import flight_model, packed
from driftform.dynamics.rotations import rotation_vector_from_quaternion
from driftform.interfaces import Simulator
from driftform.options import Table, option
from driftform.scenario import Scenario
from driftform.types import Agent, End, FloatArray, Trajectory
from driftform_exudyn.headless import exudyn, items

PATIENCE = 5_000
"""Evaluations within one step after which it has failed.

Halving the longest step down to the shortest takes some 300. Where forces are absurd, Exudyn's error control can
go on for ever, trying longer and shorter steps in turn.
"""

TIGHTENING = 0.1
"""What the tolerance is multiplied by where a flight is not accurate enough."""


class ExudynOptions(Table):
    """Options of the Exudyn backend."""

    integrator: Literal["auto", "DOPRI5", "RK67", "RK44"] = option(
        "auto",
        "explicit integrator: DOPRI5 controls its error, RK67 and RK44 take equal steps; auto is DOPRI5, and RK67 "
        "for flights that touch no wall, as far as that is as accurate",
    )
    accuracy: float = option(
        1e-3, "largest estimated error of the position; the tolerance is tightened until it is met", "m", gt=0
    )
    tolerance: float = option(
        1e-6,
        "relative and absolute tolerance of a step in every coordinate, to begin with (DOPRI5)",
        "SI",
        gt=0,
    )
    tightest: float = option(1e-9, "tolerance below which a flight counts as not converged", "SI", gt=0)
    max_step: float = option(
        0.03,
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
    plus what that one's may be. The two share the equations and nothing else.
    """

    name = "exudyn"
    Options = ExudynOptions

    def simulate(self, agent: Agent, scenario: Scenario) -> Trajectory:
        """Return the flight; it ends at the outlet, the horizon, or where it is no longer finite."""
        options, horizon = self.options, scenario.flight.horizon
        model = flight_model(agent, scenario)
        values, start = packed(model), release_state(model, scenario)
        other = integrate(
            model, start, horizon, Accuracy(options.accuracy / 2, step_limit=options.step_limit)
        )
        tolerance = options.tolerance

        def flown(integrator: str) -> Trajectory:
            settings = self._settings(integrator, horizon, tolerance)
            samples = _integrated(values, start, settings, options.step_limit)
            error = other.error + greatest_distance(other.samples, samples)
            return finished_flight(samples, model, horizon, options.step_limit, error, options.accuracy)

        if options.integrator not in ("auto", "DOPRI5"):
            return flown(options.integrator)
        if options.integrator == "auto" and first_contact(other.samples, values) is None:
            flight = flown("RK67")
            if not flight.end.failed and _is_as_accurate(flight, tolerance, options.accuracy):
                return flight
        flight = flown("DOPRI5")
        while flight.end == End.NOT_CONVERGED and TIGHTENING * tolerance >= options.tightest:
            tolerance *= TIGHTENING
            flight = flown("DOPRI5")
        return flight

    def _settings(self, integrator: str, horizon: float, tolerance: float) -> Any:
        settings = exudyn.SimulationSettings()
        settings.solution.file.write = False
        integration = settings.timeIntegration
        integration.endTime = horizon
        integration.numberOfSteps = max(1, math.ceil(horizon / self.options.max_step))
        integration.verboseMode = 0
        integration.solverType = getattr(exudyn.DynamicSolverType, integrator)
        integration.absoluteTolerance = tolerance
        integration.relativeTolerance = tolerance
        integration.minimumStepSize = 1e-10
        integration.explicit.computeEndOfStepAccelerations = False
        return settings


def _is_as_accurate(flight: Trajectory, tolerance: float, accuracy: float) -> bool:
    """Whether equal steps did as well as steps of this tolerance would; energy tells, where something conserves it."""
    if flight.energy_drift is not None:
        return flight.energy_drift <= tolerance
    return flight.error is not None and flight.error <= 0.1 * accuracy


def _integrated(model: FloatArray, start: FloatArray, settings: Any, limit: int) -> FloatArray:
    """Return the raw samples of a flight, (k, 14): the release and the end of every step."""
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
