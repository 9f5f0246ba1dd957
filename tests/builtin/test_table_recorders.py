"""Flights as tables: the columns, their numbers, and the readers that people use."""

import csv

import numpy as np
import pytest

from driftform.builtin.table_recorders import COLUMNS, CsvRecorder, ParquetRecorder
from driftform.errors import WorkFailedError
from driftform.motion.path.accelerations import accelerations_along, net_wrench
from driftform.testing import RecorderContract
from driftform.testing.renderer import drifting_trajectory
from driftform.util.options import Table


class TestCsv(RecorderContract):
    def plugin(self):
        return CsvRecorder(Table())


@pytest.mark.peers
class TestParquet(RecorderContract):
    def plugin(self):
        return ParquetRecorder(Table())


def test_csv_gives_every_number_back(tmp_path):
    trajectory = drifting_trajectory()
    path = TestCsv().record(tmp_path, trajectory)
    with path.open(newline="") as file:
        rows = list(csv.reader(file))
    assert rows[0] == [column.name for column in COLUMNS]
    values = np.array(rows[1:], dtype=float)
    assert np.array_equal(values[:, 0], trajectory.t)
    assert np.array_equal(values[:, 1:4], trajectory.position)
    assert np.array_equal(values[:, 4:8], trajectory.quaternion)
    assert np.array_equal(values[:, 8:14], trajectory.velocity)


@pytest.mark.peers
def test_both_tables_are_the_same_to_pandas_and_polars(tmp_path):
    import pandas
    import polars

    frame = pandas.read_csv(TestCsv().record(tmp_path), float_precision="round_trip")
    other = polars.read_parquet(TestParquet().record(tmp_path))
    assert list(frame) == other.columns
    assert np.array_equal(frame.to_numpy(), other.to_numpy())


def test_force_and_torque_are_the_last_columns(tmp_path):
    trajectory, job = drifting_trajectory(), TestCsv().export_job()
    wrench = net_wrench(trajectory, accelerations_along(trajectory, job.agent, job.scenario), job.agent.mass)
    with TestCsv().record(tmp_path, trajectory).open(newline="") as file:
        rows = list(csv.reader(file))
    assert rows[0][-6:] == ["force_x", "force_y", "force_z", "torque_x", "torque_y", "torque_z"]
    assert np.array_equal(np.array(rows[1:], dtype=float)[:, -6:], wrench)


def test_without_pyarrow_parquet_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setattr("driftform.runs.table_files.find_spec", lambda name: None)
    with pytest.raises(WorkFailedError, match=r"driftform\[parquet\]"):
        TestParquet().record(tmp_path)
    assert list(tmp_path.iterdir()) == []
