"""The page on robotics, from the profile of REMUS 100 to a model for Gazebo."""

import csv
import re
import shlex
import shutil
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from solids import remus_body
from typer.testing import CliRunner

from driftform.cli.app import app

DOCS = Path(__file__).parents[3] / "docs"


def test_the_profile_of_the_docs_is_the_hull_of_remus():
    with (DOCS / "bodies" / "remus-100.csv").open(encoding="utf-8") as file:
        rows = [(float(row["x_mm"]), float(row["r_mm"])) for row in csv.DictReader(file)]
    x, r = np.array(rows).T / 1e3
    hull = remus_body(2000).outer[-2:0:-1]
    assert r == pytest.approx(np.interp(x, hull[0, 0] - hull[:, 0], hull[:, 1]), abs=1e-6)
    assert x[0] == 0 and x[-1] == pytest.approx(0.191 + 0.654 + 0.541 - 0.0165 - 0.0368)


def test_the_commands_of_the_page_make_a_model_of_remus(tmp_path, monkeypatch):
    page = (DOCS / "robotics.md").read_text(encoding="utf-8")
    commands = re.findall(r"^\$ driftform (.*remus.*)$", page, re.MULTILINE)
    assert [command.split()[0] for command in commands] == ["body", "inspect", "export"]
    for path in (DOCS / "bodies").iterdir():
        shutil.copy(path, tmp_path)
    monkeypatch.chdir(tmp_path)
    printed = []
    for command in commands:
        result = CliRunner().invoke(app, shlex.split(command))
        assert result.exit_code == 0, result.stderr
        printed.append(result.stdout)
    block = ET.fromstring(printed[1])
    world = ET.parse(tmp_path / "models" / "remus-sdf" / "world.sdf").getroot()
    model = world.find(".//model[@name='remus']")
    for tag in ("xx", "yy", "zz", "qq", "yr"):
        assert block.findtext(f".//fluid_added_mass/{tag}") == model.findtext(f".//fluid_added_mass/{tag}")

    def read(tag):
        return float(block.findtext(f"link/inertial/{tag}", ""))

    assert read("mass") == 30.48 and read("inertia/ixx") == 0.177 and read("inertia/iyy") == 3.45
    # Capytaine's added mass of the bare hull (docs/validation.md); the fins have the rest of what is published, 35.5 kg.
    assert read("fluid_added_mass/xx") == pytest.approx(1.56, rel=0.01)
    assert f"{read('fluid_added_mass/yy'):.0f} kg of water move" in page
    assert f"fins add {35.5 - read('fluid_added_mass/yy'):.1f} kg" in page
    assert (tmp_path / "models" / "remus-sdf" / "drift.sdf").is_file()
    assert (tmp_path / "models" / "remus-uuv" / "launch" / "start.launch").is_file()
