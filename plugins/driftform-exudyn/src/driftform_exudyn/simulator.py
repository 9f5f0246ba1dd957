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
        mbs, pose, speed, tries = _system(model, scenario)
        limit = self.options.step_limit
        samples = np.empty((1024, SAMPLE))
        record(samples[0], 0.0, pose, speed, model.pipe)
        count = 1

        def after_step(_: Any, t: float) -> bool:
            nonlocal samples, count
            if count == len(samples):
                samples = np.concatenate([samples, np.empty_like(samples)])
            tries[0] = 0
            goes_on = record(samples[count], t, pose, speed, model.pipe)
            count += 1
            return goes_on and count <= limit

        mbs.SetPostStepUserFunction(after_step)
        # Exudyn raises where the error control cannot go on, and returns True after NaN: the samples tell.
        with contextlib.suppress(exudyn.SolverError):
            mbs.SolveDynamic(self._settings(scenario.flight.horizon))
        return finished_flight(samples[:count], model.pipe, scenario.flight.horizon, limit)

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


def _system(model: FlightModel, scenario: Scenario) -> tuple[Any, FloatArray, FloatArray, list[int]]:
    """Return the system, live views of its pose and speed, (6,) each, and the count of a step's evaluations."""
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
    views: list[Any] = []
    out = np.zeros(6)
    tries = [0]
    table, rims, pipe = model.table, model.rims, model.pipe

    def force(*_: Any) -> FloatArray:
        accelerations(views[0], views[1], table, rims, pipe, out)
        tries[0] += 1
        if tries[0] > PATIENCE:
            out.fill(np.nan)
        return out

    mbs.AddObject(unit_mass(nodeNumbers=[node], massMatrix=np.eye(6), forceUserFunction=force))
    mbs.Assemble()
    # The views are of the memory that the last Assemble laid out.
    views.append(mbs.systemData.GetODE2Coordinates(copy=False))
    views.append(mbs.systemData.GetODE2Coordinates_t(copy=False))
    return mbs, views[0], views[1], tries
