"""Runs that are killed at random moments, again and again: what was acknowledged is there, and the result is the same.

Run by hand: ``pytest -m slow tests/studies/test_survival.py``; ``KILLS=100`` for more of them.
"""

import os
import re
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytestmark = [pytest.mark.slow, pytest.mark.skipif(sys.platform != "linux", reason="finds processes in /proc")]

EVALUATIONS = 1500
STUDY = (
    "paper",
    *("--simulator", "fake", "--set", "simulator.pause=0.05", "--evaluations", EVALUATIONS, "--seed", 5),
    *("--target", "TP1", "--target", "TP8"),
)
LONGEST = 4.0
"""How long after it began, or after its first new evaluation, a process is killed at most, s."""

PATIENCE = 120.0
"""How long a process may take to its first new evaluation on a machine that does other things as well, s."""

ACKNOWLEDGED = re.compile(rf"^(\d+)/{EVALUATIONS} evaluations", re.MULTILINE)


def children(process: int) -> list[int]:
    """The worker processes that a process has started, as the kernel tells."""
    found = []
    for status in Path("/proc").glob("[0-9]*/stat"):
        try:
            parent = int(status.read_text().rpartition(")")[2].split()[1])
            if parent == process and b"spawn_main" in (status.parent / "cmdline").read_bytes():
                found.append(int(status.parent.name))
        except OSError:
            pass
    return found


def kill(process: int) -> None:
    with suppress(ProcessLookupError):
        os.kill(process, signal.SIGKILL)


def evaluations(run: Path) -> dict[int, tuple[Any, ...]]:
    """What the database of a run holds, which must be whole; read from a copy, as the next process will find it."""
    if not (run / "run.db").exists():
        return {}
    copy = shutil.copytree(run, run.with_name("copy"), dirs_exist_ok=True)
    connection = sqlite3.connect(copy / "run.db")
    try:
        assert connection.execute("PRAGMA integrity_check").fetchall() == [("ok",)]
        found = {row[0]: row for row in connection.execute("SELECT * FROM evaluation")}
        scores = connection.execute("SELECT evaluation, COUNT(*) FROM score GROUP BY evaluation").fetchall()
    finally:
        connection.close()
        shutil.rmtree(copy)
    assert sorted(scores) == [(index, 2) for index in sorted(found)]
    return found


def wait_for_more(run: Path, before: int) -> None:
    """Return when a run that goes on has more evaluations than before."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        with (
            suppress(sqlite3.OperationalError),
            closing(sqlite3.connect(f"file:{run}/run.db?mode=ro", uri=True)) as connection,
        ):
            if connection.execute("SELECT COUNT(*) FROM evaluation").fetchone()[0] > before:
                return
        time.sleep(0.05)
    raise AssertionError("there is no progress")


@pytest.fixture(scope="module")
def undisturbed(
    run: Callable[..., Any], rows: Callable[[Path], Any], tmp_path_factory: pytest.TempPathFactory
) -> list[tuple[Any, ...]]:
    cwd = tmp_path_factory.mktemp("undisturbed")
    done = run("evolve", *STUDY, "--set", "simulator.pause=0", "--workers", 2, "--out", "run", cwd=cwd)
    assert done.returncode == 0, done.stderr
    found: list[tuple[Any, ...]] = rows(cwd / "run")
    return found


@pytest.fixture(params=["local", "dask", "joined"])
def place(request: pytest.FixtureRequest) -> Iterator[tuple[object, ...]]:
    """Options that say where evaluations run."""
    if request.param == "joined":
        yield ("--scheduler", request.getfixturevalue("dask_cluster"))
    else:
        yield ("--executor", request.param, "--workers", 2)


def test_killed_at_random_moments_it_ends_as_if_undisturbed(
    place: tuple[object, ...],
    start: Callable[..., subprocess.Popen[str]],
    rows: Callable[[Path], Any],
    undisturbed: list[tuple[Any, ...]],
    tmp_path: Path,
    count_of: Callable[[str, int], int],
) -> None:
    rng, run, kills = np.random.default_rng(7), tmp_path / "run", count_of("KILLS", 20)
    stored: dict[int, tuple[Any, ...]] = {}
    heights = []
    for _ in range(kills):
        command = ("resume", "run") if (run / "run.db").exists() else ("evolve", *STUDY, "--out", "run")
        if command[0] == "evolve" and run.exists():
            # Killed before there was a database: nothing was acknowledged, and nothing is there to resume.
            run.rename(tmp_path / f"before-{len(heights)}")
        with start(*command, *place, cwd=tmp_path) as process:
            # Some do not live to see their first evaluation.
            if rng.random() < 0.8:
                wait_for_more(run, len(stored))
            for _ in range(2):
                time.sleep(rng.uniform(0, LONGEST / 2))
                victims = children(process.pid)
                if victims and rng.random() < 0.5:
                    kill(int(rng.choice(victims)))
            kill(process.pid)
            _, err = process.communicate()
        now = evaluations(run)
        assert all(now.get(index) == row for index, row in stored.items()), "an evaluation was lost"
        shown = [int(number) for number in ACKNOWLEDGED.findall(err)]
        assert all(set(range(number)) <= now.keys() for number in shown), "what was shown was not stored"
        stored = now
        heights.append(len(now))
        assert "Traceback" not in err
    print(f"\n{place}: evaluations after each of {kills} kills: {heights}")
    assert heights[-1] > 0

    with start("resume", "run", *place, cwd=tmp_path) as process:
        _, err = process.communicate(timeout=600)
    assert process.returncode == 0, err
    assert rows(run) == undisturbed
