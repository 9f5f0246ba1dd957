"""Contract of exporters, and what it shares with that of recorders: which files are written, and which are left."""

from pathlib import Path
from typing import Any, ClassVar

import pytest

from driftform.errors import DriftformError
from driftform.interfaces import Exporter, ExportJob
from driftform.plugins.seams import require_files
from driftform.testing.agents import hollow_agent, straight_pipe
from driftform.testing.contract import PluginT_co, SeamContract
from driftform.types import WrittenFile
from driftform.water import Scenario, Vector


class JobContract(SeamContract[PluginT_co]):
    """Base class of the contracts of exporters and recorders, which receive the same job; ``leak`` is its target, m."""

    leak: ClassVar[Vector] = (4.0, 0.0, -0.9)

    def export_job(self) -> ExportJob:
        """Return an agent that can be exported: a capped hollow tube, without a genome, in a pipe with a target."""
        return ExportJob("agent", hollow_agent(), Scenario(pipe=straight_pipe(9.0, 1.0), targets={"leak": self.leak}))

    def path(self, directory: Path) -> Path:
        """Return the path that commands pass to the plugin."""
        plugin: Any = self.plugin()
        return directory / f"agent{plugin.suffix}"

    def write_by(self, plugin: Any, path: Path) -> Any:
        """Call the method ``write`` of a plugin."""
        return plugin.write(self.export_job(), path)

    def write(self, path: Path) -> tuple[WrittenFile, ...]:
        """Write the files to a path."""
        plugin: Any = self.plugin()
        return require_files(self.write_by(plugin, path), plugin)

    def test_only_the_requested_files_are_written(self, tmp_path: Path) -> None:
        """Every reported file exists, is not empty and has the name of the path, and every file that is written is reported."""
        written = self.write(self.path(tmp_path))
        assert written
        for file in written:
            path = Path(file.path)
            assert file.format == getattr(self.plugin(), "name", "")
            assert path.is_file() and path.stat().st_size > 0
            assert path.relative_to(tmp_path).parts[0].startswith("agent")
        assert list_files(tmp_path) == sorted(Path(file.path) for file in written)

    def test_the_same_job_gives_the_same_content(self, tmp_path: Path) -> None:
        """The content is the same from a plugin that was sent to another process, and when files are replaced."""
        contents = []
        for name in ("fresh", "old", "copy"):
            folder = tmp_path / name
            folder.mkdir()
            self.write_by(self.copy() if name == "copy" else self.plugin(), self.path(folder))
            if name == "old":
                for path in list_files(folder):
                    path.write_bytes(b"old " * 1_000_000)
                self.write(self.path(folder))
            contents.append({path.relative_to(folder): path.read_bytes() for path in list_files(folder)})
        assert contents[0].keys() == contents[1].keys() == contents[2].keys()
        assert contents[0] == contents[1] == contents[2], "the content differs"

    def test_a_failed_write_leaves_nothing_behind(self, tmp_path: Path) -> None:
        """If a folder is in the place of a file, or a file in that of a folder, writing fails and leaves no partial file."""
        first = Path(self.write(self.path(tmp_path / "sound"))[0].path)
        part = first.relative_to(tmp_path / "sound").parts[0]
        blocked = tmp_path / "blocked" / part
        blocked.parent.mkdir()
        if first == tmp_path / "sound" / part:
            blocked.mkdir()
        else:
            blocked.write_text("in the way")
        with pytest.raises((DriftformError, OSError)):
            self.write(self.path(blocked.parent))
        assert list(blocked.parent.iterdir()) == [blocked]
        assert blocked.is_file() or not list(blocked.iterdir())


class ExporterContract(JobContract[Exporter[Any]]):
    """The contract of exporters."""

    def test_the_suffix_ends_the_name_of_a_file_or_of_a_folder(self) -> None:
        """A suffix is a dot and more characters for a file; for a folder it does not begin with a dot."""
        suffix = self.plugin().suffix
        assert len(suffix) > 1
        assert Path(f"agent{suffix}").name == f"agent{suffix}" and not suffix.endswith(".")

    def test_an_older_folder_is_replaced_completely(self, tmp_path: Path) -> None:
        """An export to a folder removes all older files in that folder, and leaves no empty folders.

        An export to a file does not change other files in the same directory.
        """
        path = self.path(tmp_path)
        is_folder = not path.suffix
        stale = (path if is_folder else tmp_path) / "older" / "stale.txt"
        stale.parent.mkdir(parents=True)
        stale.write_text("of an older export")
        written = self.write(path)
        assert stale.exists() != is_folder
        known = {stale, *(Path(file.path) for file in written)}
        needed = {parent for file in known for parent in file.parents} | known
        assert sorted(found for found in tmp_path.rglob("*") if found not in needed) == []


def list_files(path: Path) -> list[Path]:
    """Return the file itself, or all files of a folder, in order."""
    return [path] if path.is_file() else sorted(found for found in path.rglob("*") if found.is_file())
