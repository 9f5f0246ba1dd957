"""``driftform plugins new``: what it writes for each seam installs, works, and passes its own tests."""

import importlib.util
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from program import write_metadata

from driftform.cli.options import FILE
from driftform.interfaces import SEAMS
from driftform.plugins.scaffold import KINDS, list_files, make_names

ROOT = Path(__file__).parents[2]

FLYING = {"simulator": "::test_all_integrators_give_the_same_flight"}
"""Seams whose contract flies for half a minute, where the scaffold is installed; and what is run of their tests here."""


def write(folder, seam):
    """Write the scaffold of a seam."""
    for path, text in list_files(make_names(f"driftform-try-{seam}", seam)).items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(text)
    return folder


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """A folder with each scaffold, and ``site``, where all are installed as far as ``importlib.metadata`` can tell."""
    folder = tmp_path_factory.mktemp("scaffolds")
    # Tests are then named by their path from here, whoever is the first.
    (folder / "pytest.ini").write_text("[pytest]\n")
    for seam in KINDS:
        source = write(folder / seam, seam)
        project = tomllib.loads((source / "pyproject.toml").read_text())["project"]
        (point,) = map(" = ".join, project["entry-points"]["driftform"].items())
        shutil.copytree(source / "src", folder / "site", dirs_exist_ok=True)
        write_metadata(folder / "site", project["name"], point, project["version"])
    return folder


def python(installed, *arguments):
    return subprocess.run(
        [sys.executable, *map(str, arguments)],
        cwd=installed,
        env=os.environ | {"PYTHONPATH": str(installed / "site"), "PYTHONDONTWRITEBYTECODE": "1"},
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )


@pytest.fixture(scope="module")
def outcomes(installed):
    """What became of the tests of each quick seam: ``passed``, ``skipped`` or the message of a failure."""
    tests = [f"{installed / seam / 'tests' / f'test_{seam}.py'}{FLYING.get(seam, '')}" for seam in KINDS]
    options = ("-q", "-p", "no:cacheprovider", "--import-mode=importlib", "-W", "error", "--junitxml=out.xml")
    done = python(installed, "-m", "pytest", *options, *tests)
    assert (installed / "out.xml").exists(), done.stdout + done.stderr
    found = {seam: [] for seam in KINDS}
    for case in ET.parse(installed / "out.xml").iter("testcase"):
        names = case.attrib["classname"].split(".")
        (seam,) = [name.removeprefix("test_") for name in names if name.startswith("test_")]
        found[seam].append(" ".join(f"{part.tag} {part.get('message')}" for part in case) or "passed")
    return found


def test_every_seam_commands_and_scenarios_have_a_scaffold():
    folders = (ROOT / "src" / "driftform" / "plugins" / "scaffold").glob("*/about.toml")
    assert {file.parent.name for file in folders} == set(KINDS)


@pytest.mark.parametrize("seam", KINDS)
def test_a_scaffold_passes_its_contract_and_its_own_tests(seam, outcomes):
    assert len(outcomes[seam]) >= 2
    assert [outcome for outcome in outcomes[seam] if outcome != "passed"] == []


def test_each_is_found_with_its_options_and_its_study_selects_it(installed):
    code = """if True:
    import json, sys
    from driftform.interfaces import SEAMS
    from driftform.util.options import describe
    from driftform.plugins.registry import registry
    from driftform.study import load_study
    for seam in SEAMS:
        study = load_study(f"{seam}/study.toml")
        study.make_pipeline(), study.make_strategy()
        row = [row for row in registry().seam(seam) if row.name == f"try-{seam}"][0]
        table = study.document.get(seam)
        [table] = study.document["builder"]["fittings"] if seam == "fitting" else [table]
        options = table if table.get("use") == row.name else table[row.name]
        print(json.dumps([seam, row.state, row.distribution, describe(row.cls.Options), options]))
    """
    done = python(installed, "-c", code)
    assert done.returncode == 0, done.stderr
    rows = [json.loads(line) for line in done.stdout.splitlines()]
    assert [row[0] for row in rows] == list(SEAMS)
    for seam, state, distribution, described, options in rows:
        assert (state, distribution) == ("ok", f"driftform-try-{seam}")
        assert all(option["help"] for option in described)
        changed = [o["option"] for o in described if options[o["option"]] != o["default"]]
        assert changed, f"the study of {seam} shows no option"


