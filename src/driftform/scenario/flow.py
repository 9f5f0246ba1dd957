"""The profiles of the current."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Discriminator, Tag

from driftform.options import Table, option


class UniformFlow(Table):
    """The same velocity everywhere, along the pipe (along x in open water)."""

    kind: Literal["uniform"] = option("uniform", "name of the flow profile")
    speed: float = option(1.0, "speed of the current, at the release", "m/s", ge=-100, le=100)
    acceleration: float = option(0.0, "change of the speed with time", "m/s2", ge=-10, le=10)


class PipeFlow(Table):
    """A profile over the bore, whose ``speed`` is the mean over the cross-section."""

    speed: float = option(1.0, "bulk speed: volume flow over cross-section", "m/s", gt=0, le=100)


class PowerLawFlow(PipeFlow):
    """Fully developed flow by the power law: u ~ (y / R)^(1/n), y being the distance from the wall."""

    kind: Literal["power_law"] = option("power_law", "name of the flow profile")
    exponent: float = option(7.0, "n: about 7 at a Reynolds number of 1e5, 9 at 1e6", ge=1, le=20)


class LogLawFlow(PipeFlow):
    """Fully developed flow by the logarithmic law, with the friction of the pipe's wall."""

    kind: Literal["log_law"] = option("log_law", "name of the flow profile")
    roughness: float = option(0.0, "equivalent sand roughness of the wall", "m", ge=0)


class DevelopingFlow(PipeFlow):
    """Flow that enters uniformly: a core of one speed, and a turbulent boundary layer that grows downstream."""

    kind: Literal["developing"] = option("developing", "name of the flow profile")


class TurbulentFlow(PipeFlow):
    """The logarithmic law, and gusts on it: an Ornstein-Uhlenbeck process along the agent's path.

    Every evaluation of a run meets gusts of its own, drawn from the run's seed and its index.
    """

    kind: Literal["turbulent"] = option("turbulent", "name of the flow profile")
    roughness: float = option(0.0, "equivalent sand roughness of the wall", "m", ge=0)
    intensity: float = option(
        0.8, "standard deviation of a gust's components over the friction velocity", ge=0, le=10
    )
    memory: float = option(3.0, "Lagrangian integral time of the gusts", "s", gt=0)
    smoothing: float = option(
        0.1, "time within which a gust hardly changes: that of the smallest eddies", "s", gt=0
    )
    seed: int = option(0, "seed of the gusts of a single flight; a run draws one for each evaluation", ge=0)


FLOWS: dict[str, type[Table]] = {
    "uniform": UniformFlow,
    "power_law": PowerLawFlow,
    "log_law": LogLawFlow,
    "developing": DevelopingFlow,
    "turbulent": TurbulentFlow,
}
"""The flow profiles by name."""


def _read_kind(value: Any) -> Any:
    """Which profile a table is: its ``kind``, and ``uniform`` where it has none."""
    return value.get("kind", "uniform") if isinstance(value, Mapping) else getattr(value, "kind", None)


Flow: TypeAlias = Annotated[
    Annotated[UniformFlow, Tag("uniform")]
    | Annotated[PowerLawFlow, Tag("power_law")]
    | Annotated[LogLawFlow, Tag("log_law")]
    | Annotated[DevelopingFlow, Tag("developing")]
    | Annotated[TurbulentFlow, Tag("turbulent")],
    Discriminator(_read_kind),
]
"""The water's velocity."""
