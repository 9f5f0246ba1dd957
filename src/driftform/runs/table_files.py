"""Tables as files, written batch by batch, so that a table need not fit into memory; and the columns of those of a run."""

import csv
import json
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from driftform.errors import WorkFailedError
from driftform.interfaces import Measure
from driftform.types import Trajectory
from driftform.util.files import write_whole

Batch: TypeAlias = Mapping[str, list[Any] | npt.NDArray[Any]]
"""Some rows of a table: values by column, all of the same length; ``None`` for a missing value."""


@dataclass(frozen=True)
class Column:
    """A column: its name, the kind of its values, its unit (empty for none), and its meaning."""

    name: str
    kind: Literal["integer", "float", "single", "text", "integers"]
    unit: str
    meaning: str


def read_columns(table: str) -> tuple[Column, ...]:
    """Return the columns of a table by its name in ``columns.csv``."""
    with Path(__file__).with_name("columns.csv").open(encoding="utf-8", newline="") as file:
        return tuple(Column(*row[1:]) for row in csv.reader(file) if row[0] == table)  # type: ignore[arg-type]


_OUTCOME = read_columns("outcome")

BODY_COLUMNS = read_columns("body")
"""The columns of the body of a genome."""

SAMPLE_COLUMNS = read_columns("sample")
"""The columns of the samples of trajectories, in single precision as stored."""

FLIGHT_COLUMNS = tuple(column.name for column in SAMPLE_COLUMNS[1:])
"""The columns of a Trajectory: time, position, quaternion and velocity."""


MEASURE_COLUMNS = read_columns("measure")
"""The columns of what is measured of each evaluation, beside those of its body."""


def evaluation_columns(
    targets: Sequence[str], measures: Mapping[str, Measure] = {}, constraints: Iterable[str] = ()
) -> tuple[Column, ...]:
    """Return the columns of the evaluations, with measures of a fitness, constraints, and a fitness for each target."""
    found = [Column(name, "float", measure.unit, measure.meaning) for name, measure in measures.items()]
    known = {column.name for column in (*MEASURE_COLUMNS, *found)}
    found += [
        Column(name, "float", "", "by how much it is missed, 0 is feasible")
        for name in constraints
        if name not in known
    ]
    fitness = (Column(f"fitness_{t}", "float", "%", f"for {t}; 0 where the evaluation failed") for t in targets)
    return (*_OUTCOME, *BODY_COLUMNS, *MEASURE_COLUMNS, *found, *fitness)


TableWriter = Callable[[Path, Sequence[Column], Iterable[Batch]], int]
"""Writes a table to a path, and returns its number of rows."""


def write_csv(path: Path, columns: Sequence[Column], batches: Iterable[Batch]) -> int:
    """Write a table as CSV: lists as JSON, missing values as empty fields, numbers with all digits."""
    rows, formulas = 0, set[str]()
    names = [column.name for column in columns]
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(names)
        for batch in batches:
            texts = [_format_values(batch[name]) for name in names]
            writer.writerows(zip(*texts, strict=True))
            rows += len(texts[0])
            formulas |= {
                c.name for c in columns if c.kind == "text" and any(str(t)[:1] in tuple("=+-@") for t in batch[c.name])
            }
    if formulas:
        found = ", ".join(sorted(formulas))
        print(
            f"warning: texts in {found} begin with =, +, - or @: a spreadsheet takes them for formulas", file=sys.stderr
        )
    return rows


def _format_values(values: Any) -> list[Any]:
    if isinstance(values, np.ndarray):
        # The shortest digits that restore the number in single precision.
        texts: list[Any] = values.astype(str).tolist()
        return texts
    return [json.dumps(value) if isinstance(value, list) else value for value in values]


def write_parquet(path: Path, columns: Sequence[Column], batches: Iterable[Batch]) -> int:
    """Write a table as Parquet, with one row group for each batch, and unit and meaning as metadata of each column."""
    import pyarrow
    from pyarrow import parquet

    kinds = {
        "integer": pyarrow.int64(),
        "float": pyarrow.float64(),
        "single": pyarrow.float32(),
        "text": pyarrow.string(),
        "integers": pyarrow.list_(pyarrow.int64()),
    }
    schema = pyarrow.schema(
        [pyarrow.field(c.name, kinds[c.kind], metadata={"unit": c.unit, "meaning": c.meaning}) for c in columns]
    )
    rows = 0
    with parquet.ParquetWriter(path, schema, compression="zstd") as writer:
        for batch in batches:
            table = pyarrow.table(dict(batch), schema=schema)
            writer.write_table(table)
            rows += table.num_rows
    return rows


FORMATS: dict[str, TableWriter] = {"csv": write_csv, "parquet": write_parquet}
"""The writers of tables by format, which is also the file suffix."""


def check_format(name: str) -> None:
    """Check that a format can be written, before any work is done.

    Raises WorkFailedError if a package is missing.
    """
    if name == "parquet" and find_spec("pyarrow") is None:
        raise WorkFailedError(
            "parquet files need the package pyarrow: uv sync --extra parquet, or pip install 'driftform[parquet]'; or choose --format csv"
        )


def write_trajectory(path: Path, trajectory: Trajectory) -> None:
    """Write a flight as CSV: SI units, quaternion body to world, velocity in the body frame; in single precision."""
    parts = (trajectory.t, trajectory.position, trajectory.quaternion, trajectory.velocity)
    batch = dict(zip(FLIGHT_COLUMNS, np.column_stack(parts).astype(np.float32).T, strict=True))
    write_whole(path, lambda part: write_csv(part, SAMPLE_COLUMNS[1:], [batch]))
