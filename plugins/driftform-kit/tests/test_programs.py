"""Running other programs: the files that they receive, and what they print."""

import sys
from pathlib import Path

import pytest
import trimesh

from driftform.errors import WorkFailedError
from driftform.interfaces import Checker, PrintJob
from driftform.types import State
from driftform_kit.checks.admesh import AdmeshChecker, AdmeshOptions
from driftform_kit.checks.programs import explain_missing, last_line, run_program
from driftform_kit.reading import provide_stl, read_meshes


def prints(data: bytes) -> list[str]:
    """A command that prints bytes to both of its streams."""
    code = f"import sys; sys.stdout.buffer.write({data!r}); sys.stdout.flush(); sys.stderr.buffer.write({data!r})"
    return [sys.executable, "-c", code]


def test_output_that_is_not_utf_8_is_read_all_the_same(tmp_path: Path) -> None:
    printed = run_program(prints(b"Header : \xd0\xff\x80 end\n"), tmp_path, 60)
    assert printed.count("end\n") == 2
    assert last_line(printed).startswith("Header : ")


def test_a_program_that_takes_too_long_or_does_not_exist_is_a_failure(tmp_path: Path) -> None:
    with pytest.raises(WorkFailedError, match="did not end within"):
        run_program([sys.executable, "-c", "import time; time.sleep(60)"], tmp_path, 0.1)
    with pytest.raises(WorkFailedError, match="cannot be run"):
        run_program([str(tmp_path / "no-program")], tmp_path, 60)
    assert explain_missing("no-such-program") == "no-such-program is not on PATH"


def test_admesh_is_understood_whatever_bytes_it_prints(
    sound: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    names = ("Total disconnected facets", "Degenerate facets", "Facets reversed", "Facets added", "Edges fixed")
    report = b"Header : \xd0\xff\x80\n" + "".join(f"{name} : 0\n" for name in names).encode()
    program = tmp_path / "admesh"
    program.write_text(f"#!{sys.executable}\nimport sys\nsys.stdout.buffer.write({report!r})\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    checker: Checker[AdmeshOptions] = AdmeshChecker(AdmeshOptions())
    [finding] = checker.check(PrintJob((sound,)))
    assert finding.state is State.PASS


def test_the_header_of_a_copied_part_ends_with_a_nul(sound: Path, tmp_path: Path) -> None:
    trimesh.load_mesh(sound).export(tmp_path / "hull.ply")
    [copy] = provide_stl([tmp_path / "hull.ply"], tmp_path)
    data = copy.read_bytes()
    assert not data.startswith(b"solid")
    assert data[79] == 0
    assert [len(part.triangles) for part in read_meshes(copy)] == [len(part.triangles) for part in read_meshes(sound)]
