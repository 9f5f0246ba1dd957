"""Flights as tables, for pandas, polars and spreadsheets: one row for each sample."""

from abc import abstractmethod
from dataclasses import replace
from pathlib import Path

import numpy as np

from driftform.interfaces import ExportJob, Recorder
from driftform.options import Table
from driftform.tables.columns import SAMPLE_COLUMNS, Batch, Column
from driftform.tables.files import check_format, write_csv, write_parquet
from driftform.types import Trajectory, WrittenFile
from driftform.util.files import write_whole

WRENCH_COLUMNS = (
    *(Column(f"force_{axis}", "float", "N", "all that acts on the body, body frame") for axis in "xyz"),
    *(
        Column(f"torque_{axis}", "float", "N m", "the same about the centre of gravity, body frame")
        for axis in "xyz"
    ),
)

COLUMNS = (*(replace(column, kind="float") for column in SAMPLE_COLUMNS[1:]), *WRENCH_COLUMNS)
"""Those of a stored flight in full precision, and the net force and torque on the body."""


class TableRecorder(Recorder[Table]):
    """One row for each sample: time, position, attitude, velocity, and the net force and torque on the body.

    SI units; the position is that of the core's centre in the world frame, the quaternion leads from the body to the
    world, and the rest is in the body frame. Force and torque are mass times acceleration, about the centre of
    gravity: weight, buoyancy, the wall's push and all forces of the water together.
    """

    def write(self, job: ExportJob, trajectory: Trajectory, path: Path) -> tuple[WrittenFile, ...]:
        """Write the table."""
        from driftform.trajectory.forces import accelerations_along, net_wrench

        check_format(self.name)
        moved_by = accelerations_along(trajectory, job.agent, job.scenario)
        wrench = net_wrench(trajectory, moved_by, job.agent.mass)
        parts = (trajectory.t, trajectory.position, trajectory.quaternion, trajectory.velocity, wrench)
        names = [column.name for column in COLUMNS]
        batch: Batch = dict(zip(names, np.column_stack(parts).T, strict=True))
        write_whole(path, lambda part: self.write_table(part, batch))
        facts = {"samples": len(trajectory.t), "duration": float(trajectory.t[-1]), "columns": len(COLUMNS)}
        return (WrittenFile(self.name, str(path), facts),)

    @abstractmethod
    def write_table(self, path: Path, rows: Batch) -> None:
        """Write the table of :data:`COLUMNS`."""


class CsvRecorder(TableRecorder):
    """A flight as CSV, with the names of the columns in the first line and numbers with all their digits."""

    name = "csv"
    suffix = ".csv"

    def write_table(self, path: Path, rows: Batch) -> None:
        """Write it as CSV."""
        write_csv(path, COLUMNS, [rows])


class ParquetRecorder(TableRecorder):
    """A flight as Parquet, with unit and meaning of each column; needs ``driftform[parquet]``."""

    name = "parquet"
    suffix = ".parquet"

    def write_table(self, path: Path, rows: Batch) -> None:
        """Write it as Parquet."""
        write_parquet(path, COLUMNS, [rows])
