"""Contract of checkers."""

from itertools import product
from pathlib import Path
from typing import Any

import pytest

from driftform.errors import DriftformError
from driftform.interfaces import Checker, PrintJob
from driftform.plugins.seams import require_findings
from driftform.testing.contract import SeamContract
from driftform.types import Finding, State

_FACES = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
"""Faces of a box whose corner 4 x + 2 y + z is at x, y, z; counterclockwise seen from inside."""


def write_box(path: Path, side: float = 20.0) -> Path:
    """Write a sound printable file: a cube of ``side`` mm on the bed, as a text STL; return its path."""
    corners = [tuple(side * c for c in corner) for corner in product((0, 1), repeat=3)]
    lines = ["solid box"]
    for a, b, c, d in _FACES:
        for triangle in ((a, c, b), (a, d, c)):
            lines += ["facet normal 0 0 0", "outer loop"]
            lines += ["vertex {:g} {:g} {:g}".format(*corners[index]) for index in triangle]
            lines += ["endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid box"]) + "\n", encoding="ascii")
    return path


class CheckerContract(SeamContract[Checker[Any]]):
    """The contract of checkers.

    A checker that runs a program may skip its checks if the program is not on PATH.
    """

    def find(self, *files: Path) -> list[Finding]:
        """Return the findings in files of unknown origin."""
        checker = self.plugin()
        return list(require_findings(checker.check(PrintJob(files)), checker))

    def test_a_sound_file_does_not_fail(self, tmp_path: Path) -> None:
        """A cube of 20 mm can be printed; at least one finding says so, or why the check was skipped, each in one line."""
        files = [write_box(tmp_path / f"{name}.stl") for name in ("one", "two")]
        for found in (self.find(files[0]), self.find(*files)):
            assert found
            assert [f for f in found if f.state is State.FAIL] == []
            assert all(f.check and f.detail and (f.check + f.detail + f.part).isprintable() for f in found)
            assert len({(f.check, f.part) for f in found}) == len(found), "a check of a part has two findings"

    def test_the_same_file_gives_the_same_findings_and_is_not_changed(self, tmp_path: Path) -> None:
        """Also from a checker that was sent to another process; temporary files are written elsewhere."""
        path = write_box(tmp_path / "box.stl")
        before = path.read_bytes()
        assert self.find(path) == self.find(path) == list(self.copy().check(PrintJob((path,))))
        assert list(tmp_path.iterdir()) == [path] and path.read_bytes() == before

    def test_a_file_that_is_not_a_mesh_does_not_pass(self, tmp_path: Path) -> None:
        """A file that cannot be read gives an error with its name, or findings that fail or are skipped; it never passes."""
        path = tmp_path / "box.stl"
        path.write_bytes(b"\x00\xff" * 100)
        try:
            found = self.find(path)
        except DriftformError as error:
            assert "box.stl" in str(error)
            return
        assert {f.state for f in found} <= {State.FAIL, State.SKIPPED}

    def test_a_missing_program_is_reported(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        """Without its program on PATH every check is skipped; a checker that runs no program finds the same as before."""
        path = write_box(tmp_path / "box.stl")
        before = self.find(path)
        monkeypatch.setenv("PATH", str(tmp_path / "nowhere"))
        found = self.find(path)
        assert {f.state for f in found} == {State.SKIPPED} if self.plugin().program else found == before
