"""From the command line to the programs of a maker: what they read weighs what ``inspect`` says."""

import json
import re
import subprocess

import numpy as np
import pytest
import trimesh
from typer.testing import CliRunner

from driftform.cli.app import app

FIGURE_2 = "addB-tiltn-1-M-moveB-addB-tiltn-2-S-moveB-addB-tiltp-1-L-moveB"
BOTH_SIDES = "addF-tiltp-2-L-moveF-addF-tiltn-1-L-moveF-addB-tiltn-2-L-moveB-addB-tiltn-2-L-moveB-addB-tiltp-2-L-moveN"
ABS = 1050.0


def run_json(*arguments):
    result = CliRunner().invoke(app, [*arguments, "--json"])
    assert result.exit_code == 0, result.stderr
    return json.loads(result.stdout)


def output_of(*command):
    done = subprocess.run(command, capture_output=True, encoding="utf-8", errors="replace", check=True, timeout=300)
    assert "ERROR" not in done.stderr, done.stderr
    return done.stdout + done.stderr


@pytest.fixture(scope="module", params=[FIGURE_2, BOTH_SIDES, "C"], ids=["figure 2", "both sides", "bare core"])
def exported(request, tmp_path_factory):
    """The exported files by format, and the mass (kg) of the hull that ``inspect`` states; not to be changed."""
    folder = tmp_path_factory.mktemp("exported")
    hull = ("--set", "builder.made_as=hull")
    files = run_json("export", request.param, "--format", "stl,scad", "--out", str(folder), *hull)["files"]
    # The flights of ``inspect`` take the faster simulator: the hull weighs the same.
    facts = run_json("inspect", request.param, "--set", "simulator.use='native'", *hull)
    return {f["format"]: f for f in files}, facts["hull_mass"]


def test_export_and_inspect_agree_on_the_hull_s_mass(exported):
    files, mass = exported
    assert files["stl"]["mass_kg"] == pytest.approx(mass, rel=1e-6)
    assert files["stl"]["shells"] == 2


def test_admesh_finds_nothing_to_mend(exported, requires_program):
    files, mass = exported
    report = output_of(requires_program("admesh"), files["stl"]["path"])
    for fault in ("Total disconnected facets", "Degenerate facets", "Facets reversed", "Normals fixed", "Edges fixed"):
        assert re.search(rf"{fault}\s*:\s*0\b", report), report
    volume = float(re.search(r"Volume\s*:\s*([\d.]+)", report)[1])
    assert volume * 1e-9 * ABS == pytest.approx(mass, rel=1e-4)


def test_prusaslicer_reads_one_closed_solid(exported, requires_program):
    files, mass = exported
    report = output_of(requires_program("prusa-slicer"), "--info", files["stl"]["path"])
    assert "manifold = yes" in report
    assert "facets_reversed" not in report
    volume = float(re.search(r"volume = ([\d.]+)", report)[1])
    assert volume * 1e-9 * ABS == pytest.approx(mass, rel=1e-4)


@pytest.mark.parametrize("format", ["scad", "stl"])
def test_openscad_renders_the_same_mass(exported, format, tmp_path, requires_program):
    files, mass = exported
    path = files[format]["path"]
    if format == "stl":
        source = tmp_path / "reread.scad"
        source.write_text(f'import("{path}");')
        path = str(source)
    rendered = tmp_path / "rendered.stl"
    output_of(requires_program("openscad"), "-o", str(rendered), path)
    mesh = trimesh.load(rendered)
    assert np.isclose(mesh.volume * 1e-9 * ABS, mass, rtol=1e-4)