@pytest.mark.long
@pytest.mark.parametrize("seam", ["exporter", "recorder"])
def test_the_command_in_its_readme_writes_a_file(seam, installed, tmp_path):
    readme = (installed / seam / "README.md").read_text()
    (line,) = [line for line in readme.splitlines() if line.startswith("$ driftform export")]
    words = [str(installed / seam / w) if w == "study.toml" else w for w in shlex.split(line)[2:]]
    done = python(installed, "-c", "from driftform.cli import main; main()", *words, "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    assert [path.stat().st_size > 0 for path in tmp_path.iterdir()] == [True]


# The command.


def test_the_command_prints_the_files_and_the_next_steps(call, tmp_path):
    document = json.loads(call("plugins", "new", "driftform-dwell", "--seam", "fitness", "--json").stdout)
    assert sorted(map(Path, document["files"])) == sorted(
        path.relative_to(tmp_path) for path in (tmp_path / "driftform-dwell").rglob("*") if path.is_file()
    )
    assert (document["plugin"], document["package"]) == ("dwell", "driftform_dwell")
    assert document["next"][0] == "cd driftform-dwell"
    text = call("plugins", "new", "driftform-linger", "--seam", "fitness", "--out", "else where").stdout
    assert "cd 'else where'" in text
    assert (tmp_path / "else where" / "pyproject.toml").is_file()


@pytest.mark.parametrize(
    ("has_pip", "origin", "prefix", "steps"),
    [
        (True, {"editable": True}, "/a clone/.venv", ['pip install -e ".[test]"', "pytest"]),
        (False, {}, "/a clone/.venv", ['uv pip install -e ".[test]"', "pytest"]),
        (False, {"editable": True}, "/elsewhere", ['uv pip install -e ".[test]"', "pytest"]),
        (False, {"editable": True}, "/a clone/.venv", ["uv add --editable '/a clone'", "uv run --extra test pytest"]),
    ],
    ids=["pip", "uv", "uv, and a clone elsewhere", "uv in a clone"],
)
def test_the_next_steps_are_those_of_the_installer(call, monkeypatch, has_pip, origin, prefix, steps):
    found = importlib.util.find_spec
    monkeypatch.setattr(
        "importlib.util.find_spec", lambda name: (name if has_pip else None) if name == "pip" else found(name)
    )
    monkeypatch.setattr("sys.prefix", prefix)
    text = json.dumps({"url": "file:///a%20clone", "dir_info": origin})
    monkeypatch.setattr("importlib.metadata.PathDistribution.read_text", lambda *_: text)
    document = json.loads(call("plugins", "new", "driftform-dwell", "--seam", "fitness", "--json").stdout)
    show = "uv run driftform" if steps[1].startswith("uv run") else "driftform"
    assert document["next"][1:4] == [*steps, f"{show} plugins show dwell"]


@pytest.mark.peers
@pytest.mark.parametrize("words", [["format", "--check"], ["check", "--select", "E,F,W,I,N,UP,B,SIM,PTH,RUF"]])
def test_a_scaffold_is_formatted_and_passes_the_linter(words, installed):
    ruff = [sys.executable, "-m", "ruff", *words, "--isolated", "--no-cache", "--line-length", "110", "."]
    for seam in KINDS:
        # From the distribution's own folder: ruff looks there for which package is the first party.
        done = subprocess.run(ruff, cwd=installed / seam, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout


@pytest.mark.parametrize(
    ("name", "seam", "message"),
    [
        ("!", "fitness", "such as driftform-dwell"),
        ("../evil", "fitness", "did you mean 'evil'?"),
        ("numpy", "fitness", "did you mean 'driftform-numpy'?"),
        ("class", "fitness", "did you mean 'driftform-class'?"),
        ("driftform-3d", "fitness", "begin with a letter"),
        ("driftform-closest-approach", "fitness", "already exists, from driftform"),
        ("driftform-phenotype", "builder", "the name of a class of driftform"),
        ("x" * 61, "fitness", "longer than 60"),
    ],
)
def test_an_invalid_or_taken_name_is_refused(name, seam, message, refused):
    assert message in refused("plugins", "new", name, "--seam", seam)


def test_names_are_normalised(call, tmp_path):
    call("plugins", "new", "Driftform_Long.Dwell", "--seam", "fitness")
    project = tomllib.loads((tmp_path / "driftform-long-dwell" / "pyproject.toml").read_text())["project"]
    assert project["name"] == "driftform-long-dwell"
    assert project["entry-points"]["driftform"] == {"long-dwell": "driftform_long_dwell"}
    assert "class LongDwellFitness" in next(tmp_path.rglob("fitness.py")).read_text()


def test_the_help_names_what_a_plugin_can_bring():
    shown = tomllib.loads(FILE.read_text(encoding="utf-8"))["new"]["seam"]["help"]
    assert re.split(", | or ", shown.removeprefix("Seam to implement: ").removesuffix(".")) == list(KINDS)


# Installed for real.


@pytest.fixture(scope="module")
def environment(dist, new_environment, tmp_path_factory):
    """The sources of all scaffolds, and the programs of an environment that has them and driftform."""
    folder = tmp_path_factory.mktemp("sources")
    sources = (f"{write(folder / seam, seam)}[test]" for seam in SEAMS)
    return folder, new_environment("--find-links", dist, "driftform", *sources)


@pytest.mark.installs
@pytest.mark.parametrize("seam", SEAMS)
def test_a_scaffold_installs_in_an_empty_environment_and_passes_there(seam, environment, outside):
    folder, programs = environment
    assert " passed" in outside(programs / "python", "-m", "pytest", "-W", "error", cwd=folder / seam)


@pytest.mark.installs
def test_a_plugin_beside_a_clone_survives_uv_sync(uv, outside, tmp_path):
    folder = write(tmp_path / "driftform-try", "fitness")
    outside(uv, "add", "--editable", ROOT, cwd=folder)
    for _ in range(2):
        outside(uv, "sync", cwd=folder)
        rows = json.loads(outside(uv, "run", "driftform", "plugins", "list", "--json", cwd=folder))["plugins"]
        assert [row["state"] for row in rows if row["distribution"] == "driftform-try-fitness"] == ["ok"]
    assert " passed" in outside(uv, "run", "--extra", "test", "pytest", cwd=folder)
