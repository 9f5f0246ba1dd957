"""The velocity profiles of the current."""

import math
from typing import Annotated, Literal, TypeAlias

from pydantic import Tag, model_validator

from driftform.util.options import MAX_SEED, Table, list_kinds, option, read_kind
from driftform.util.validity import RANGES
from driftform.water.pipe import Vector


class UniformFlow(Table):
    """The same velocity everywhere, along the pipe, or along x in open water."""

    kind: Literal["uniform"] = option("uniform", "name of the flow profile")
    speed: float = option(1.0, "speed of the current at the time of release", "m/s", ge=-100, le=100)
    acceleration: float = option(0.0, "change of the speed with time", "m/s2", ge=-10, le=10)
    added: Vector = option(
        (0.0, 0.0, 0.0), "velocity that is added everywhere, such as a cross current, in the world frame", "m/s"
    )

    @model_validator(mode="after")
    def _check_added(self) -> "UniformFlow":
        if self.acceleration and any(self.added):
            raise ValueError("flow.added needs a steady current: set flow.acceleration = 0, or leave flow.added out")
        return self


class PipeFlow(Table):
    """A velocity profile over the bore; ``speed`` is the mean over the cross-section."""

    speed: float = option(1.0, "bulk speed: volume flow divided by cross-section", "m/s", ge=1e-4, le=100)
    swirl: float = option(
        0.0,
        "secondary flow after a bend of 90 degrees: speed on the axis, away from the bend's centre, relative to the bulk speed",
        ge=0,
        le=0.5,
    )


class DevelopedProfile(PipeFlow):
    """A profile that has developed before the water comes to the inlet."""

    upstream: float = option(
        0.0, "length of the pipe before the inlet, of its bore, in which the profile develops", "m", ge=0, le=1e6
    )


class PowerLawFlow(DevelopedProfile):
    """Fully developed flow by the power law u ~ (y / R)^(1/n), where y is the distance from the wall."""

    kind: Literal["power_law"] = option("power_law", "name of the flow profile")
    exponent: float = option(7.0, "n: about 7 at a Reynolds number of 1e5, 9 at 1e6", ge=1, le=20)


class RoughFlow(DevelopedProfile):
    """A profile that depends on the friction of the pipe wall."""

    roughness: float = option(0.0, "equivalent sand roughness of the wall", "m", ge=0, le=10)


class LogLawFlow(RoughFlow):
    """Fully developed flow by the logarithmic law, with the friction of the pipe wall."""

    kind: Literal["log_law"] = option("log_law", "name of the flow profile")


class DevelopedFlow(RoughFlow):
    """Fully developed flow: the parabola below a Reynolds number of 2300 in each bore, and the logarithmic law above."""

    kind: Literal["developed"] = option("developed", "name of the flow profile")


class DevelopingFlow(PipeFlow):
    """Flow with uniform velocity at the inlet: a uniform core, and a turbulent boundary layer that grows downstream."""

    kind: Literal["developing"] = option("developing", "name of the flow profile")


class TurbulentFlow(RoughFlow):
    """The logarithmic law with gusts in every flight, as ``[gusts]`` describes them.

    Each evaluation of a run has different gusts, drawn from the seed of the run and the index of the evaluation.
    """

    kind: Literal["turbulent"] = option("turbulent", "name of the flow profile")


class GridFlow(Table):
    """Velocities on a regular grid from a file, such as the result of a CFD program: CSV, NetCDF or VTK."""

    kind: Literal["grid"] = option("grid", "name of the flow profile")
    file: str = option(
        ...,
        "file with the velocities, in the world frame and SI units: .csv, .nc, .vtk, .vti, .vtr, .vts or .vtu; a relative path begins at the "
        "folder of the study file",
        min_length=1,
    )
    speed: float = option(
        1.0, "mean speed at the inlet: the velocities in the file times speed / reference", "m/s", ge=1e-4, le=100
    )
    reference: float = option(1.0, "mean speed at the inlet in the file", "m/s", ge=1e-4, le=100)


class Gusts(Table):
    """The turbulence that a body meets; strength and memory follow from the friction and the bore of the pipe.

    Developed turbulent flow has them: log_law, power_law, developed, turbulent, and grid in a pipe.
    """

    always: bool = option(
        False,
        "gusts in every flight, as with flow.kind = 'turbulent'; otherwise in disturbed flights, if robustness.gusts",
    )
    strength: float = option(
        0.8,
        "standard deviation of each component of a gust, relative to the friction velocity; 0: no gusts",
        ge=0,
        le=10,
    )
    memory: float = option(
        1.0, "integral time of the gusts; 1 spreads a tracer by the eddy diffusivity of the pipe", ge=0.01, le=100
    )
    crossing: float = option(
        0.5,
        "length in which a gust carries the water within its memory, relative to the size of the gusts (Csanady's beta); "
        "0: gusts are uniform along the agent, and its motion through the water does not matter",
        ge=0,
        le=10,
    )
    smoothing: float = option(
        0.2,
        "time scale of the smallest eddies, within which a gust hardly changes, relative to the memory",
        ge=0.01,
        le=1,
    )
    seed: int = option(
        0, "seed of the gusts of a single flight; a run draws one for each evaluation", ge=0, le=MAX_SEED
    )


Flow: TypeAlias = Annotated[
    Annotated[UniformFlow, Tag("uniform")]
    | Annotated[PowerLawFlow, Tag("power_law")]
    | Annotated[LogLawFlow, Tag("log_law")]
    | Annotated[DevelopedFlow, Tag("developed")]
    | Annotated[DevelopingFlow, Tag("developing")]
    | Annotated[TurbulentFlow, Tag("turbulent")]
    | Annotated[GridFlow, Tag("grid")],
    read_kind("uniform"),
]
"""The velocity of the water: one of :data:`FLOWS`, by its ``kind``."""

FLOWS = list_kinds(Flow)
"""The flow profiles by name."""

KARMAN = 0.4
"""Von Karman's constant kappa."""


def friction_factor(reynolds: float, roughness: float = 0.0) -> float:
    """Return the Darcy friction factor of turbulent pipe flow (Colebrook 1939).

    1/sqrt(f) = -2 log10(roughness / 3.7 + 2.51 / (Re sqrt(f))); for a smooth wall this is Prandtl's law.

    Args:
        reynolds: on diameter and bulk velocity, from 4e3 to 1e8.
        roughness: equivalent sand roughness over diameter, up to 0.05.

    >>> round(friction_factor(1.9e6), 5)
    0.01046
    """
    inverse_root = 8.0
    for _ in range(50):
        inverse_root = -2 * math.log10(roughness / 3.7 + 2.51 * inverse_root / reynolds)
    return inverse_root**-2


def friction_velocity(flow: Flow, radius: float, speed: float, viscosity: float) -> float:
    """Return u* = U sqrt(f / 8), m/s, in a bore of ``radius`` (m) at the mean ``speed`` U, m/s."""
    # Below 4000 the law of friction does not hold.
    reynolds = max(4e3, 2 * radius * speed / viscosity)
    roughness = flow.roughness if isinstance(flow, RoughFlow) else 0.0
    return speed * math.sqrt(friction_factor(reynolds, roughness / (2 * radius)) / 8)


def is_laminar(flow: Flow, radius: float, speed: float, viscosity: float) -> bool:
    """Return whether a flow has the parabola of laminar flow in a bore of ``radius`` (m) at the mean ``speed``, m/s."""
    [limit] = RANGES["laminar profile"]
    return isinstance(flow, DevelopedFlow) and 2 * radius * abs(speed) / viscosity < limit.high
