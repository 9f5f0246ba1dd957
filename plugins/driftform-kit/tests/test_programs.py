"""Running other programs: the files that they receive, and what they print."""

import sys

import trimesh

from driftform.interfaces import PrintJob
from driftform.types import State
from driftform_kit.checks.admesh import AdmeshChecker, AdmeshOptions
from driftform_kit.reading import provide_stl, read_meshes


def test_admesh_is_understood_whatever_bytes_it_prints(sound, tmp_path, monkeypatch):
    names = ("Total disconnected facets", "Degenerate facets", "Facets reversed", "Facets added", "Edges fixed")
    report = b"Header : \xd0\xff\x80\n" + "".join(f"{name} : 0\n" for name in names).encode()
    program = tmp_path / "admesh"
    program.write_text(f"#!{sys.executable}\nimport sys\nsys.stdout.buffer.write({report!r})\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    checker = AdmeshChecker(AdmeshOptions())
    [finding] = checker.check(PrintJob((sound,)))
    assert finding.state is State.PASS


def test_the_header_of_a_copied_part_ends_with_a_nul(sound, tmp_path):
    trimesh.load_mesh(sound).export(tmp_path / "hull.ply")
    [copy] = provide_stl([tmp_path / "hull.ply"], tmp_path)
    data = copy.read_bytes()
    assert not data.startswith(b"solid")
    assert data[79] == 0
    assert [len(part.triangles) for part in read_meshes(copy)] == [len(part.triangles) for part in read_meshes(sound)]
