"""What every exporter must do."""

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from driftform.errors import DriftformError
from driftform.geometry import mass_properties
from driftform.interfaces import Exporter, ExportJob
from driftform.scenario import Pipe, Scenario, Segment
from driftform.testing.bodies import hollow_body
from driftform.types import Agent, Coefficients


class ExporterContract:
    """Inherit, and say how the exporter is made::

    class TestMyExporter(ExporterContract):
        def plugin(self) -> MyExporter:
            return MyExporter(MyOptions())
    """

    def plugin(self) -> Exporter[Any]:
        """Return the exporter to be tested."""
        raise NotImplementedError

    def export_job(self) -> ExportJob:
        """Return an agent that can be exported: a capped hollow tube, without a genome, in a pipe."""
        body = hollow_body()
        agent = Agent(body, mass_properties(body), Coefficients(0.01 * np.eye(6)))
        segment = Segment(start=(0.0, 0.0, 0.0), end=(9.0, 0.0, 0.0), radius=1.0)
        scenario = Scenario(pipe=Pipe(segments=(segment,)), targets={"leak": (4.0, 0.0, -0.9)})
        return ExportJob("agent", agent, scenario)

    def path(self, directory: Path) -> Path:
        """Return the path that commands ask an exporter to write to."""
        return directory / f"agent{self.plugin().suffix}"

    def test_every_file_is_there_under_the_name_that_was_asked_for(self, tmp_path: Path) -> None:
        """Each that is told of exists, is not empty, and its name begins with that of the path."""
        written = self.plugin().write(self.export_job(), self.path(tmp_path))
        assert written
        for file in written:
            path = Path(file.path)
            assert file.format == self.plugin().name
            assert path.is_file() and path.stat().st_size > 0
            assert path.relative_to(tmp_path).parts[0].startswith("agent")

    def test_the_suffix_ends_the_name_of_a_file_or_of_a_folder(self) -> None:
        """A dot and something after it for a file, something that does not begin with a dot for a folder."""
        suffix = self.plugin().suffix
        assert len(suffix) > 1
        assert Path(f"agent{suffix}").name == f"agent{suffix}" and not suffix.endswith(".")

    def test_nothing_else_is_left_beside_the_files(self, tmp_path: Path) -> None:
        """What is written on the way is gone in the end, and no file is there that is not told of."""
        written = self.plugin().write(self.export_job(), self.path(tmp_path))
        assert _files(tmp_path) == sorted(Path(file.path) for file in written)

    def test_a_file_that_is_there_already_is_replaced(self, tmp_path: Path) -> None:
        """A second export leaves what a first one would have left, and nothing of the old files."""
        fresh, old = tmp_path / "fresh", tmp_path / "old"
        sizes = []
        for directory in (fresh, old):
            directory.mkdir()
            for _ in range(1 if directory == fresh else 2):
                for path in _files(directory):
                    path.write_bytes(b"old " * 1_000_000)
                self.plugin().write(self.export_job(), self.path(directory))
            sizes.append([(path.relative_to(directory), path.stat().st_size) for path in _files(directory)])
        assert sizes[0] == sizes[1]

    def test_of_an_older_folder_nothing_stays(self, tmp_path: Path) -> None:
        """What an older export left in the folder, or anybody, goes with it, and no empty folder is left beside it.

        A format that is no folder leaves alone what is beside its file.
        """
        path = self.path(tmp_path)
        is_folder = not Path(f"agent{self.plugin().suffix}").suffix
        stale = (path if is_folder else tmp_path) / "older" / "stale.txt"
        stale.parent.mkdir(parents=True)
        stale.write_text("of an older export")
        written = self.plugin().write(self.export_job(), path)
        assert stale.exists() != is_folder
        known = {stale, *(Path(file.path) for file in written)}
        needed = {parent for file in known for parent in file.parents} | known
        assert sorted(found for found in tmp_path.rglob("*") if found not in needed) == []

    def test_a_file_that_cannot_be_written_leaves_nothing_behind(self, tmp_path: Path) -> None:
        """Where a folder stands in the place of a file, or a file in that of a folder, the export fails.

        No half of a file remains.
        """
        first = Path(self.plugin().write(self.export_job(), self.path(tmp_path / "sound"))[0].path)
        part = first.relative_to(tmp_path / "sound").parts[0]
        blocked = tmp_path / "blocked" / part
        if first == tmp_path / "sound" / part:
            blocked.mkdir(parents=True)
        else:
            blocked.parent.mkdir()
            blocked.write_text("in the way")
        with pytest.raises((DriftformError, OSError)):
            self.plugin().write(self.export_job(), self.path(blocked.parent))
        assert list(blocked.parent.iterdir()) == [blocked]
        assert blocked.is_file() or not list(blocked.iterdir())

    def test_it_can_be_sent_to_a_worker_process(self, tmp_path: Path) -> None:
        """A pickled copy writes too."""
        copy = pickle.loads(pickle.dumps(self.plugin()))
        assert all(Path(file.path).is_file() for file in copy.write(self.export_job(), self.path(tmp_path)))


def _files(directory: Path) -> list[Path]:
    return sorted(path for path in directory.rglob("*") if path.is_file())
