"""Flights integrated by Exudyn, with driftform's own equations of motion as the right-hand side."""

import os

# Read when exudyn is imported: no window, and no settings from the user's home that would change results.
os.environ.setdefault("EXUDYN_SUPPRESS_UI_WINDOW_OPEN", "1")
os.environ.setdefault("EXUDYN_NO_USER_SETTINGS", "1")

import contextlib
import io
from typing import Any, Literal

import numpy as np

with contextlib.redirect_stdout(io.StringIO()):
    import exudyn
    from exudyn.itemInterface import NodeRigidBodyRotVecLG, ObjectGenericODE2

from driftform.dynamics.equations import accelerations
from driftform.dynamics.flight import SAMPLE, finished_flight, record
from driftform.dynamics.model import FlightModel, flight_model
from driftform.dynamics.rotations import rotation_vector_from_quaternion
from driftform.interfaces import Simulator
from driftform.options import Table, option
from driftform.scenario import Scenario
from driftform.types import Agent, FloatArray, Trajectory

exudyn.config.printToConsole = False

PATIENCE = 5_000
"""Evaluations within one step after which it has failed.

Halving the longest step down to the shortest takes some 300. Where forces are absurd, Exudyn's error control can
go on for ever, trying longer and shorter steps in turn.
"""


class ExudynOptions(Table):
    """Options of the Exudyn backend."""

    integrator: Literal["DOPRI5", "RK67", "RK44"] = option(
        "DOPRI5", "explicit integrator; DOPRI5 controls its error, RK67 and RK44 do not"
    )
    tolerance: float = option(
        1e-6, "relative and absolute tolerance of a step in every coordinate (DOPRI5)", "SI", gt=0
    )
    max_step: float = option(
        0.02,
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
    """

    name = "exudyn"
    Options = ExudynOptions

    def simulate(self, agent: Agent, scenario: Scenario) -> Trajectory:
        """Return the flight; it ends at the outlet, the horizon, or where it is no longer finite."""
        model = flight_model(agent, scenario)
        horizon, limit = scenario.flight.horizon, self.options.step_limit
        samples = _integrated(model, scenario, self._settings(horizon), limit)
        return finished_flight(samples, model.pipe, horizon, limit)

    def _settings(self, horizon: float) -> Any:
        settings = exudyn.SimulationSettings()
        settings.solution.file.write = False
        integration = settings.timeIntegration
        integration.endTime = horizon
        integration.numberOfSteps = max(1, round(horizon / self.options.max_step))
        integration.verboseMode = 0
        integration.solverType = getattr(exudyn.DynamicSolverType, self.options.integrator)
        integration.absoluteTolerance = self.options.tolerance
        integration.relativeTolerance = self.options.tolerance
        integration.minimumStepSize = 1e-10
        integration.explicit.computeEndOfStepAccelerations = False
        return settings


def _integrated(model: FlightModel, scenario: Scenario, settings: Any, limit: int) -> FloatArray:
    """Return the raw samples of a flight, (k, 13): the release and the end of every step."""
    container = exudyn.SystemContainer()
    mbs = container.AddSystem()
    attitude = rotation_vector_from_quaternion(scenario.release_quaternion())
    free_body: Any = NodeRigidBodyRotVecLG  # exudyn's items are partly typed, and not by what they take
    unit_mass: Any = ObjectGenericODE2
    node = mbs.AddNode(
        free_body(
            referenceCoordinates=[0.0] * 6,
            initialCoordinates=[*scenario.release.position, *attitude],
            initialVelocities=[*scenario.release_velocity(), 0.0, 0.0, 0.0],
        )
    )
    table, rims, pipe = model.table, model.rims, model.pipe
    out = np.zeros(6)
    samples = np.empty((1024, SAMPLE))
    count = tries = 0

    def force(*_: Any) -> FloatArray:
        nonlocal tries
        tries += 1
        accelerations(pose, speed, table, rims, pipe, out)
        if tries > PATIENCE:
            out.fill(np.nan)
        return out

    def after_step(_: Any, t: float) -> bool:
        nonlocal samples, count, tries
        tries = 0
        if count == len(samples):
            samples = np.concatenate([samples, np.empty_like(samples)])
        goes_on = record(samples[count], t, pose, speed, pipe)
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
