"""``export``: the formats that are asked for."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import trimesh

FIGURE_2 = "addB-tiltn-1-M-moveB-addB-tiltn-2-S-moveB-addB-tiltp-1-L-moveB"
"""The word of the paper's Figure 2."""

Call = Callable[..., Any]


def test_export_writes_the_formats_it_names(call: Call) -> None:
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
