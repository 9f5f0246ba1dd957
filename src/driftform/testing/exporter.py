"""Contract of exporters."""

import pickle
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

from driftform.agent import mass_properties
from driftform.errors import DriftformError
from driftform.interfaces import Exporter, ExportJob
from driftform.plugins.seams import require_files
from driftform.testing.bodies import hollow_body
from driftform.testing.contract import PluginT_co, SeamContract
from driftform.types import Agent, Coefficients, WrittenFile
from driftform.water import Pipe, Scenario, Segment, Vector


class JobContract(SeamContract[PluginT_co]):
    """Base class of the contracts of exporters and recorders, which receive the same job; ``leak`` is its target, m."""

    leak: ClassVar[Vector] = (4.0, 0.0, -0.9)

    def export_job(self) -> ExportJob:
        """Return an agent that can be exported: a capped hollow tube, without a genome, in a pipe with a target."""
        body = hollow_body()
        agent = Agent(body, mass_properties(body), Coefficients(0.01 * np.eye(6)))
        segment = Segment(start=(0.0, 0.0, 0.0), end=(9.0, 0.0, 0.0), radius=1.0)
        scenario = Scenario(pipe=Pipe(segments=(segment,)), targets={"leak": self.leak})
        return ExportJob("agent", agent, scenario)


class ExporterContract(JobContract[Exporter[Any]]):
    """Inherit this class, and make the exporter::

    class TestMyExporter(ExporterContract):
        def plugin(self) -> MyExporter:
            return MyExporter(MyOptions())
    """

    def path(self, directory: Path) -> Path:
        """Return the path that commands pass to the exporter."""
        return directory / f"agent{self.plugin().suffix}"

    def write(self, path: Path) -> tuple[WrittenFile, ...]:
        """Export the agent to a path."""
        exporter = self.plugin()
        return require_files(exporter.write(self.export_job(), path), exporter)

    def test_every_file_exists_under_the_requested_name(self, tmp_path: Path) -> None:
        """Every reported file exists and is not empty, and its name begins with that of the path."""
        written = self.write(self.path(tmp_path))
        assert written
        for file in written:
            path = Path(file.path)
            assert file.format == self.plugin().name
            assert path.is_file() and path.stat().st_size > 0
            assert path.relative_to(tmp_path).parts[0].startswith("agent")

    def test_the_suffix_ends_the_name_of_a_file_or_of_a_folder(self) -> None:
        """A suffix is a dot and more characters for a file; for a folder it does not begin with a dot."""
        suffix = self.plugin().suffix
        assert len(suffix) > 1
        assert Path(f"agent{suffix}").name == f"agent{suffix}" and not suffix.endswith(".")

    def test_no_other_files_remain(self, tmp_path: Path) -> None:
        """Temporary files are removed in the end, and every file that is written is reported."""
        written = self.write(self.path(tmp_path))
        assert list_files(tmp_path) == sorted(Path(file.path) for file in written)

    def test_an_existing_file_is_replaced(self, tmp_path: Path) -> None:
        """A second export replaces the files of the first completely."""
        fresh, old = tmp_path / "fresh", tmp_path / "old"
        sizes = []
        for directory in (fresh, old):
            directory.mkdir()
            for _ in range(1 if directory == fresh else 2):
                for path in list_files(directory):
                    path.write_bytes(b"old " * 1_000_000)
                self.plugin().write(self.export_job(), self.path(directory))
            sizes.append(
                [(path.relative_to(directory), path.stat().st_size) for path in list_files(directory)]
            )
        assert sizes[0] == sizes[1]

    def test_an_older_folder_is_replaced_completely(self, tmp_path: Path) -> None:
        """An export to a folder removes all older files in that folder, and leaves no empty folders.

        An export to a file does not change other files in the same directory.
        """
        path = self.path(tmp_path)
        is_folder = not Path(f"agent{self.plugin().suffix}").suffix
        stale = (path if is_folder else tmp_path) / "older" / "stale.txt"
        stale.parent.mkdir(parents=True)
        stale.write_text("of an older export")
        written = self.write(path)
        assert stale.exists() != is_folder
        known = {stale, *(Path(file.path) for file in written)}
        needed = {parent for file in known for parent in file.parents} | known
        assert sorted(found for found in tmp_path.rglob("*") if found not in needed) == []

    def test_a_file_that_cannot_be_written_leaves_nothing_behind(self, tmp_path: Path) -> None:
        """The export fails if a folder is in the place of a file, or a file in the place of a folder.

        It leaves no partial file.
        """
        first = Path(self.write(self.path(tmp_path / "sound"))[0].path)
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
        """A pickled copy writes the files too."""
        copy = pickle.loads(pickle.dumps(self.plugin()))
        assert all(Path(file.path).is_file() for file in copy.write(self.export_job(), self.path(tmp_path)))


def list_files(path: Path) -> list[Path]:
    """Return the file itself, or all files of a folder, in order."""
    return [path] if path.is_file() else sorted(found for found in path.rglob("*") if found.is_file())
