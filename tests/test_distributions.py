"""What would be published: every distribution builds, says what it is, and works outside the repository."""

import json
import os
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from email import message_from_string
from email.message import Message
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PROJECTS = [ROOT, *sorted(path.parent for path in (ROOT / "plugins").glob("*/pyproject.toml"))]

pytestmark = pytest.mark.slow


def project(folder: Path) -> dict[str, str]:
    table: dict[str, str] = tomllib.loads((folder / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return table


def uv(*words: object, cwd: Path) -> str:
    """Run uv outside the virtual environment of the tests."""
    environment = {k: v for k, v in os.environ.items() if k not in ("VIRTUAL_ENV", "PYTHONPATH")}
    done = subprocess.run(
        ["uv", *map(str, words)], cwd=cwd, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def dist(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A directory with all wheels and sdists; a wheel is built from its sdist."""
    folder = tmp_path_factory.mktemp("dist")
    uv("build", "--all-packages", "--out-dir", folder, cwd=ROOT)
    return folder


@pytest.fixture(scope="module")
def installed(dist: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The programs of an environment that has the wheels and what they need, and nothing else."""
    folder = tmp_path_factory.mktemp("elsewhere")
    uv("venv", "--python", sys.executable, "env", cwd=folder)
    dated = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["uv"][
        "exclude-newer"
    ]
    bin_ = folder / "env" / ("Scripts" if os.name == "nt" else "bin")
    uv(
        "pip",
        "install",
        "--python",
        folder / "env",
        "--exclude-newer",
        dated,
        *dist.glob("*.whl"),
        cwd=folder,
    )
    return bin_


def file_of(dist: Path, name: str, end: str) -> Path:
    [path] = dist.glob(f"{name.replace('-', '_')}-[0-9]*{end}")
    return path


def metadata(wheel: Path) -> Message:
    with zipfile.ZipFile(wheel) as archive:
        [name] = [n for n in archive.namelist() if n.endswith(".dist-info/METADATA")]
        return message_from_string(archive.read(name).decode())


@pytest.mark.parametrize("folder", PROJECTS, ids=lambda path: path.name)
def test_a_distribution_says_what_it_is(folder: Path, dist: Path) -> None:
    name = project(folder)["name"]
    found = metadata(file_of(dist, name, ".whl"))
    assert found["License-Expression"] == "MIT" and found["License-File"] == "LICENSE"
    assert found["Summary"] == project(folder)["description"]
    assert found["Description-Content-Type"] == "text/markdown"
    assert str(found.get_payload()).startswith(f"# {name}\n")
    assert found["Keywords"] and "Typing :: Typed" in (found.get_all("Classifier") or [])
    assert found["Requires-Python"] == ">=3.11"


@pytest.mark.parametrize("folder", PROJECTS, ids=lambda path: path.name)
def test_wheels_and_sdists_hold_the_licence_and_say_that_they_are_typed(folder: Path, dist: Path) -> None:
    name = project(folder)["name"]
    with tarfile.open(file_of(dist, name, ".tar.gz")) as archive:
        names = {member.partition("/")[2] for member in archive.getnames()}
    assert {"LICENSE", "README.md", "pyproject.toml"} <= names
    with zipfile.ZipFile(file_of(dist, name, ".whl")) as archive:
        names = set(archive.namelist())
    assert f"{name.replace('-', '_')}/py.typed" in names
    assert any(n.endswith(".dist-info/licenses/LICENSE") for n in names)
    assert not [n for n in names if n.startswith("tests/") or "__pycache__" in n]


def test_it_evolves_outside_the_repository(installed: Path, tmp_path: Path) -> None:
    words = ["evolve", "--simulator", "native", "--evaluations", "4", "--seed", "1", "--workers", "2"]
    done = subprocess.run(
        [installed / "driftform", *words, "--out", "run", "--json"],
        cwd=tmp_path,
        env={k: v for k, v in os.environ.items() if k != "PYTHONPATH"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert told["evaluations"] == 4 and told["failed"] == 0
    assert (tmp_path / "run" / "best" / "TP1" / "agent.stl").stat().st_size > 84


def test_every_plugin_is_found_there(installed: Path, tmp_path: Path) -> None:
    out = subprocess.run(
        [installed / "driftform", "plugins", "list", "--json"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    rows = json.loads(out)["plugins"]
    assert {row["distribution"] for row in rows} == {project(folder)["name"] for folder in PROJECTS}
    assert {row["state"] for row in rows} == {"ok"}
