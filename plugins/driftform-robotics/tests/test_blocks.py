"""The command line for folders, and ``driftform inspect --block``: what describes the water, equal to that of the files."""

import tomllib
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from driftform.cli.app import app
from driftform_robotics.models.fossen import FossenExporter, WaterOptions

WORD = "addB-tiltn-1-M-moveB-addB-tiltn-2-S-moveB-addB-tiltp-1-L-moveB"


def describe(element):
    """Tag, attributes, text and children; the link of the UUV simulator has a namespace in its file only."""
    own = {key: value.replace("$(arg namespace)/", "") for key, value in element.attrib.items()}
    text = " ".join((element.text or "").split())
    return element.tag, own, text, [describe(child) for child in element]


@pytest.mark.parametrize(
    ("format", "file", "tags", "options"),
    [
        ("sdf", "world.sdf", ("mass", "inertia", "fluid_added_mass", "plugin"), {}),
        ("sdf", "world.sdf", ("mass", "inertia", "plugin"), {"gazebo": "fortress"}),
        ("sdf", "drift.sdf", ("mass", "inertia", "fluid_added_mass"), {}),
        ("uuv", "urdf/agent.xacro", ("fluid_density", "hydrodynamic_model", "link"), {}),
        ("urdf", "agent.urdf", ("inertial",), {}),
    ],
)
def test_every_element_of_a_block_is_that_of_the_exported_file(export, make_exporter, job, format, file, tags, options):
    folder = export(format, job, **options)
    if not (folder / file).exists():
        assert not job.scenario.current().any()
        return
    block = ET.fromstring(make_exporter(format, **options).describe_water(job))
    whole = [describe(element) for element in ET.parse(folder / file).getroot().iter()]
    for tag in tags:
        found = [element for element in block.iter(tag) if len(element) or (element.text or "").strip()]
        assert found
        for element in found:
            assert describe(element) in whole


def test_the_matrices_of_fossen_are_those_of_the_uuv_simulator(export, job):
    found = tomllib.loads(FossenExporter(WaterOptions()).describe_water(job))
    root = ET.parse(export("uuv", job) / "urdf" / "agent.xacro").getroot()

    def read(tag):
        return np.fromstring(next(root.iter(tag)).text or "", sep=" ")

    assert np.array_equal(np.ravel(found["added_mass"]), read("added_mass"))
    assert np.array_equal(np.ravel(found["linear_damping"]), -read("linear_damping"))
    assert np.array_equal(np.diag(found["quadratic_damping"]), -read("quadratic_damping"))
    assert found["volume"] == read("volume")
    # Half a turn about x maps port to starboard.
    half = np.diag([1.0, -1.0, -1.0])
    assert half @ np.array(found["inertia"]) @ half == pytest.approx(job.agent.mass.inertia, rel=1e-9)
    assert np.array_equal(found["centre_of_buoyancy"] * np.array([1, -1, -1]), read("center_of_buoyancy"))


def run(*words):
    result = CliRunner().invoke(app, list(words))
    assert result.exit_code == 0, result.stderr
    return result.stdout


def test_the_file_to_open_of_each_folder_is_printed_and_the_others_are_counted(tmp_path):
    lines = run("export", WORD, "--format", "sdf,uuv,urdf,mjcf", "--out", str(tmp_path)).splitlines()
    opened = [line.partition(":")[0].rpartition("/")[2] for line in lines[:4]]
    assert opened == ["world.sdf", "start.launch", "agent.urdf", "scene.xml"]
    for line, suffix in zip(lines[4:], ("sdf", "uuv", "urdf", "mjcf"), strict=True):
        folder, _, count = line.partition(": ")
        assert folder.endswith(f"-{suffix}")
        assert count == f"{sum(path.is_file() for path in Path(folder).rglob('*'))} files"


def test_the_exported_file_is_the_block(tmp_path):
    path = tmp_path / "out"
    run("export", WORD, "--format", "fossen", "--out", str(path))
    [file] = path.iterdir()
    assert file.read_text(encoding="utf-8") == run("inspect", WORD, "--block", "fossen")


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--block", "mjcf"), "'mjcf'"),
        (("--block", "sdff"), "did you mean 'sdf'?"),
        (("--block", "sdf", "--json"), "leave out"),
    ],
)
def test_a_format_without_a_block_is_refused_in_one_line(words, says):
    result = CliRunner().invoke(app, ["inspect", WORD, *words])
    assert result.exit_code in (1, 2)
    assert len(result.stderr.strip().splitlines()) == 1
    assert says in result.stderr
    assert not result.stdout
