"""An agent in the scenario of one film, flown again and again with other factors and releases by compiled kernels."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from driftform import Pipeline
from driftform.agent import hull_mass, mass_properties
from driftform.motion import forces, path, solver
from driftform.types import Agent, Body, Coefficients, FloatArray, Morphology
from driftform.util import rotations
from driftform.water import Calibration, Factors, Scenario

ACCURACY = solver.Accuracy(tolerance=1e-7, max_step=0.03, step_limit=20_000)
"""Of the flights of a fit: smooth enough for finite differences, far finer than any track."""


@dataclass(frozen=True)
class ReleaseError:
    """How a release differs from that of the scenario.

    Attributes:
        pitch, yaw: of the axis, rad.
        velocity: in the world frame, m/s.
        rise: of the position, m, up.
    """

    pitch: float = 0.0
    yaw: float = 0.0
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rise: float = 0.0


@dataclass(frozen=True, eq=False)
class Path:
    """A flight as a film sees it; before the first sample the agent is held, after the last it moves on straight.

    Attributes:
        t: times of the samples, s, (k,).
        position, velocity: of the core's centre, in the world frame, m and m/s, (k, 3).
        axis, axis_rate: unit vector along the agent's axis in the world frame, and its rate, 1/s, (k, 3).
        contact: time of the first contact with a wall, s; infinite without one.
    """

    t: FloatArray
    position: FloatArray
    velocity: FloatArray
    axis: FloatArray
    axis_rate: FloatArray
    contact: float

    def points_at(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the core's positions and the axis at ``times`` (s, (n,)), (n, 3) each."""
        within = np.clip(times, 0.0, self.t[-1])
        if len(self.t) == 1:
            return np.repeat(self.position, len(times), axis=0), np.repeat(self.axis, len(times), axis=0)
        position = path.evaluate_path(self.t, self.position, self.velocity, within)
        axis = path.evaluate_path(self.t, self.axis, self.axis_rate, within)
        late = np.maximum(times - self.t[-1], 0.0)[:, None]
        return position + late * self.velocity[-1], axis / np.linalg.norm(axis, axis=1, keepdims=True)


@dataclass(frozen=True, eq=False)
class Bench:
    """An agent without any calibration, and the scenario of one film."""

    body: Body
    coefficients: Coefficients
    scenario: Scenario

    @classmethod
    def of(cls, pipeline: Pipeline, morphology: Morphology) -> "Bench":
        """Return the bench of a morphology in the pipeline's scenario, whose own calibration is left out."""
        scenario = pipeline.scenario.model_copy(update={"calibration": Calibration()})
        agent = replace(pipeline, scenario=scenario).realise(morphology)
        return cls(agent.body, agent.coefficients, scenario)

    @cached_property
    def hull_weight(self) -> float:
        """Weight of the hull's material, N."""
        return hull_mass(self.body) * self.scenario.fluid.gravity

    @cached_property
    def net_weight(self) -> float:
        """Weight less buoyancy of the agent without its ballast, N, downward positive."""
        return -mass_properties(self.body).net_buoyancy(self.scenario.fluid)

    def agent(self, factors: Factors) -> Agent:
        """Return the agent with these factors, and with the ballast of the release."""
        body = factors.scale_body(self.body)
        mass = self.scenario.release.load(mass_properties(body))
        return Agent(body, mass, factors.scale_coefficients(self.coefficients))

    def fly(self, factors: Factors, error: ReleaseError, until: float) -> Path:
        """Return the flight with these factors and this release, up to the time ``until``, s."""
        calibration = Calibration().with_factors(factors)
        scenario = self.scenario.model_copy(update={"calibration": calibration})
        model = forces.flight_model(self.agent(factors), scenario)
        if error.pitch or error.yaw:
            release, (pitch, yaw) = scenario.release, np.rad2deg([error.pitch, error.yaw]).tolist()
            angles = {"pitch_deg": release.pitch_deg + pitch, "yaw_deg": release.yaw_deg + yaw}
            scenario = scenario.model_copy(update={"release": release.model_copy(update=angles)})
        start = forces.release_state(model, scenario)
        start[7:10] += error.velocity
        start[2] += error.rise
        samples = solver.integrate_once(model, start, max(until, 0.01), ACCURACY)
        samples = np.ascontiguousarray(samples[np.isfinite(samples).all(axis=1)])
        touched = path.finish_trajectory(samples, model, until, ACCURACY.step_limit).contact
        contact = np.inf if touched is None else touched
        turned = rotations.matrix_from_quaternion(samples[:, 4:8])
        axis, left, up = (np.ascontiguousarray(turned[..., k]) for k in range(3))
        rate = samples[:, 13:14] * left - samples[:, 12:13] * up
        return Path(samples[:, 0], samples[:, 1:4], samples[:, 8:11], axis, rate, contact)
