"""``export``: the formats that are asked for."""

import json
from pathlib import Path

import pytest
import trimesh

pytestmark = pytest.mark.usefixtures("ideal_water")

FIGURE_2 = "addB-tiltn-1-M-moveB-addB-tiltn-2-S-moveB-addB-tiltp-1-L-moveB"
"""The word of the paper's Figure 2."""


def test_export_writes_the_formats_it_names(call):
    result = call("export", FIGURE_2, "--format", "stl, scad", "--out", "parts", "--json")
    assert result.exit_code == 0, result.stderr
    files = json.loads(result.stdout)["files"]
    assert [file["format"] for file in files] == ["stl", "scad"]
    facts = json.loads(call("inspect", FIGURE_2, "--json").stdout)
    mesh = trimesh.load_mesh(files[0]["path"])
    assert mesh.is_watertight
    assert mesh.extents[2] == pytest.approx(1e3 * facts["length"], rel=1e-5)
    for file in files:
        assert file["mass_kg"] == pytest.approx(facts["hull_mass"], rel=1e-6)
    assert "rotate_extrude" in Path(files[1]["path"]).read_text()


def test_a_hull_that_was_simulated_as_a_kit_is_exported_with_a_note(call):
    word, kit = "addB-tiltn-1-M-moveB-addB-tiltp-1-L-moveB", ("--set", "builder.made_as=kit")
    result = call("export", word, "--out", "out", *kit)
    assert result.exit_code == 0
    weighed = json.loads(call("inspect", word, "--json", "--set", "simulator.use=native", *kit).stdout)["hull_mass"]
    assert f"whose parts weigh {1000 * weighed:.2f} g: write them with --kit" in result.stderr
    for options in ((), (*kit, "--kit")):
        assert "note" not in call("export", word, "--out", "out", *options).stderr
