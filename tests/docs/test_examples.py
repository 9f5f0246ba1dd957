"""The examples of the pages: the plugin installs and works, study files load, errors read as printed."""

import json
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from program import write_metadata
from typer.testing import CliRunner

from driftform.cli.app import app
from driftform.study import load_study

ROOT = Path(__file__).parents[2]
WORD = "addB-tiltn-1-M-moveB-addB-tiltn-2-S-moveB-addB-tiltp-1-L-moveB"
SEALED = "addF-tiltp-2-L-moveF-addF-tiltp-1-L-moveF-addF-tiltp-0-L-moveF-addB-tiltn-1-L-moveB-addB-tiltn-1-L-moveB"
"""Wide enough for a bayonet with an O-ring."""


def write_files(folder, page, blocks):
    """Write the files that a page shows; return their texts by path."""
    files = {block.file: block.text for block in blocks if block.page == page and block.file}
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return files


# docs/study-files.md


@pytest.fixture
def study_folder(tmp_path, blocks, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return write_files(tmp_path, "study-files.md", blocks)


def test_the_full_example_loads(study_folder):
    study = load_study("short-pipe.toml")
    assert study.scenario.target_names == ("leak", "valve")
    assert study.evaluations == 200
    assert study.scenario.flow.speed == 0.8
    assert study.document["grammar"]["occupied"] == "skip"
    assert study.document["builder"]["core_mass"] == 0.02
    assert study.document["simulator"]["use"] == "native"


def test_a_study_of_its_own_needs_every_table(study_folder):
    assert load_study("open-water.toml", targets=(), run={"seed": 0}).scenario.pipe.segments == ()


# docs/write-a-plugin.md


@pytest.fixture(scope="module")
def plugin_folder(tmp_path_factory, blocks):
    """The example plugin as an installer would leave it: its package, and its metadata beside it."""
    folder = tmp_path_factory.mktemp("plugin")
    write_files(folder, "write-a-plugin.md", blocks)
    project = tomllib.loads((folder / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    points = "\n".join(map(" = ".join, project["entry-points"]["driftform"].items()))
    write_metadata(folder / "src", project["name"], points, project["version"])
    return folder


def run_python(folder, *arguments):
    environment = {**os.environ, "PYTHONPATH": str(folder / "src"), "PYTHONDONTWRITEBYTECODE": "1"}
    command = [sys.executable, *arguments]
    done = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, timeout=600, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def run_driftform(folder, *arguments):
    return json.loads(run_python(folder, "-c", "from driftform.cli import main; main()", *arguments, "--json"))


def test_the_plugin_is_found(plugin_folder):
    rows = run_driftform(plugin_folder, "plugins", "list")["plugins"]
    assert ["fitness", "dwell", "driftform-dwell", "0.1.0", "ok"] in [
        [row[key] for key in ("seam", "name", "distribution", "version", "state")] for row in rows
    ]


@pytest.mark.long
def test_the_plugin_scores_a_flight(plugin_folder):
    found = run_driftform(plugin_folder, "simulate", WORD, "--scenario", "linger.toml", "--out", "flight")
    assert set(found["fitness"]) == {f"TP{n}" for n in range(1, 11)}
    assert 0 < found["fitness"]["TP1"] < 100
    assert found["fitness"]["TP8"] == 0


def test_the_plugin_passes_its_contract(plugin_folder):
    out = run_python(plugin_folder, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-c", "pyproject.toml", "tests")
    assert "passed" in out


# docs/cli.md


@pytest.fixture(scope="module")
def outputs(tmp_path_factory):
    """The JSON document of every command."""
    folder = tmp_path_factory.mktemp("cli")
    run, here = str(folder / "run"), str(folder)
    (folder / "hull.csv").write_text("x_mm,r_mm\n0,0\n12,12\n50,12\n60,0\n", encoding="utf-8")
    lines = {
        "evolve": [
            *("evolve", "--target", "TP1", "--evaluations", "2", "--seed", "1", "--workers", "1"),
            *("--set", "robustness.checks=4", "--out", run),
        ],
        "resume": ["resume", run, "--workers", "1"],
        "compare": [
            *("compare", "paper", "--strategy", "random", "--strategy", "paper", "--seeds", "2", "--evaluations", "4"),
            *("--set", "targets.TP1=[1.0,0.0,-0.5]", "--robust", "1", "--set", "robustness.checks=4"),
            *("--workers", "1", "--out", f"{here}/comparison"),
        ],
        "watch": ["watch", run],
        "export-data": ["export-data", run, "--trajectories"],
        "pick": ["pick", run, "4.5", "0", "-0.3"],
        "sample": ["sample", "--count", "1", "--out", f"{here}/agents"],
        "simulate": ["simulate", f"{run}:TP1", "--out", f"{here}/flight"],
        "inspect": [
            *("inspect", SEALED, "--compare", "--set", "builder.made_as=kit", "--set", "builder.kit.joint=bayonet")
        ],
        "export": [
            *("export", f"{run}:TP1", "--format", "stl,scad", "--out", f"{here}/parts"),
            *("--kit", "--option", "lap=0.007"),
        ],
        "export-flight": ["export-flight", WORD, "--simulator", "native", "--out", f"{here}/samples"],
        "export-flow": ["export-flow", "paper", "--spacing", "0.4", "--out", f"{here}/currents.csv"],
        "body": ["body", f"{here}/hull.csv", "--mass", "0.02", "--cog", "0.03", "--out", f"{here}/hull.json"],
        "check": ["check", WORD, "--no-programs"],
        "trim": ["trim", WORD, "--printed-mass", "0.0345", "--simulator", "native"],
        "report": ["report", str(run)],
        "calibrate": [
            *("calibrate", "C", str(ROOT / "docs/tracks/ten-cate-e4.csv"), "--fit", "cross_drag"),
            *("--out", f"{here}/calibration"),
        ],
        "drop": ["drop", WORD, "--drops", "1", "--tank", "0.5", "0.5", "0.4", "--out", f"{here}/drops"],
        "plugins list": ["plugins", "list"],
        "plugins show": ["plugins", "show", "paper"],
        "plugins new": ["plugins", "new", "driftform-try", "--seam", "fitness", "--out", f"{here}/try"],
        "scenarios list": ["scenarios", "list"],
        "scenarios show": ["scenarios", "show", "pipe-inspection"],
        "scenarios check": ["scenarios", "check", "pipe-inspection"],
    }
    found = {}
    for name, words in lines.items():
        result = CliRunner().invoke(app, [*words, "--json"])
        assert result.exit_code == 0, f"{name}: {result.stderr}"
        found[name] = json.loads(result.stdout)
    return found


def documented(page):
    """The paths of JSON fields that cli.md describes, by command."""
    found = {}
    name, table = "", False
    for line in page.splitlines():
        if line.startswith("<!-- generated: "):
            name = line.removeprefix("<!-- generated: ").removesuffix(" -->")
        table = line.startswith("|") and (table or line.startswith("| JSON field"))
        if table and line.startswith("| `"):
            found.setdefault(name, []).extend(re.findall("`([^`]+)`", line.split("|")[1]))
    return found


def follow(document, path):
    for step in path.replace("[]", ".[]").split("."):
        if step == "[]":
            document = document[0]
        elif step == "*":
            document = next(iter(document.values()))
        else:
            document = document[step]
    return document


@pytest.mark.long
def test_json_fields_are_as_told(outputs, pages):
    told = documented(pages["cli.md"])
    told["resume"] = told["evolve"]
    for name, document in outputs.items():
        top = {path.partition(".")[0].removesuffix("[]") for path in told[name]}
        assert set(document) == top, name
        for path in told[name]:
            follow(document, path)
    # No field of a list is left out.
    for name, key in (("plugins list", "plugins"), ("plugins show", "plugins"), ("scenarios list", "scenarios")):
        fields = {path.split(".")[1].removesuffix("[]") for path in told[name]}
        assert set(outputs[name][key][0]) == fields, name
    modules = {p.removeprefix("modules[].") for p in told["inspect"] if p.startswith("modules[].")}
    assert set(outputs["inspect"]["modules"][0]) == modules


# docs/junctions.md


def test_the_side_branch_has_two_outlets_as_targets(tmp_path, blocks, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_files(tmp_path, "junctions.md", blocks)
    scenario = load_study("side-branch.toml").scenario
    assert [outlet.name for outlet in scenario.pipe.layout.outlets] == ["left", "right on"]
    assert set(scenario.target_names) == {"left", "on"}
    # Left of the water that flows along x is +y.
    points = scenario.target_points()
    assert points["left"][1] > 0.5 and abs(points["on"][1]) < 1e-9


@pytest.mark.long
def test_a_run_directory_holds_what_dataflow_tells(pages, outputs):
    run = Path(outputs["evolve"]["run"])
    section = pages["dataflow.md"].partition("## The run directory")[2].partition("\n## ")[0]
    names = {path.name for path in run.iterdir() if not path.name.startswith(".") and "-" not in path.suffix}
    files = {path.name for path in (run / "best" / "TP1").iterdir()}
    assert [name for name in sorted(names | files) if f"`{name}" not in section and f"{name}`" not in section] == []
