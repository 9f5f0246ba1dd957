"""What every checker must do."""

import pickle
from itertools import product
from pathlib import Path
from typing import Any

import pytest

from driftform.errors import DriftformError
from driftform.interfaces import Checker, PrintJob
from driftform.types import Finding, State

_FACES = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
"""Of a box whose corner 4 x + 2 y + z is at x, y, z; counterclockwise seen from inside."""


def write_box(path: Path, side: float = 20.0) -> Path:
    """Write a sound printable file: a cube of ``side`` mm on the bed, as an STL in text."""
    corners = [tuple(side * c for c in corner) for corner in product((0, 1), repeat=3)]
    lines = ["solid box"]
    for a, b, c, d in _FACES:
        for triangle in ((a, c, b), (a, d, c)):
            lines += ["facet normal 0 0 0", "outer loop"]
            lines += ["vertex {:g} {:g} {:g}".format(*corners[index]) for index in triangle]
            lines += ["endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid box"]) + "\n", encoding="ascii")
    return path


class CheckerContract:
    """Inherit, and say how the checker is made::

    class TestMyChecker(CheckerContract):
        def plugin(self) -> MyChecker:
            return MyChecker(MyOptions())

    A checker that runs a program is held to less where the program is not on PATH.
    """

    def plugin(self) -> Checker[Any]:
        """Return the checker to be tested."""
        raise NotImplementedError

    def find(self, *files: Path) -> list[Finding]:
        """What it finds in files that nobody knows anything of."""
        return list(self.plugin().check(PrintJob(files)))

    def test_a_sound_file_fails_nothing(self, tmp_path: Path) -> None:
        """A cube of 20 mm can be printed; there is at least one line to say so, or why nobody can."""
        found = self.find(write_box(tmp_path / "box.stl"))
        assert found
        assert [f for f in found if f.state is State.FAIL] == []

    def test_each_finding_is_a_line_of_its_own(self, tmp_path: Path) -> None:
        """It has a name and a detail, neither with a break, and nothing is looked at twice in one part."""
        found = self.find(write_box(tmp_path / "box.stl"))
        for finding in found:
            assert isinstance(finding.state, State)
            assert finding.check and finding.detail
            assert (finding.check + finding.detail + finding.part).isprintable()
        assert len({(f.check, f.part) for f in found}) == len(found)

    def test_the_same_file_gives_the_same_findings(self, tmp_path: Path) -> None:
        """The second time too, and from a checker that was sent to another process."""
        path = write_box(tmp_path / "box.stl")
        copy: Checker[Any] = pickle.loads(pickle.dumps(self.plugin()))
        assert self.find(path) == self.find(path) == list(copy.check(PrintJob((path,))))

    def test_several_files_are_one_job(self, tmp_path: Path) -> None:
        """Two cubes are as sound as one."""
        files = [write_box(tmp_path / f"{name}.stl") for name in ("one", "two")]
        assert [f for f in self.find(*files) if f.state is State.FAIL] == []

    def test_files_stay_as_they_are_and_alone(self, tmp_path: Path) -> None:
        """Whatever is written on the way is written elsewhere, and is gone in the end."""
        path = write_box(tmp_path / "box.stl")
        before = path.read_bytes()
        self.find(path)
        assert list(tmp_path.iterdir()) == [path]
        assert path.read_bytes() == before

    def test_what_is_no_mesh_passes_nothing(self, tmp_path: Path) -> None:
        """A file that cannot be read is an error or a finding, and never praised."""
        path = tmp_path / "box.stl"
        path.write_bytes(b"\x00\xff" * 100)
        try:
            found = self.find(path)
        except DriftformError as error:
            assert "box.stl" in str(error)
            return
        assert {f.state for f in found} <= {State.FAIL, State.SKIPPED}

    def test_without_its_program_it_says_so(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        """Every line is then skipped, for a reason; a checker that needs none finds what it found before."""
        path = write_box(tmp_path / "box.stl")
        before = self.find(path)
        monkeypatch.setenv("PATH", str(tmp_path / "nowhere"))
        found = self.find(path)
        if self.plugin().program:
            assert {f.state for f in found} == {State.SKIPPED}
        else:
            assert found == before
