"""The fit coupon: its clearances measured on the mesh, what slicers make of it, and the command that writes it."""

import json
import zipfile
from functools import cache

import numpy as np
import pytest
from manifold3d import Manifold, Mesh64
from prints import chain_body

from driftform.interfaces import Printer, PrintJob
from driftform.types import State
from driftform_frusta.kit_options import PartOptions
from driftform_frusta.parts import make_parts
from driftform_kit.cutting.coupon import CLEARANCES
from driftform_kit.reading import read_meshes


def radii_at(options, height, core="steel-20mm"):
    """Inner and outer radius of each cell of the coupon at a height (mm), the loose ring last; sections of the mesh alone."""
    mesh = make_mesh(options, core)
    solid = Manifold(Mesh64(vert_properties=mesh.vertices, tri_verts=mesh.faces.astype(np.uint64)))
    sections = solid.slice(height).to_polygons()
    cells = {}
    for path in sections:
        middle = (path.min(axis=0) + path.max(axis=0)) / 2
        radius = float(np.hypot(*(path - middle).T).max())
        cells.setdefault(tuple(np.round(middle, 1).tolist()), []).append(radius)
    return cells


@cache
def make_mesh(options, core="steel-20mm"):
    import trimesh

    [part] = make_parts(chain_body("ssssss", "ssssss", core=core), options)
    solid = part.on_bed()
    return trimesh.Trimesh(solid.vertices, solid.triangles, process=False)


@pytest.mark.parametrize(("core", "radius"), [("steel-20mm", 10.0), ("glass-30mm", 15.0)])
def test_each_plug_has_its_clearance_to_the_loose_ring_and_to_the_core(core, radius):
    options = PartOptions(coupon=True, segments=128)
    # Between the groove and the chamfer of the tip: only plugs are there.
    rim = make_mesh(options, core).bounds[1, 2] - 6.0
    plugs = sorted(radii_at(options, rim + 5.3, core).items(), key=lambda item: (item[0][1], item[0][0]))
    ring = min(min(found) for found in radii_at(options, 5.0, core).values() if min(found) > radius + 1.5)
    assert len(plugs) == len(CLEARANCES)
    for (_, (inner, outer)), gap in zip([(at, sorted(r)) for at, r in plugs], CLEARANCES, strict=True):
        assert ring - outer == pytest.approx(gap, abs=0.01)
        assert inner - radius == pytest.approx(gap, abs=0.01)


def test_the_groove_is_as_deep_as_the_standard_has_it_at_every_clearance():
    options = PartOptions(coupon=True, segments=128, o_ring=0.00262, lap=0.009)
    rim = make_mesh(options).bounds[1, 2] - 9.0
    ring = min(min(found) for found in radii_at(options, 5.0).values() if min(found) > 13)
    depths = [radii_at(options, rim + height) for height in np.arange(2.0, 7.0, 0.5).tolist()]
    for place in depths[0]:
        bottom = min(max(found[place]) for found in depths)
        # Gland depth of .080 to .086 in for a cord of .103 in.
        assert 0.080 * 25.4 < ring - bottom < 0.086 * 25.4


def test_the_core_comes_to_rest_on_each_seat():
    mesh = make_mesh(PartOptions(coupon=True))
    rim = mesh.bounds[1, 2] - 6.0
    for place in radii_at(PartOptions(coupon=True), rim + 5.3):
        around = mesh.vertices - (*place, rim)
        inside = around[np.hypot(around[:, 0], around[:, 1]) < 9.0]
        # The nearest of the cone is a clearance from a core whose middle is at the rim.
        assert 0.0 < np.linalg.norm(inside, axis=1).min() - 10.0 < 0.35


def test_the_command_writes_one_small_file_without_an_agent(done, tmp_path):
    found = done("export", "--coupon", "--format", "stl,3mf", "--out", str(tmp_path), "--json")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["coupon.3mf", "coupon.stl"]
    assert {file["coupon"]["core_mm"] for file in found["files"]} == {20.0}
    [mesh] = read_meshes(tmp_path / "coupon.stl")
    assert np.ptp(mesh.bounds, axis=0).max() < 100 and mesh.volume < 22_000
    with zipfile.ZipFile(tmp_path / "coupon.3mf") as archive:
        assert not any(name.endswith(("kit.json", "agent.json")) for name in archive.namelist())
    text = done("export", "--coupon", "--set", "builder.core=stainless-25mm", "--out", str(tmp_path))
    assert "core_mm: 25" in text and "--option clearance=" in text and "assembly" not in text


def test_a_format_without_parts_and_a_missing_agent_are_one_line(refused):
    for words, line in (
        (("--coupon", "--format", "svg"), "exporter 'svg' has no option 'coupon'"),
        ((), "AGENT is missing: name an agent, or write the fit coupon with --coupon"),
    ):
        assert line in refused("export", *words, "--out", "new")


def test_a_file_holds_what_a_printer_needs_of_kits(done, refused, tmp_path):
    printer = tmp_path / "printer.toml"
    printer.write_text("nozzle = 0.0005\nbed = [0.22, 0.2, 0.25]\nclearance = 0.00015\n", encoding="utf-8")
    arguments = ("addF-tiltp-2-L-moveF", "--kit", "--format", "3mf", "--out", str(tmp_path))
    done("export", *arguments, "--option", str(printer))
    with zipfile.ZipFile(next(tmp_path.glob("*.3mf"))) as archive:
        options = json.loads(archive.read("Metadata/kit.json"))
    assert (options["nozzle"], options["clearance"], options["bed"]) == (0.0005, 0.00015, [0.22, 0.2, 0.25])
    sheet = next(tmp_path.glob("*-assembly-2.svg")).read_text(encoding="utf-8")
    assert "--option clearance=0.00015" in sheet
    printer.write_text("clearance = 0,15\n", encoding="utf-8")
    for path, reason in ((printer, "printer.toml:1: is not valid TOML"), (tmp_path / "none.toml", "none.toml")):
        assert reason in refused("export", *arguments, "--option", str(path))


@pytest.mark.peers
@pytest.mark.parametrize("joint", ["bayonet", "thread"])
def test_prusa_slicer_slices_the_coupon(call, ask, tmp_path, joint):
    call("export", "--coupon", "--option", f"joint={joint}", "--out", str(tmp_path))
    found = ask("prusa-slicer", PrintJob((tmp_path / "coupon.stl",), Printer()), infill=1.0)
    assert {name: finding.state for name, finding in found.items()} == {
        "prusa-slicer mesh": State.PASS,
        "prusa-slicer g-code": State.PASS,
    }
