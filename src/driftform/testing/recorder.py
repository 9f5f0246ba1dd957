"""Contract of recorders."""

import pickle
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from driftform.errors import DriftformError
from driftform.interfaces import Recorder
from driftform.plugins.seams import require_files
from driftform.testing.exporter import JobContract, list_files
from driftform.testing.renderer import drifting_trajectory
from driftform.types import End, Trajectory
from driftform.water import Scenario


class RecorderContract(JobContract[Recorder[Any]]):
    """Inherit this class, and make the recorder::

    class TestMyRecorder(RecorderContract):
        def plugin(self) -> MyRecorder:
            return MyRecorder(MyOptions())
    """

    leak = (0.1, 0.0, -1.0)

    def record(
        self, path: Path, trajectory: Trajectory | None = None, scenario: Scenario | None = None
    ) -> Path:
        """Record a trajectory, by default one that drifts and pitches; return the path of the file or the folder."""
        job = self.export_job()
        if scenario is not None:
            job = replace(job, scenario=scenario)
        path = path / f"agent{self.plugin().suffix}"
        recorder = self.plugin()
        written = recorder.write(job, drifting_trajectory() if trajectory is None else trajectory, path)
        for file in require_files(written, recorder):
            found = Path(file.path)
            assert file.format == self.plugin().name
            assert found.is_file() and found.stat().st_size > 0
            assert found == path or path in found.parents
        return path

    def test_only_the_requested_files_are_written(self, tmp_path: Path) -> None:
        """Every reported file exists and is not empty, and every file that is written is reported."""
        path = self.record(tmp_path)
        assert list(tmp_path.iterdir()) == [path]
        written = self.plugin().write(self.export_job(), drifting_trajectory(), path)
        assert list_files(tmp_path) == sorted(Path(file.path) for file in written)

    def test_the_same_flight_gives_the_same_content(self, tmp_path: Path) -> None:
        """The content is the same from a recorder that was sent to another process, and when files are replaced."""
        first = self.record(tmp_path / "first")
        sizes = [(p.relative_to(first), p.stat().st_size) for p in list_files(first)]
        for old in list_files(first):
            old.write_bytes(b"old " * 100_000)
        self.record(tmp_path / "first")
        assert [(p.relative_to(first), p.stat().st_size) for p in list_files(first)] == sizes
        copy: Recorder[Any] = pickle.loads(pickle.dumps(self.plugin()))
        second = tmp_path / "second" / first.name
        copy.write(self.export_job(), drifting_trajectory(), second)
        assert [(p.relative_to(second), p.read_bytes()) for p in list_files(second)] == [
            (p.relative_to(first), p.read_bytes()) for p in list_files(first)
        ]

    def test_a_flight_of_one_sample_is_recorded_too(self, tmp_path: Path) -> None:
        """A flight that ended at its release has one sample."""
        whole = drifting_trajectory()
        start = (whole.t[:1], whole.position[:1], whole.quaternion[:1], whole.velocity[:1])
        self.record(tmp_path, Trajectory(*start, End.INLET))

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

    def test_a_failed_write_leaves_nothing_behind(self, tmp_path: Path) -> None:
        """If a folder is in the place of a file, or a file in that of a folder, writing fails and leaves no partial file."""
        path = tmp_path / f"agent{self.plugin().suffix}"
        is_file = self.record(tmp_path / "sound").is_file()
        blocked = tmp_path / "blocked" / path.name
        blocked.parent.mkdir()
        if is_file:
            blocked.mkdir()
        else:
            blocked.write_text("in the way")
        with pytest.raises((DriftformError, OSError)):
            self.record(blocked.parent)
        assert list(blocked.parent.iterdir()) == [blocked]
        assert blocked.is_file() or not list(blocked.iterdir())
