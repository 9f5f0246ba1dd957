"""Files of hulls, read back by other programs."""

import math
from pathlib import Path

import numpy as np
import pytest
import trimesh
from prints import job_of

from driftform.agent import hull_mass
from driftform.errors import WorkFailedError
from driftform.interfaces import PrintJob
from driftform.plugins.registry import registry
from driftform.types import State
from driftform_frusta import hull
from driftform_frusta.exporters.meshes import GlbExporter, ObjExporter, PlyExporter, StlExporter
from driftform_frusta.exporters.scad import ScadExporter
from driftform_frusta.exporters.threemf import ThreeMfExporter
from driftform_frusta.hull import build_hull, hull_volume
from driftform_frusta.solid import Solid, to_manifold
from driftform_frusta.triangles import Mesh

EACH = pytest.mark.parametrize(
    "exporter", [StlExporter, ScadExporter, GlbExporter, ObjExporter, PlyExporter, ThreeMfExporter]
)


def exporter_of(kind, **options):
    return kind(kind.Options(**options))


@pytest.fixture
def write_stl(tmp_path):
    def write(body, **options):
        return exporter_of(StlExporter, **options).write(job_of(body, "hull"), tmp_path / "hull.stl")[0]

    return write


def test_a_mesh_read_back_in_single_precision_is_watertight_and_has_the_volume(body, write_stl):
    written = write_stl(body)
    mesh = trimesh.load_mesh(written.path)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume == pytest.approx(hull_volume(body) * 1e9, rel=1e-5)
    assert np.allclose(mesh.extents, written.facts["size_mm"], rtol=1e-6)
    assert mesh.bounds[0, 2] == 0


def test_facts_tell_what_the_file_holds(wavy_body, write_stl, tmp_path):
    written = write_stl(wavy_body)
    facts = written.facts
    assert written.format == "stl"
    assert written.path == str(tmp_path / "hull.stl")
    assert facts["volume_mm3"] == pytest.approx(hull_volume(wavy_body) * 1e9, rel=1e-5)
    assert facts["mass_kg"] == pytest.approx(hull_mass(wavy_body), rel=1e-5)
    assert facts["size_mm"][2] == pytest.approx(wavy_body.length * 1000, rel=1e-6)
    assert facts["size_mm"][0] == pytest.approx(wavy_body.max_diameter * 1000, rel=2e-3)
    assert facts["watertight"] is True
    assert facts["triangles"] == (Path(written.path).stat().st_size - 84) // 50


def test_the_number_of_segments_is_an_option_and_leaves_the_volume_alone(wavy_body, write_stl):
    coarse, fine = write_stl(wavy_body, segments=12).facts, write_stl(wavy_body, segments=128).facts
    assert fine["triangles"] > 10 * coarse["triangles"]
    assert fine["volume_mm3"] == pytest.approx(coarse["volume_mm3"], rel=1e-5)


TUBE = [(-0.05, 0), (-0.05, 0.02), (0.05, 0.02), (0.05, 0)]
OPEN = {
    "a tube open at both ends": (
        TUBE,
        [(-0.05, 0), (-0.05, 0.018), (0.05, 0.018), (0.05, 0)],
        "touches the outer contour at its aft end",
    ),
    "a tube open at its fore end": (
        TUBE,
        [(-0.04, 0), (-0.04, 0.018), (0.05, 0.018), (0.05, 0)],
        "touches the outer contour at its fore end",
    ),
    "a slit round the middle": (
        [(-0.05, 0), (0, 0.02), (0.05, 0)],
        [(-0.03, 0), (0, 0.02), (0.03, 0)],
        "touches the outer contour at x = 0.000000 m",
    ),
    "a cavity that leaves the outer contour": (
        TUBE,
        [(-0.04, 0), (-0.04, 0.01), (0.0, 0.03), (0.04, 0.01), (0.04, 0)],
        "mm3, its section",
    ),
    "a contour across the axis": ([(-0.05, 0), (-0.05, 0.02), (0.05, -0.02), (0.05, 0)], (), "mm3, its section"),
    "a contour across itself": ([(-0.05, 0), (0.02, 0.03), (-0.02, 0.03), (0.05, 0)], (), "mm3, its section"),
    "a contour from fore to aft": ([(0.05, 0), (0.0, 0.03), (-0.05, 0)], (), "mm3, its section"),
    "two parts that touch in a point": (
        [(-0.05, 0), (-0.02, 0.03), (0, 0), (0.02, 0.03), (0.05, 0)],
        (),
        "outer contour touches the axis at x = 0.000000 m",
    ),
    "no number": ([(-0.05, 0), (0, math.nan), (0.05, 0)], (), "outer contour has coordinates that are not finite"),
    "an outer contour off the axis": (
        [(-1, 0), (-1, 1), (1, 1)],
        (),
        "outer contour does not begin and end on the axis",
    ),
    "a cavity off the axis": (
        [(-1, 0), (0, 1), (1, 0)],
        [(-0.5, 0.1), (0, 0.2), (0.5, 0)],
        "cavity does not begin and end",
    ),
}


