"""Flights as tables for pandas, polars and spreadsheets: one row per sample."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from driftform.interfaces import ExportJob, Recorder
from driftform.runs.table_files import FORMATS, SAMPLE_COLUMNS, Batch, check_format, read_columns
from driftform.types import Trajectory, WrittenFile
from driftform.util.files import write_whole
from driftform.util.options import Table

COLUMNS = (*(replace(column, kind="float") for column in SAMPLE_COLUMNS[1:]), *read_columns("wrench"))
"""The columns of a stored flight in full precision, and the net force and torque on the body."""


class TableRecorder(Recorder[Table]):
    """One row per sample: time, position, attitude, velocity, and the net force and torque on the body.

    All values are in SI units. The position is that of the core's centre in the world frame, the quaternion rotates from
    the body frame to the world frame, and all other vectors are in the body frame. Net force and torque include weight,
    buoyancy, the contact force of the wall and all forces of the water; the torque is about the centre of gravity.
    """

    def write(self, job: ExportJob, trajectory: Trajectory, path: Path) -> tuple[WrittenFile, ...]:
        """Write the table."""
        from driftform.motion.path.accelerations import accelerations_along, net_wrench

        check_format(self.name)
        accelerations = accelerations_along(trajectory, job.agent, job.scenario)
        wrench = net_wrench(trajectory, accelerations, job.agent.mass)
        parts = (trajectory.t, trajectory.position, trajectory.quaternion, trajectory.velocity, wrench)
        names = [column.name for column in COLUMNS]
        batch: Batch = dict(zip(names, np.column_stack(parts).T, strict=True))
        write_whole(path, lambda part: FORMATS[self.name](part, COLUMNS, [batch]))
        facts = {"samples": len(trajectory.t), "duration": float(trajectory.t[-1]), "columns": len(COLUMNS)}
        return (WrittenFile(self.name, str(path), facts),)


class CsvRecorder(TableRecorder):
    """A flight as CSV: the first line holds the names of the columns, numbers have all their digits."""

    name = "csv"
    suffix = ".csv"


class ParquetRecorder(TableRecorder):
    """A flight as Parquet, with the unit and the meaning of each column; needs the extra ``parquet``."""

    name = "parquet"
    suffix = ".parquet"
