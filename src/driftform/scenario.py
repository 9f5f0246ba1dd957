"""The environment, as data: pipe, flow, fluid, release, targets. Validated here, read by compiled kernels as arrays."""

from typing import Annotated, Literal, TypeAlias

import numpy as np
from pydantic import AfterValidator, Field, model_validator

from driftform.options import Table, option
from driftform.types import FloatArray

Number: TypeAlias = Annotated[float, Field(strict=True)]

Vector: TypeAlias = tuple[Number, Number, Number]
"""A vector of the world frame."""


class Segment(Table):
    """One straight piece of pipe with a circular bore."""

    start: Vector = option(..., "centre of the upstream end", "m")
    end: Vector = option(..., "centre of the downstream end", "m")
    radius: float = option(..., "inner radius", "m", gt=0, strict=True)

    @model_validator(mode="after")
    def _has_length(self) -> "Segment":
        if self.start == self.end:
            raise ValueError("start and end of a pipe segment are the same point")
        return self


def _inside(segment: Segment, point: Vector) -> bool:
    start, end = np.array(segment.start), np.array(segment.end)
    axis = (end - start) / np.linalg.norm(end - start)
    along = float(axis @ (point - start))
    across = float(np.linalg.norm(point - start - along * axis))
    length = float(np.linalg.norm(end - start))
    return -1e-9 <= along <= length + 1e-9 and across <= segment.radius


class Pipe(Table):
    """A chain of segments from the inlet to the outlet; without any, the agent is in open water."""

    segments: tuple[Segment, ...] = option((), "from the inlet to the outlet", max_length=1)

    def array(self) -> FloatArray:
        """Rows of start (3), end (3), radius, all in m: (segments, 7)."""
        rows = [(*s.start, *s.end, s.radius) for s in self.segments]
        return np.array(rows, dtype=np.float64).reshape(-1, 7)

    def farthest_distance(self, point: FloatArray) -> float:
        """Distance (m) from ``point`` to the farthest point of the pipe's volume, infinite in open water.

        The distance is convex, so over a cylinder it is greatest on the rim of an end. On an end disc with unit
        normal n, a point at axial offset h and at distance s from the axis is farthest from the rim point right
        across the axis: sqrt(h^2 + (s + R)^2).
        """
        best = 0.0 if self.segments else np.inf
        for segment in self.segments:
            start, end = np.array(segment.start), np.array(segment.end)
            n = (end - start) / np.linalg.norm(end - start)
            for centre in (start, end):
                h = float(n @ (point - centre))
                s = float(np.linalg.norm(point - centre - h * n))
                best = max(best, float(np.hypot(h, s + segment.radius)))
        return best


class Flow(Table):
    """The water's velocity. ``uniform``: the same everywhere, along the pipe (along x in open water)."""

    kind: Literal["uniform"] = option("uniform", "name of the flow profile")
    speed: float = option(1.0, "speed of the current", "m/s", ge=-100, le=100)


class Fluid(Table):
    """The water."""

    density: float = option(1024.0, "density of the water", "kg/m3", gt=0)
    gravity: float = option(9.81, "acceleration of gravity, along -z", "m/s2", ge=0)


class Release(Table):
    """How the agent enters the water."""

    position: Vector = option((0.0, 0.0, 0.0), "where the core's centre is released, in the world frame", "m")
    pitch_deg: float = option(
        0.0, "pitch of the body's axis against x, positive nose down", "deg", ge=-90, le=90
    )
    velocity: Literal["current", "rest"] | Vector = option(
        "current", "'current' (moving with the water), 'rest', or a velocity in the world frame", "m/s"
    )


class Contact(Table):
    """Contact with the pipe's wall: a frictionless, inelastic penalty.

    The spring of a rim is so stiff that the body's mass, with its added mass, would swing on it at
    ``frequency``; with ``damping_ratio`` 1 it hardly bounces.
    """

    frequency: float = option(70.0, "angular frequency of the body on the spring of one rim", "rad/s", gt=0)
    damping_ratio: float = option(1.0, "damping of that spring, relative to critical", "", ge=0)


class Flight(Table):
    """When a flight is over, if the agent has not reached the outlet."""

    horizon: float = option(20.0, "longest duration of a flight", "s", gt=0)


def _named(targets: dict[str, Vector]) -> dict[str, Vector]:
    for name in targets:
        if not name.replace("-", "").replace("_", "").isalnum():
            raise ValueError(
                f"target name '{name}' may hold letters, digits, '-' and '_' only: it names a folder"
            )
    return targets


class Scenario(Table):
    """Everything about the environment; the same tables as in a study file."""

    pipe: Pipe = Field(default=Pipe(), description="the pipe")
    flow: Flow = Field(default=Flow(), description="the current")
    fluid: Fluid = Field(default=Fluid(), description="the water")
    release: Release = Field(default=Release(), description="how the agent enters")
    contact: Contact = Field(default=Contact(), description="contact with the wall")
    flight: Flight = Field(default=Flight(), description="when a flight is over")
    targets: Annotated[dict[str, Vector], AfterValidator(_named)] = Field(
        default={},
        description="points to reach, each a name and a position in the world frame",
        json_schema_extra={"unit": "m"},
    )

    @model_validator(mode="after")
    def _is_reachable(self) -> "Scenario":
        if self.targets and not self.pipe.segments:
            raise ValueError("targets need a pipe: fitness is relative to the farthest point of its volume")
        for name, point in (
            ("release.position", self.release.position),
            *((f"targets.{name}", point) for name, point in self.targets.items()),
        ):
            if self.pipe.segments and not any(_inside(segment, point) for segment in self.pipe.segments):
                raise ValueError(f"{name} = {list(point)} lies outside the pipe")
        return self

    @property
    def target_names(self) -> tuple[str, ...]:
        """The order of every fitness vector."""
        return tuple(self.targets)

    def target_array(self) -> FloatArray:
        """The targets in the world frame, m, (targets, 3)."""
        return np.array(list(self.targets.values()), dtype=np.float64).reshape(-1, 3)

    def current(self) -> FloatArray:
        """Velocity of the water in the world frame, m/s, (3,)."""
        if not self.pipe.segments:
            return np.array([self.flow.speed, 0.0, 0.0])
        first = self.pipe.segments[0]
        axis = np.subtract(first.end, first.start)
        return np.asarray(self.flow.speed * axis / np.linalg.norm(axis), dtype=np.float64)

    def release_velocity(self) -> FloatArray:
        """Velocity of the released agent in the world frame, m/s, (3,)."""
        match self.release.velocity:
            case "current":
                return self.current()
            case "rest":
                return np.zeros(3)
            case vector:
                return np.array(vector, dtype=np.float64)

    def release_quaternion(self) -> FloatArray:
        """Attitude of the released agent, (4,): a turn about y by the pitch angle."""
        half = np.deg2rad(self.release.pitch_deg) / 2
        return np.array([np.cos(half), 0.0, np.sin(half), 0.0])
