"""What tests of the command line and of runs share: the program, a plugin that does harm, and finished runs."""

import json
import os
import shutil
import sqlite3
import subprocess
import sys
import sysconfig
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

PROGRAM = Path(sysconfig.get_path("scripts")) / ("driftform.exe" if os.name == "nt" else "driftform")


@pytest.fixture(scope="session")
def fake_plugin(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A directory for PYTHONPATH with an installed plugin, as far as ``importlib.metadata`` can tell."""
    folder = tmp_path_factory.mktemp("site")
    shutil.copy(Path(__file__).parent / "cli" / "fake_plugin" / "driftform_fake.py", folder)
    info = folder / "driftform_fake-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: driftform-fake\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[driftform]\nfake = driftform_fake\n")
    return folder


@pytest.fixture
def fakes(fake_plugin: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The plugin in this process, and in those that it starts."""
    from driftform.registry import registry

    monkeypatch.syspath_prepend(str(fake_plugin))
    registry.cache_clear()
    yield
    registry.cache_clear()
    sys.modules.pop("driftform_fake", None)


@pytest.fixture(scope="session")
def start(fake_plugin: Path) -> Callable[..., subprocess.Popen[str]]:
    """Start the installed program."""

    def started(*args: object, cwd: Path) -> subprocess.Popen[str]:
        return subprocess.Popen(
            [PROGRAM, *map(str, args)],
            cwd=cwd,
            env=os.environ | {"PYTHONPATH": str(fake_plugin)},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    return started


@pytest.fixture(scope="session")
def run(start: Callable[..., subprocess.Popen[str]]) -> Callable[..., subprocess.CompletedProcess[str]]:
    """Run the installed program to its end."""

    def finished(*args: object, cwd: Path) -> subprocess.CompletedProcess[str]:
        with start(*args, cwd=cwd) as process:
            out, err = process.communicate(timeout=120)
        return subprocess.CompletedProcess(args, process.returncode, out, err)

    return finished


@pytest.fixture
def call(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Any]:
    """Call the program in this process, in an empty directory."""
    from typer.testing import CliRunner

    from driftform.cli import app

    monkeypatch.chdir(tmp_path)
    return lambda *args: CliRunner().invoke(app, [str(arg) for arg in args], prog_name="driftform")


@pytest.fixture
def refused(call: Callable[..., Any], tmp_path: Path) -> Callable[..., str]:
    """Call the program with bad input; it says so in one line and leaves nothing behind. Return the line."""

    def line_of(*args: object) -> str:
        before = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*") if path.is_file()}
        folders = {path for path in tmp_path.rglob("*") if path.is_dir()}
        result = call(*args)
        assert isinstance(result.exception, SystemExit), result.exception
        assert result.exit_code == 2, result.stderr
        assert result.stdout == ""
        lines = result.stderr.splitlines()
        assert len(lines) == 1, result.stderr
        assert lines[0].startswith("error: ")
        after = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*") if path.is_file()}
        locks = {path for path in after if path.name == ".lock"}
        assert {path: when for path, when in after.items() if path not in locks} == {
            path: when for path, when in before.items() if path not in locks
        }
        assert {path for path in tmp_path.rglob("*") if path.is_dir()} == folders
        return lines[0]

    return line_of


@pytest.fixture(scope="session")
def finished_run(
    run: Callable[..., subprocess.CompletedProcess[str]], tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, subprocess.CompletedProcess[str]]:
    """A small real run, and what the program said; not to be changed."""
    cwd = tmp_path_factory.mktemp("finished")
    result = run(
        "evolve",
        *("--evaluations", 20, "--target", "TP1", "--target", "TP7", "--seed", 1, "--workers", 1),
        *("--out", "run", "--json"),
        cwd=cwd,
    )
    assert result.returncode == 0, result.stderr
    return cwd / "run", result


@pytest.fixture
def run_copy(finished_run: tuple[Path, object], tmp_path: Path) -> Path:
    """A copy of the small real run, to do harm to."""
    return Path(shutil.copytree(finished_run[0], tmp_path / "run"))


@pytest.fixture
def agent_document(finished_run: tuple[Path, object]) -> dict[str, Any]:
    """A sound agent.json."""
    text = (finished_run[0] / "best" / "TP1" / "agent.json").read_text()
    document: dict[str, Any] = json.loads(text)
    return document


@pytest.fixture(scope="session")
def rows() -> Callable[[Path], list[tuple[Any, ...]]]:
    """All that a run found, to the last digit; not how long it took."""

    def read(directory: Path) -> list[tuple[Any, ...]]:
        connection = sqlite3.connect(directory / "run.db")
        try:
            columns = (
                "id, generation, population, parents, grammar, symbols, failure, ended, duration, trajectory"
            )
            evaluations = connection.execute(f"SELECT {columns} FROM evaluation ORDER BY id").fetchall()
            scores = connection.execute("SELECT * FROM score ORDER BY target, evaluation").fetchall()
        finally:
            connection.close()
        return [*evaluations, *scores]

    return read
