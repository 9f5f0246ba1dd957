"""What every exporter must do."""

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from driftform.errors import DriftformError
from driftform.geometry import mass_properties
from driftform.interfaces import Exporter
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

    def agent(self) -> Agent:
        """Return an agent that can be exported: a capped hollow tube, without a genome."""
        body = hollow_body()
        return Agent(body, mass_properties(body), Coefficients(0.01 * np.eye(6)))

    def test_the_file_is_where_it_was_asked_for(self, tmp_path: Path) -> None:
        """Its path and format are told, and it is not empty."""
        exporter = self.plugin()
        path = tmp_path / f"agent{exporter.suffix}"
        written = exporter.write(self.agent(), path)
        assert Path(written.path) == path
        assert written.format == exporter.name
        assert path.is_file() and path.stat().st_size > 0

    def test_the_suffix_ends_a_file_name(self) -> None:
        """A dot, and something after it."""
        suffix = self.plugin().suffix
        assert suffix.startswith(".") and len(suffix) > 1
        assert Path(f"agent{suffix}").name.endswith(suffix) and not suffix.endswith(".")

    def test_nothing_else_is_left_beside_the_file(self, tmp_path: Path) -> None:
        """What is written on the way to a whole file is gone when it is there."""
        path = tmp_path / f"agent{self.plugin().suffix}"
        self.plugin().write(self.agent(), path)
        assert list(tmp_path.iterdir()) == [path]

    def test_a_file_that_is_there_already_is_replaced(self, tmp_path: Path) -> None:
        """A second export leaves what a first one would have left, and nothing of the old file."""
        suffix = self.plugin().suffix
        fresh, old = tmp_path / "fresh" / f"agent{suffix}", tmp_path / "old" / f"agent{suffix}"
        for path in (fresh, old):
            path.parent.mkdir()
        old.write_bytes(b"old " * 1_000_000)
        self.plugin().write(self.agent(), fresh)
        self.plugin().write(self.agent(), old)
        assert old.stat().st_size == fresh.stat().st_size
        assert list(old.parent.iterdir()) == [old]

    def test_a_file_that_cannot_be_written_leaves_nothing_behind(self, tmp_path: Path) -> None:
        """Where a folder stands in its place the export fails, and no half of a file remains."""
        path = tmp_path / f"agent{self.plugin().suffix}"
        path.mkdir()
        with pytest.raises((DriftformError, OSError)):
            self.plugin().write(self.agent(), path)
        assert list(tmp_path.iterdir()) == [path]
        assert not list(path.iterdir())

    def test_it_can_be_sent_to_a_worker_process(self, tmp_path: Path) -> None:
        """A pickled copy writes too."""
        path = tmp_path / f"agent{self.plugin().suffix}"
        pickle.loads(pickle.dumps(self.plugin())).write(self.agent(), path)
        assert path.is_file()
