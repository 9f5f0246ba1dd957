"""A plugin of somebody else's, installed by a real installer, is found and used just like ours."""

import csv
import json
import os
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

PROGRAM = Path(sysconfig.get_path("scripts")) / ("driftform.exe" if os.name == "nt" else "driftform")

FILES = {
    # uv builds this backend itself, so that nothing is downloaded.
    "pyproject.toml": """\
[build-system]
requires = ["uv_build"]
build-backend = "uv_build"

[project]
name = "elsewhere-progress"
version = "4.5.6"
requires-python = ">=3.11"
dependencies = ["driftform"]

[project.entry-points.driftform]
progress = "elsewhere_progress"
""",
    "src/elsewhere_progress/__init__.py": '''\
"""Progress along the pipe as a fitness, and a search that tries one word over and over."""

from driftform import hookimpl


@hookimpl
def driftform_fitness():
    from elsewhere_progress.plugins import Progress

    return Progress


@hookimpl
def driftform_strategy():
    from elsewhere_progress.plugins import Stubborn

    return [Stubborn]
''',
    "src/elsewhere_progress/plugins.py": '''\
import numpy as np

from driftform.interfaces import Fitness, Strategy
from driftform.interfaces import Table, option
from driftform.types import Candidate


class ProgressOptions(Table):
    scale: float = option(1.0, "fitness for each metre", "1/m", gt=0)


class Progress(Fitness[ProgressOptions]):
    """Metres travelled along x at the end of the flight, times ``scale``."""

    name = "progress"
    Options = ProgressOptions

    def score(self, trajectory, scenario, agent):
        return np.full(len(scenario.targets), max(0.0, self.options.scale * trajectory.position[-1, 0]))


class StubbornOptions(Table):
    genome: str = option(..., "the genome to try, as text")


class Stubborn(Strategy[StubbornOptions]):
    """Asks for one genome, every time."""

    name = "stubborn"
    Options = StubbornOptions

    def ask(self, limit):
        return [Candidate(self.space.grammar.parse(self.options.genome))] * min(2, limit)

    def tell(self, first, evaluations):
        pass
''',
}

WORD = "addF-tiltp-1-M-moveN-addB-tiltn-0-L-moveN"


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The plugin's own source tree, somewhere else than driftform's."""
    folder = tmp_path_factory.mktemp("elsewhere")
    for name, text in FILES.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return folder


@pytest.fixture(scope="module")
def site(source: Path, uv: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A directory that the plugin is installed into."""
    target = tmp_path_factory.mktemp("site")
    command = [uv, "pip", "install", "--offline", "--no-deps", "--python", sys.executable, "--target", target, source]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
    return target


def driftform(site: Path, cwd: Path, *args: str) -> dict:
    done = subprocess.run(
        [PROGRAM, *args, "--json"],
        cwd=cwd,
        env=os.environ | {"PYTHONPATH": str(site)},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_it_is_listed_with_its_distribution_and_version(site, tmp_path):
    rows = driftform(site, tmp_path, "plugins", "list")["plugins"]
    theirs = [row for row in rows if row["distribution"] == "elsewhere-progress"]
    assert theirs == [
        {"seam": seam, "name": name, "distribution": "elsewhere-progress", "version": "4.5.6", "state": "ok"}
        for seam, name in (("fitness", "progress"), ("strategy", "stubborn"))
    ]
    assert {"seam", "name", "distribution", "version", "state"} == set(rows[0])
    assert any(row["name"] == "closest-approach" and row["state"] == "ok" for row in rows)


def test_a_study_evolves_with_its_fitness_and_its_strategy(site, tmp_path):
    done = driftform(
        site,
        tmp_path,
        "evolve",
        "paper",
        *("--evaluations", "4", "--target", "TP1", "--workers", "1", "--seed", "1", "--out", "run"),
        *("--strategy", "stubborn", "--set", f"strategy.genome={WORD}"),
        *("--set", "fitness.use=progress", "--set", "fitness.scale=2.5"),
    )
    assert (done["evaluations"], done["failed"]) == (4, 0)
    best = tmp_path / "run" / "best" / "TP1"
    with (best / "trajectory.csv").open(newline="") as file:
        samples = list(csv.DictReader(file))
    (column,) = [name for name in samples[0] if name == "x" or name.startswith(("x_", "x ", "x["))]
    travelled = float(samples[-1][column])
    assert travelled > 0.1
    assert done["targets"]["TP1"]["fitness"] == pytest.approx(2.5 * travelled, rel=1e-4)
    agent = json.loads((best / "agent.json").read_text())
    assert agent["genome"]["symbols"] == ["C", *WORD.split("-")]
    assert "elsewhere-progress" in (tmp_path / "run" / "environment.json").read_text()
