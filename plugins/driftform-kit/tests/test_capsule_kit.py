"""A kit around a capsule of 60 x 25 mm: what holds it, the way in, its sheet, and the slicer."""

from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest
import trimesh
from manifold3d import Manifold, Mesh64
from prints import job_of

from driftform.errors import WorkFailedError
from driftform.interfaces import PrintJob
from driftform.plugins.registry import registry
from driftform.testing.builder import MORPHOLOGIES
from driftform.types import State
from driftform_frusta.builder import FrustaBuilder, FrustaOptions
from driftform_frusta.exporters.scad import ScadExporter
from driftform_frusta.exporters.threemf import ThreeMfExporter
from driftform_frusta.kit_options import PartOptions
from driftform_frusta.parts import make_parts
from driftform_kit.cutting.accounting import kit_mass, weigh_kit
from driftform_kit.cutting.pieces import make_kit
from driftform_kit.sheet.contents import plan_sheet
from driftform_kit.sheet.drawing import draw_pages
from driftform_kit.trim import weigh_print

GAP = 0.2
CAPSULES = {
    "flat": [(0, 0), (0, 0.0125), (0.06, 0.0125), (0.06, 0)],
    "blunt": [(0, 0), (0, 0.008), (0.006, 0.0125), (0.04, 0.0125), (0.06, 0.004), (0.06, 0)],
}
KINDS = ["no module", "all narrowing", "all widening", "zigzag", "39 random modules (0)"]


def build(capsule, kind):
    options = {"core_profile": CAPSULES[capsule], "core_radius": 0.0125, "core_mass": 0.025, "core_cog": 0.034}
    return FrustaBuilder(FrustaOptions(**options)).build(MORPHOLOGIES[kind]())


def solid_core(body, capsule):
    """The capsule in the frame of the parts, from its own profile, mm."""
    profile = 1000 * np.array(CAPSULES[capsule])[::-1]
    z = 1000 * (body.core.ends[1] - body.outer[0, 0]) - profile[:, 0]
    mesh = trimesh.creation.revolve(np.column_stack((profile[:, 1], z)), sections=256)
    mesh.merge_vertices()
    mesh.update_faces(mesh.nondegenerate_faces())
    core = Manifold(Mesh64(mesh.vertices, mesh.faces.astype(np.uint64)))
    # A polygon of 256 corners lacks 1e-4 of the area.
    assert core.volume() == pytest.approx(1e9 * body.core.volume, rel=2e-4)
    return core


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("capsule", CAPSULES)
def test_the_parts_enclose_the_capsule_with_the_clearance_and_let_it_in(capsule, kind):
    body = build(capsule, kind)
    kit = make_kit(body, PartOptions(kit=True))
    parts = make_parts(body, PartOptions(kit=True, segments=256))
    solids = [part.solid.to_manifold() for part in parts]
    core = solid_core(body, capsule)
    # Radii of 12.5 mm are within 1 um of the circle, and contours within as much of the offset.
    assert min(core.min_gap(solid, 1.0) for solid in solids) == pytest.approx(GAP, abs=0.005)
    # It cannot move along the axis by more than its play.
    for side in (1, -1):
        moved = core.translate((0.0, 0.0, side * 0.6))
        assert sum((moved ^ solid).volume() for solid in solids) > 0.01
    # The shell that takes it lets it in by its mouth, and the other one goes over it.
    inner = kit.joints.index(kit.core_joint)
    for shell, way in ((inner, 1.0), (inner + 1, -1.0)):
        for far in np.linspace(0.0, 70.0, 15):
            assert (core.translate((0.0, 0.0, way * far)) ^ solids[shell]).volume() < 1e-6
    # What is accounted for is what is printed.
    printed = 1e-9 * 1050 * sum(solid.volume() for solid in solids) + 0.025
    assert kit_mass(body, PartOptions(kit=True)).mass == pytest.approx(printed, rel=1e-5)


def test_a_capsule_in_a_hull_that_is_too_small_is_refused():
    body = build("flat", "no module")
    bigger = body.__class__(**{**vars(body), "core": build("blunt", "no module").core})
    shorter = body.__class__(**{**vars(bigger), "core": body.core, "cavity": body.cavity * (0.9, 1.0)})
    with pytest.raises(WorkFailedError, match="core does not fit into the hull's cavity"):
        make_kit(shorter, PartOptions(kit=True))


def test_the_sheet_names_the_capsule_and_draws_its_outline():
    body = build("blunt", "zigzag")
    sheet = plan_sheet(job_of(body), PartOptions(kit=True))
    assert sheet.core.replace("\N{NO-BREAK SPACE}", " ") == "capsule of 60 x 25 mm, 25.00 g"
    assert any("Its nose points to the fore end." in step for step in sheet.steps)
    first, _ = draw_pages(sheet)
    marks = [e for e in ET.fromstring(first).iter() if e.get("class") == "core"]
    assert [e.tag.rpartition("}")[2] for e in marks] == ["path"]


def test_a_kit_of_nothing_but_its_parts_balances_with_the_capsule_in_its_place():
    body = build("blunt", "all fore")
    job = job_of(body)
    options = PartOptions(kit=True)
    whole = kit_mass(body, options)
    weight = weigh_kit(job.agent, make_kit(body, options), options)
    mass, moment = weight.closed(1.0)
    assert (mass, moment) == (pytest.approx(whole.mass), pytest.approx(whole.mass * whole.cog[0]))
    # Half the parts, and the capsule where it is.
    from driftform_kit.kit import report_kit

    half = weigh_print(job.agent, 0.025 + weight.mass / 2, None, report_kit(body, options))
    assert half.mass * half.cog == pytest.approx(0.025 * body.core.cog + weight.moment / 2)


@pytest.mark.parametrize("kit", [False, True])
def test_openscad_shows_the_capsule(kit, tmp_path):
    body = build("blunt", "zigzag")
    ScadExporter(PartOptions(kit=kit)).write(job_of(body), tmp_path / "agent.scad")
    source = (tmp_path / "agent.scad").read_text()
    assert "core_outline = [[0, " in source


@pytest.mark.peers
def test_the_slicer_takes_the_kit_of_a_capsule(requires_program, tmp_path):
    requires_program("prusa-slicer")
    body = build("flat", "39 random modules (0)")
    files = ThreeMfExporter(PartOptions(kit=True)).write(job_of(body), tmp_path / "agent.3mf")
    plates = tuple(Path(file.path) for file in files if file.path.endswith(".3mf"))
    found = list(registry().create("checker", "prusa-slicer", {}).check(PrintJob(plates)))
    assert found and all(finding.state is State.PASS for finding in found), found
