"""The tables of a scenario: pipe, flow, fluid, release, contact, targets. Validated here, read by kernels as arrays."""

from typing import Annotated, Literal

import numpy as np
from pydantic import AfterValidator, Field, model_validator

from driftform.options import Table, option
from driftform.scenario.flow import Flow, LogLawFlow, PipeFlow, TurbulentFlow, UniformFlow
from driftform.scenario.pipe import Pipe, Vector
from driftform.types import FloatArray


class Fluid(Table):
    """The water."""

    density: float = option(1024.0, "density of the water", "kg/m3", gt=0)
    gravity: float = option(9.81, "acceleration of gravity, along -z", "m/s2", ge=0)
    viscosity: float = option(
        1.05e-6, "kinematic viscosity; by default that of seawater at 20 degrees C", "m2/s", gt=0
    )
    water_level: float | None = option(
        None, "height of the free surface in the world frame; by default the pipe is full", "m", strict=True
    )
    flow_force: Literal["full", "paper"] = option(
        "full",
        "force of accelerating water: full with its pressure gradient (Froude-Krylov), or paper without it",
    )


class Release(Table):
    """How the agent enters the water."""

    position: Vector = option(
        (0.0, 0.0, 0.0), "position of the core's centre at the release, in the world frame", "m"
    )
    pitch_deg: float = option(
        0.0, "pitch of the body's axis relative to x, positive nose down", "deg", ge=-90, le=90
    )
    yaw_deg: float = option(
        0.0, "yaw of the body's axis relative to x, positive towards +y", "deg", ge=-180, le=180
    )
    velocity: Literal["current", "rest"] | Vector = option(
        "current", "'current' (moving with the water), 'rest', or a velocity in the world frame", "m/s"
    )


class Contact(Table):
    """Contact with the pipe's wall: stiff springs, dampers set by the restitution, and Coulomb friction.

    The stiffness of a spring is such that the mass that moves with it, added mass included, oscillates on it at
    ``frequency``. A collision returns the share ``restitution`` exp(-35 / St) of the speed along the wall's normal, with
    the Stokes number St of the impact.
    """

    frequency: float = option(
        300.0, "angular frequency of the body on the spring of one contact", "rad/s", ge=50, le=1e4
    )
    restitution: float = option(0.25, "coefficient of restitution in air", "", ge=0.1, le=1)
    friction: float = option(0.0, "coefficient of Coulomb friction", "", ge=0, le=10)


class FlightLimits(Table):
    """Limits of a flight that does not reach the outlet."""

    horizon: float = option(20.0, "longest duration of a flight", "s", gt=0)


class Robustness(Table):
    """Disturbances of the flights of the finalists, and the score that they give.

    The quantities are standard deviations of normal distributions, truncated at three standard deviations.
    """

    conditions: int = option(
        0, "disturbed flights of each finalist; 0 to rank by the undisturbed flight alone", ge=0, le=10_000
    )
    finalists: int = option(
        5, "finalists for each target: the agents with the best undisturbed flights", gt=0
    )
    score: Literal["mean", "quantile", "worst"] = option(
        "mean", "score of a finalist, from its fitness over all conditions"
    )
    quantile: float = option(
        0.1, "share of the conditions with a fitness below the score, if score = 'quantile'", ge=0, le=1
    )
    position: float = option(
        0.02, "of the release position, along each of two directions across the pipe", "m", ge=0
    )
    angle_deg: float = option(2.0, "of pitch and yaw at the release", "deg", ge=0, le=30)
    current: float = option(0.03, "of the speed of the current, relative to it", ge=0, le=0.3)
    density: float = option(0.001, "of the density of the water, relative to it", ge=0, le=0.3)
    mass: float = option(0.01, "of the mass of the printed hull, relative to it", ge=0, le=0.3)
    wall: float = option(0.00002, "of the thickness of the printed wall", "m", ge=0)


def _check_names(targets: dict[str, Vector]) -> dict[str, Vector]:
    for name in targets:
        if not name.replace("-", "").replace("_", "").isalnum():
            raise ValueError(
                f"target name '{name}' must consist of letters, digits, '-' and '_': it names a folder"
            )
    return targets


