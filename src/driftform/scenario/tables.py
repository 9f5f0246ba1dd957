"""The environment, as data: pipe, flow, fluid, release, targets. Validated here, read by compiled kernels as arrays."""

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
    viscosity: float = option(1.05e-6, "kinematic viscosity; seawater of 20 degrees C", "m2/s", gt=0)
    water_level: float | None = option(
        None, "height of the free surface in the world frame; none where the pipe is full", "m", strict=True
    )
    flow_force: Literal["full", "paper"] = option(
        "full",
        "force of water that accelerates: with its pressure gradient (Froude-Krylov), or as in the paper without",
    )


class Release(Table):
    """How the agent enters the water."""

    position: Vector = option((0.0, 0.0, 0.0), "where the core's centre is released, in the world frame", "m")
    pitch_deg: float = option(
        0.0, "pitch of the body's axis against x, positive nose down", "deg", ge=-90, le=90
    )
    yaw_deg: float = option(
        0.0, "yaw of the body's axis against x, positive towards +y", "deg", ge=-180, le=180
    )
    velocity: Literal["current", "rest"] | Vector = option(
        "current", "'current' (moving with the water), 'rest', or a velocity in the world frame", "m/s"
    )


class Contact(Table):
    """Contact with the pipe's wall: an inelastic penalty, with Coulomb friction where that is not zero.

    The spring of a rim is so stiff that the body's mass, with its added mass, would swing on it at
    ``frequency``; with ``damping_ratio`` 1 it hardly bounces.
    """

    frequency: float = option(70.0, "angular frequency of the body on the spring of one rim", "rad/s", gt=0)
    damping_ratio: float = option(1.0, "damping of that spring, relative to critical", "", ge=0)
    friction: float = option(0.0, "coefficient of Coulomb friction", "", ge=0, le=10)


class FlightLimits(Table):
    """When a flight is over, if the agent has not reached the outlet."""

    horizon: float = option(20.0, "longest duration of a flight", "s", gt=0)


class Robustness(Table):
    """What may be otherwise than planned, and how finalists are judged by it.

    The quantities are standard deviations of normal distributions, cut off at three of them.
    """

    conditions: int = option(
        0, "disturbed flights of every finalist; 0 to judge by the undisturbed flight alone", ge=0, le=10_000
    )
    finalists: int = option(
        5, "agents that are flown so for each target: those whose undisturbed flights are best", gt=0
    )
    score: Literal["mean", "quantile", "worst"] = option(
        "mean", "what counts of a finalist's fitness over all conditions"
    )
    quantile: float = option(
        0.1, "share of the conditions that may be worse than what counts, with score = 'quantile'", ge=0, le=1
    )
    position: float = option(
        0.02, "of the point of release, along each of two directions across the pipe", "m", ge=0
    )
    angle_deg: float = option(2.0, "of pitch and yaw at the release", "deg", ge=0, le=30)
    current: float = option(0.03, "of the speed of the current, relative", ge=0, le=0.3)
    density: float = option(0.001, "of the density of the water, relative", ge=0, le=0.3)
    mass: float = option(0.01, "of the mass of the printed hull, relative", ge=0, le=0.3)
    wall: float = option(0.00002, "of the thickness of the printed wall", "m", ge=0)


def _check_names(targets: dict[str, Vector]) -> dict[str, Vector]:
    for name in targets:
        if not name.replace("-", "").replace("_", "").isalnum():
            raise ValueError(
                f"target name '{name}' may hold letters, digits, '-' and '_' only: it names a folder"
            )
    return targets


class Scenario(Table):
    """Everything about the environment; the same tables as in a study file."""

    pipe: Pipe = Field(default=Pipe(), description="the pipe")
    flow: Flow = Field(default=UniformFlow(), description="the current")
    fluid: Fluid = Field(default=Fluid(), description="the water")
    release: Release = Field(default=Release(), description="how the agent enters")
    contact: Contact = Field(default=Contact(), description="contact with the wall")
    flight: FlightLimits = Field(default=FlightLimits(), description="when a flight is over")
    robustness: Robustness = Field(
        default=Robustness(), description="what may be otherwise than planned, and what counts then"
    )
    targets: Annotated[dict[str, Vector], AfterValidator(_check_names)] = Field(
        default={},
        description="points to reach, each a name and a position in the world frame",
        json_schema_extra={"unit": "m"},
    )

    @model_validator(mode="after")
    def _check_together(self) -> "Scenario":
        if self.targets and not self.pipe.segments:
            raise ValueError("targets need a pipe: fitness is relative to the farthest point of its volume")
        if isinstance(self.flow, PipeFlow) and not self.pipe.segments:
            raise ValueError(
                f"flow.kind = '{self.flow.kind}' needs a pipe; in open water it can be 'uniform' only"
            )
        if isinstance(self.flow, LogLawFlow | TurbulentFlow):
            most = 0.1 * min(segment.radius for segment in self.pipe.segments)
            if self.flow.roughness > most:
                raise ValueError(
                    f"flow.roughness = {self.flow.roughness} is too much for a logarithmic law in this pipe: "
                    f"it holds up to a twentieth of the diameter, {most:g} m"
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
        """The order of every fitness vector."""
        return tuple(self.targets)

    def target_array(self) -> FloatArray:
        """The targets in the world frame, m, (targets, 3)."""
        return np.array(list(self.targets.values()), dtype=np.float64).reshape(-1, 3)

    def direction(self) -> FloatArray:
        """Unit vector downstream where the water enters, world frame, (3,): along x in open water."""
        if not self.pipe.segments:
            return np.array([1.0, 0.0, 0.0])
        first = self.pipe.segments[0]
        axis = np.subtract(first.end, first.start)
        return np.asarray(axis / np.linalg.norm(axis), dtype=np.float64)

    def current(self) -> FloatArray:
        """Mean velocity of the water where it enters, in the world frame, m/s, (3,)."""
        return self.flow.speed * self.direction()

    def of_evaluation(self, seed: int, index: int) -> "Scenario":
        """The scenario as evaluation ``index`` of a run with this seed meets it: with gusts of its own."""
        return self.with_gusts(evaluation_seed(seed, index))

    def with_gusts(self, seed: int | None) -> "Scenario":
        """The scenario with the gusts of a seed, where its flow has any; ``None`` for its own."""
        if seed is None or not isinstance(self.flow, TurbulentFlow):
            return self
        return self.model_copy(update={"flow": self.flow.model_copy(update={"seed": seed})})

    def release_quaternion(self) -> FloatArray:
        """Attitude of the released agent, (4,): turned about y by the pitch angle, then about z by the yaw angle."""
        pitch, yaw = np.deg2rad([self.release.pitch_deg, self.release.yaw_deg]) / 2
        c, s = np.cos(pitch), np.sin(pitch)
        return np.array([np.cos(yaw) * c, -np.sin(yaw) * s, np.cos(yaw) * s, np.sin(yaw) * c])


def evaluation_seed(seed: int, index: int) -> int:
    """Seed of what is random about evaluation ``index`` of a run with this seed, such as its gusts."""
    return int(np.random.SeedSequence((seed, index)).generate_state(1)[0])
