"""The columns of tables: the evaluations of a run, and the samples of their trajectories."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy.typing as npt

Batch: TypeAlias = Mapping[str, list[Any] | npt.NDArray[Any]]
"""Some rows of a table: values by column, all of the same length; ``None`` for a missing value."""


@dataclass(frozen=True)
class Column:
    """A column: its name, the kind of its values, its unit (empty for none), and its meaning."""

    name: str
    kind: Literal["integer", "float", "single", "text", "integers"]
    unit: str
    meaning: str


_OUTCOME = (
    Column("evaluation", "integer", "", "index in the run, from 0"),
    Column("generation", "integer", "", "counted from 0"),
    Column("population", "text", "", "target that its population works for; empty where it works for all"),
    Column("parents", "integers", "", "evaluations that it descends from; none for a random genome"),
    Column("genome", "text", "", "the genome in one line"),
    Column("tuning", "float", "", "of the body, such as the mass of ballast (kg); 0 for none"),
    Column("failure", "text", "", "what went wrong; none for a sound evaluation"),
    Column("end", "text", "", "why the flight ended"),
    Column("duration", "float", "s", "of the flight"),
    Column("contact", "float", "s", "when a wall was first touched; none where none was"),
    Column(
        "energy_drift", "float", "", "relative, up to the first contact; none where nothing conserves energy"
    ),
    Column("error", "float", "m", "estimated, of the position; none where the flight was not checked"),
    Column("seconds", "float", "s", "that the evaluation took"),
    Column("seed", "integer", "", "of what was random about the evaluation, such as its gusts"),
)

BODY_COLUMNS = (
    Column("modules", "integer", "", "how many there are"),
    Column("length", "float", "m", "overall, along the axis"),
    Column("max_diameter", "float", "m", "largest outer diameter"),
    Column("mass", "float", "kg", "hull and core"),
    Column("volume", "float", "m3", "displaced"),
    Column("net_buoyancy", "float", "N", "buoyancy of the submerged body less its weight, up positive"),
)
"""The columns of the body of a genome."""

FLIGHT_COLUMNS = (
    *("t", "x", "y", "z"),
    *("qw", "qx", "qy", "qz"),
    *("surge", "sway", "heave", "roll_rate", "pitch_rate", "yaw_rate"),
)
"""The columns of a Trajectory: time, position, quaternion and velocity."""

_FLIGHT_UNITS = ("s", *("m",) * 3, *("",) * 4, *("m/s",) * 3, *("rad/s",) * 3)
_FLIGHT_MEANINGS = (
    "time",
    *("of the core's centre, world frame",) * 3,
    *("attitude, body to world",) * 4,
    *("over ground, body frame",) * 6,
)

SAMPLE_COLUMNS = (
    Column("evaluation", "integer", "", "whose flight it is"),
    *(
        Column(name, "single", unit, meaning)
        for name, unit, meaning in zip(FLIGHT_COLUMNS, _FLIGHT_UNITS, _FLIGHT_MEANINGS, strict=True)
    ),
)
"""The columns of the samples of trajectories, in single precision as stored."""


def evaluation_columns(targets: Sequence[str]) -> tuple[Column, ...]:
    """Return the columns of the evaluations, with a fitness for each target."""
    fitness = (
        Column(f"fitness_{t}", "float", "%", f"for {t}; 0 where the evaluation failed") for t in targets
    )
    return (*_OUTCOME, *BODY_COLUMNS, *fitness)
