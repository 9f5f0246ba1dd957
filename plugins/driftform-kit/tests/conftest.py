"""A sound export of a real agent, and ways to break it."""

import numpy as np
import pytest
import trimesh

from driftform.design.opening import open_agent
from driftform.interfaces import Printer, PrintJob
from driftform.plugins.registry import registry

WORD = "addF-tiltp-2-L-moveF-addF-tiltn-1-L-moveF-addB-tiltn-2-L-moveB-addB-tiltn-2-L-moveB-addB-tiltp-2-L-moveN"


@pytest.fixture(scope="session")
def opened():
    return open_agent(WORD, "paper")


@pytest.fixture(scope="session")
def sound(opened, tmp_path_factory):
    """The agent's hull as STL and as OpenSCAD source; not to be changed."""
    folder = tmp_path_factory.mktemp("sound")
    for name in ("stl", "scad"):
        opened.study.make_exporter(name).write(opened.export_job(), folder / f"hull.{name}")
    return folder / "hull.stl"


@pytest.fixture(scope="session")
def mesh(sound):
    """The hull's mesh, welded; not to be changed."""
    found = trimesh.load_mesh(sound)
    assert found.is_watertight
    return found


@pytest.fixture(scope="session")
def shells(mesh):
    """Its triangles: those of the outside, and those of the hollow."""
    outside, hollow = sorted(
        trimesh.graph.connected_components(mesh.face_adjacency, nodes=np.arange(len(mesh.faces))),
        key=lambda group: -np.abs(mesh.vertices[mesh.faces[group]]).max(),
    )
    return mesh.faces[outside], mesh.faces[hollow]


@pytest.fixture
def written(tmp_path):
    """Write a mesh as it is, without mending it."""

    def write(vertices, faces, name="broken.stl"):
        path = tmp_path / name
        trimesh.Trimesh(vertices, faces, process=False).export(path)
        return path

    return write


def findings(checker, job, **options):
    """What a checker finds, by what it looked at, and the part where there are several."""
    found = list(registry().create("checker", checker, options).check(job))
    named = {f"{f.check}, {f.part}" if f.part else f.check: f for f in found}
    assert len(named) == len(found)
    return named


@pytest.fixture
def check_mesh():
    """Check a file by its mesh alone."""

    def check(path, printer=Printer(), **known):  # noqa: B008
        return findings("mesh", PrintJob((path,), printer, **known))

    return check


@pytest.fixture
def ask(requires_program):
    """Ask a checker that runs a program of its own name."""

    def asked(checker, job, **options):
        requires_program(checker)
        return findings(checker, job, **options)

    return asked