@EACH
@pytest.mark.parametrize("kind", OPEN)
def test_a_body_without_a_closed_solid_is_refused_and_nothing_written(exporter, kind, make_body, tmp_path):
    outer, cavity, why = OPEN[kind]
    with pytest.raises(WorkFailedError, match=why):
        exporter_of(exporter).write(job_of(make_body(outer, cavity), "hull"), tmp_path / "hull")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("x", "why"), [((-1, 1), "has 2 points"), ((-1, 0, 1), "never leaves the axis")])
def test_a_contour_that_encloses_nothing_is_refused(x, why, make_body):
    with pytest.raises(WorkFailedError, match=f"outer contour {why}"):
        build_hull(make_body([(each, 0) for each in x]))


@EACH
def test_a_solid_that_is_not_what_was_simulated_is_refused(exporter, wavy_body, tmp_path, monkeypatch):
    monkeypatch.setattr(hull, "hull_volume", lambda body: hull_volume(body) * (1 + 1e-5))
    with pytest.raises(WorkFailedError, match="mm3, its section"):
        exporter_of(exporter).write(job_of(wavy_body, "hull"), tmp_path / "hull")
    assert list(tmp_path.iterdir()) == []


@EACH
def test_a_solid_in_two_pieces_is_refused_though_its_volume_is_right(exporter, wavy_body, tmp_path, monkeypatch):
    def cut(tree, segments):
        upper, lower = to_manifold(tree, segments).split_by_plane((0, 0, 1), 100)
        return Solid.from_manifold(upper.translate((0, 0, 1)) + lower)

    monkeypatch.setattr(hull, "to_solid", cut)
    with pytest.raises(WorkFailedError, match="falls into 2 pieces"):
        exporter_of(exporter).write(job_of(wavy_body, "hull"), tmp_path / "hull")


def test_the_printed_frame_is_in_mm_with_the_fore_end_up_and_the_lowest_point_at_zero(make_body):
    cone = make_body([(-0.02, 0), (-0.02, 0.03), (0.05, 0)])
    solid = to_manifold(build_hull(cone))
    bounds = solid.bounding_box()
    assert bounds[2] == 0
    assert bounds[5] == pytest.approx(70, rel=1e-9)
    assert bounds[3] == pytest.approx(30, rel=2e-3)
    # A cone's centroid is a quarter up from its base, which is the aft end here.
    assert solid.trim_by_plane((0, 0, 1), 35).volume() == pytest.approx(solid.volume() / 8, rel=1e-6)


def lose_one(mesh):
    return Mesh(mesh.vertices, mesh.triangles[1:])


def turn_cavity(mesh):
    vertices, triangles = mesh.vertices, mesh.triangles
    welded = trimesh.Trimesh(vertices, triangles, process=False)
    labels = trimesh.graph.connected_component_labels(welded.face_adjacency, node_count=len(triangles))
    inner = labels == labels[np.argmin(np.linalg.norm(vertices[triangles[:, 0], :2], axis=1))]
    turned = Mesh(vertices, np.where(inner[:, None], triangles[:, ::-1], triangles))
    assert turned.is_closed
    return turned


@pytest.mark.parametrize(("spoil", "why"), [(lose_one, "does not stay closed"), (turn_cavity, "single precision")])
def test_a_mesh_that_single_precision_spoils_is_refused(spoil, why, wavy_body, write_stl, monkeypatch):
    merge_vertices = Mesh.merge_vertices
    monkeypatch.setattr(Mesh, "merge_vertices", lambda mesh: spoil(merge_vertices(mesh)))
    with pytest.raises(WorkFailedError, match=why):
        write_stl(wavy_body)


def test_rings_that_fall_together_in_single_precision_leave_the_mesh_closed(make_body, write_stl):
    """Steps of 1e-5 mm at 250 mm of height are less than single precision tells apart."""
    step = 1e-8
    xs = [0.25, 0.25 + step, 0.25 + 2 * step, 0.25 + 3 * step]
    outer = [(0, 0), (0, 0.02), *((x, 0.02 + 1e-4 * (i % 2)) for i, x in enumerate(xs)), (xs[-1], 0)]
    written = write_stl(make_body(outer))
    mesh = trimesh.load_mesh(written.path)
    assert mesh.is_watertight
    assert len(mesh.faces) == written.facts["triangles"]


@pytest.mark.parametrize("program", ["admesh", "prusa-slicer"])
def test_programs_of_a_maker_find_nothing_to_mend(program, body, write_stl, requires_program):
    requires_program(program)
    findings = registry().create("checker", program, {}).check(PrintJob((Path(write_stl(body).path),)))
    # The next finding of the slicer is on its g-code.
    assert next(iter(findings)).state is State.PASS
