"""What would be published: every distribution builds, says what it is, and works outside the repository."""

import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from email import message_from_string
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PROJECTS = [ROOT, *sorted(path.parent for path in (ROOT / "plugins").glob("*/pyproject.toml"))]

pytestmark = pytest.mark.installs

COMMANDS_ALONE = {
    "driftform-networks": "network",
    "driftform-ros": "ros",
    "driftform-studio": "studio",
    "driftform-tees": "export-flow",
}
"""The command of each plugin that adds commands and nothing to a seam."""


def project(folder):
    table = tomllib.loads((folder / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return table


@pytest.fixture(scope="module")
def installed(dist, new_environment):
    """The programs of an environment that has the wheels."""
    return new_environment(*dist.glob("*.whl"))


@pytest.fixture(scope="module", params=["this", "newest"])
def evolving(request, dist, outside, tmp_path_factory):
    """The programs of an environment where pip installed driftform, on this Python and on the newest at hand."""
    python = sys.executable if request.param == "this" else newest_python()
    folder = tmp_path_factory.mktemp("pip")
    outside(python, "-m", "venv", "env", cwd=folder)
    programs = folder / "env" / ("Scripts" if os.name == "nt" else "bin")
    options = ("--quiet", "--only-binary", ":all:", "--find-links", dist)
    outside(programs / "python", "-m", "pip", "install", *options, "driftform", cwd=folder)
    return programs


def newest_python():
    """The newest Python that the classifiers name and this machine has, if it is newer than the running one."""
    versions = [line.rpartition(" :: ")[2] for line in project(ROOT)["classifiers"] if " :: 3." in line]
    for version in reversed(versions):
        if version == "{}.{}".format(*sys.version_info):
            break
        # On the path, and beside the running one, where pyenv and uv put them.
        beside = Path(sys.base_prefix).parent.glob(f"*{version}*/bin/python{version}")
        for program in filter(None, (shutil.which(f"python{version}"), *beside)):
            if subprocess.run([program, "--version"], capture_output=True, check=False).returncode == 0:
                return str(program)
    return pytest.skip(f"no Python up to {versions[-1]} that is newer than this one is installed here")


def file_of(dist, name, end):
    [path] = dist.glob(f"{name.replace('-', '_')}-[0-9]*{end}")
    return path


def metadata(wheel):
    with zipfile.ZipFile(wheel) as archive:
        [name] = [n for n in archive.namelist() if n.endswith(".dist-info/METADATA")]
        return message_from_string(archive.read(name).decode())


@pytest.mark.parametrize("folder", PROJECTS, ids=lambda path: path.name)
def test_a_distribution_says_what_it_is_and_holds_its_licence_and_its_types(folder, dist):
    name = project(folder)["name"]
    found = metadata(file_of(dist, name, ".whl"))
    assert found["License-Expression"] == "MIT" and found["License-File"] == "LICENSE"
    assert found["Summary"] == project(folder)["description"]
    assert found["Description-Content-Type"] == "text/markdown"
    assert str(found.get_payload()).startswith(f"# {name}\n")
    assert found["Keywords"] and "Typing :: Typed" in (found.get_all("Classifier") or [])
    assert found["Requires-Python"] == ">=3.11"
    with tarfile.open(file_of(dist, name, ".tar.gz")) as archive:
        names = {member.partition("/")[2] for member in archive.getnames()}
    assert {"LICENSE", "README.md", "pyproject.toml"} <= names
    with zipfile.ZipFile(file_of(dist, name, ".whl")) as archive:
        names = set(archive.namelist())
    assert f"{name.replace('-', '_')}/py.typed" in names
    assert any(n.endswith(".dist-info/licenses/LICENSE") for n in names)
    assert not [n for n in names if n.startswith("tests/") or "__pycache__" in n]


def test_pip_installs_a_program_that_evolves_outside_the_repository(evolving, outside, tmp_path):
    words = ["evolve", "--simulator", "native", "--evaluations", "4", "--seed", "1", "--workers", "2"]
    told = json.loads(outside(evolving / "driftform", *words, "--out", "run", "--json", cwd=tmp_path))
    assert told["evaluations"] == 4 and told["failed"] == 0
    assert (tmp_path / "run" / "best" / "TP1" / "agent.stl").stat().st_size > 84


def test_the_notebook_that_the_docs_link_installs_what_it_needs(dist, outside, tmp_path, monkeypatch):
    """As Colab opens it: with Jupyter, and nothing of driftform but an index that has the wheels."""
    page = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
    [linked] = re.findall(r"colab\.research\.google\.com/github/driftform/driftform/blob/main/(\S+\.ipynb)", page)
    notebook = Path(shutil.copy(ROOT / linked, tmp_path))
    outside(sys.executable, "-m", "venv", "env", cwd=tmp_path)
    programs = tmp_path / "env" / ("Scripts" if os.name == "nt" else "bin")
    outside(programs / "python", "-m", "pip", "install", "--quiet", "ipykernel", "nbclient", cwd=tmp_path)
    monkeypatch.setenv("PIP_FIND_LINKS", str(dist))
    monkeypatch.setenv("PIP_ONLY_BINARY", ":all:")
    outside(programs / "jupyter-execute", "--inplace", notebook, cwd=tmp_path)
    cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    [shown] = cells[-1]["outputs"]
    assert "".join(shown["data"]["text/plain"]).startswith("['tp3.3mf'")


def test_every_plugin_is_found_there(installed, outside, tmp_path):
    rows = json.loads(outside(installed / "driftform", "plugins", "list", "--json", cwd=tmp_path))["plugins"]
    hooked = {project(folder)["name"] for folder in PROJECTS if "driftform" in project(folder)["entry-points"]}
    assert {row["distribution"] for row in rows} == hooked
    assert {row["state"] for row in rows} == {"ok"}
    for command in COMMANDS_ALONE.values():
        assert f"driftform {command}" in outside(installed / "driftform", command, "--help", cwd=tmp_path)
