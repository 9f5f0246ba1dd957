"""The columns of tables: the evaluations of a run, and the samples of their trajectories."""

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
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


def _read_columns(table: str) -> tuple[Column, ...]:
    with Path(__file__).with_name("columns.csv").open(encoding="utf-8", newline="") as file:
        return tuple(Column(*row[1:]) for row in csv.reader(file) if row[0] == table)  # type: ignore[arg-type]


_OUTCOME = _read_columns("outcome")

BODY_COLUMNS = _read_columns("body")
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
    fitness = (Column(f"fitness_{t}", "float", "%", f"for {t}; 0 where the evaluation failed") for t in targets)
    return (*_OUTCOME, *BODY_COLUMNS, *fitness)