class Scenario(Table):
    """The whole environment; the same tables as in a study file."""

    pipe: Pipe = Field(default=Pipe(), description="the pipe")
    flow: Flow = Field(default=UniformFlow(), description="the current")
    fluid: Fluid = Field(default=Fluid(), description="the water")
    release: Release = Field(default=Release(), description="how the agent enters the water")
    contact: Contact = Field(default=Contact(), description="contact with the wall")
    flight: FlightLimits = Field(default=FlightLimits(), description="limits of a flight")
    robustness: Robustness = Field(
        default=Robustness(), description="disturbances of the finalists' flights, and their score"
    )
    targets: Annotated[dict[str, Vector], AfterValidator(_check_names)] = Field(
        default={},
        description="points to reach: name and position in the world frame",
        json_schema_extra={"unit": "m"},
    )

    @model_validator(mode="after")
    def _check_together(self) -> "Scenario":
        if self.targets and not self.pipe.segments:
            raise ValueError("targets need a pipe: fitness is relative to the farthest point of its volume")
        if isinstance(self.flow, PipeFlow) and not self.pipe.segments:
            raise ValueError(
                f"flow.kind = '{self.flow.kind}' needs a pipe; in open water it must be 'uniform'"
            )
        if isinstance(self.flow, LogLawFlow | TurbulentFlow):
            most = 0.1 * min(segment.radius for segment in self.pipe.segments)
            if self.flow.roughness > most:
                raise ValueError(
                    f"flow.roughness = {self.flow.roughness} is too large for the logarithmic law in this pipe: "
                    f"it is valid up to a twentieth of the diameter, {most:g} m"
                )
        for name, point in (
            ("release.position", self.release.position),
            *((f"targets.{name}", point) for name, point in self.targets.items()),
        ):
            if self.pipe.segments and not self.pipe.contains(point):
                raise ValueError(f"{name} = {list(point)} lies outside the pipe")
        return self

    @property
    def target_names(self) -> tuple[str, ...]:
        """Names of the targets, in the order of every fitness vector."""
        return tuple(self.targets)

    def target_array(self) -> FloatArray:
        """Return the positions of the targets in the world frame, m, (targets, 3)."""
        return np.array(list(self.targets.values()), dtype=np.float64).reshape(-1, 3)

    def direction(self) -> FloatArray:
        """Return the unit vector downstream at the inlet, in the world frame, (3,); along x in open water."""
        if not self.pipe.segments:
            return np.array([1.0, 0.0, 0.0])
        first = self.pipe.segments[0]
        axis = np.subtract(first.end, first.start)
        return np.asarray(axis / np.linalg.norm(axis), dtype=np.float64)

    def current(self) -> FloatArray:
        """Return the mean velocity of the water at the inlet, in the world frame, m/s, (3,)."""
        return self.flow.speed * self.direction()

    def of_evaluation(self, seed: int, index: int) -> "Scenario":
        """Return the scenario of evaluation ``index`` of a run with this seed, with the gusts of that evaluation."""
        return self.with_gusts(evaluation_seed(seed, index))

    def with_gusts(self, seed: int | None) -> "Scenario":
        """Return the scenario with the gusts of ``seed``; unchanged if ``seed`` is ``None`` or the flow has no gusts."""
        if seed is None or not isinstance(self.flow, TurbulentFlow):
            return self
        return self.model_copy(update={"flow": self.flow.model_copy(update={"seed": seed})})

    def release_quaternion(self) -> FloatArray:
        """Return the attitude at the release, (4,): rotation about y by the pitch, then about z by the yaw."""
        pitch, yaw = np.deg2rad([self.release.pitch_deg, self.release.yaw_deg]) / 2
        c, s = np.cos(pitch), np.sin(pitch)
        return np.array([np.cos(yaw) * c, -np.sin(yaw) * s, np.cos(yaw) * s, np.sin(yaw) * c])


def evaluation_seed(seed: int, index: int) -> int:
    """Return the seed of the gusts of evaluation ``index`` of a run with this seed."""
    return int(np.random.SeedSequence((seed, index)).generate_state(1)[0])
