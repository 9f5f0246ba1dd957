"""Contract of recorders."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from driftform.interfaces import Recorder
from driftform.plugins.seams import require_files
from driftform.testing.agents import first_samples
from driftform.testing.exporter import JobContract, list_files
from driftform.testing.renderer import drifting_trajectory
from driftform.types import End, Trajectory
from driftform.water import Scenario


class RecorderContract(JobContract[Recorder[Any]]):
    """The contract of recorders."""

    leak = (0.1, 0.0, -1.0)

    def write_by(self, plugin: Any, path: Path) -> Any:
        """Record a flight that drifts and pitches."""
        return plugin.write(self.export_job(), drifting_trajectory(), path)

    def record(self, folder: Path, trajectory: Trajectory | None = None, scenario: Scenario | None = None) -> Path:
        """Record a trajectory, by default one that drifts and pitches; return the path of the file or the folder."""
        job, path, recorder = self.export_job(), self.path(folder), self.plugin()
        job = job if scenario is None else replace(job, scenario=scenario)
        require_files(recorder.write(job, trajectory or drifting_trajectory(), path), recorder)
        assert path.exists()
        return path

    def test_a_flight_of_one_sample_is_recorded_too(self, tmp_path: Path) -> None:
        """A flight that ended at its release has one sample."""
        self.record(tmp_path, first_samples(drifting_trajectory()))

    @pytest.mark.parametrize("end", [end for end in End if end.failed])
    def test_a_flight_that_failed_is_recorded_too(self, end: End, tmp_path: Path) -> None:
        """The samples of a failed flight help to find the cause."""
        self.record(tmp_path, replace(drifting_trajectory(), end=end))

    def test_a_flight_in_open_water_is_recorded_too(self, tmp_path: Path) -> None:
        """A scenario may have neither a pipe nor targets."""
        self.record(tmp_path, scenario=Scenario())

    def test_another_flight_gives_other_content(self, tmp_path: Path) -> None:
        """A flight that turns the other way differs in the content of the files, not only in their names."""
        contents = []
        for turn in (1.0, -1.0):
            path = self.record(tmp_path / str(turn), drifting_trajectory(turn=turn))
            contents.append([file.read_bytes() for file in list_files(path)])
        assert contents[0] != contents[1]
