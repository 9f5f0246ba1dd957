"""Runs that are killed a hundred times, and clusters that lose their parts: no row is lost.

``KILLS=10 SIGNALS=3 uv run pytest -m slow -s tests/endurance/test_trials.py`` shortens them.
"""

import os
import random
import signal
import sqlite3
import sys
import time
from contextlib import ExitStack, closing, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="sends POSIX signals, and reads /proc"),
]

STUDY = ("evolve", "paper", "--simulator", "fake", "--target", "TP1", "--seed", 5)
PAUSE = ("--set", "simulator.pause=0.02", "--out", "run")


def read_rows(run):
    """What a run has stored, also one that goes on or was killed."""
    try:
        with closing(sqlite3.connect(f"file:{run / 'run.db'}?mode=ro", uri=True)) as connection:
            return set(connection.execute("SELECT id, symbols, seed, failure FROM evaluation"))
    except sqlite3.OperationalError:
        return set()


def wait_for_rows(run, count, *processes):
    """Wait until a run has so many rows, or one of its processes has ended."""
    end = time.monotonic() + 600
    while len(read_rows(run)) < count and all(process.poll() is None for process in processes):
        assert time.monotonic() < end
        time.sleep(0.02)


def wait_for_workers(nanny):
    """Return the worker processes that any thread of a nanny started, once there is one."""
    end = time.monotonic() + 600
    while True:
        found = []
        for task in Path(f"/proc/{nanny}/task").iterdir():
            with suppress(OSError):
                found += map(int, (task / "children").read_text().split())
        if workers := [child for child in found if b"spawn_main" in read_command(child)]:
            return workers
        assert time.monotonic() < end
        time.sleep(0.05)


def finish(run, start, cwd, rows):
    """Resume a run to its end; it is then that of a run that nothing happened to."""
    done = run("resume", "run", "--workers", 1, cwd=cwd)
    assert done.returncode == 0, done.stderr
    whole = run(*start, "--workers", 1, "--out", "whole", cwd=cwd)
    assert whole.returncode == 0, whole.stderr
    found, expected = ({row[:-1] if len(row) > 4 else row for row in rows(cwd / name)} for name in ("run", "whole"))
    assert found == expected


def test_a_run_that_is_killed_a_hundred_times_loses_no_row_that_was_shown(
    start, run, rows, tmp_path, count_of, show_row
):
    kills, dice = count_of("KILLS", 100), random.Random(1)
    # Half a second of flights is written at once, which are 25.
    study = (*STUDY, "--evaluations", 60 * kills)
    stored, early = set(), 0
    for number in range(kills):
        words = ("resume", "run") if (tmp_path / "run" / "resolved.toml").exists() else (*study, *PAUSE)
        with start(*words, "--workers", 1, cwd=tmp_path) as process:
            if number % 4:
                # In the middle of its work; otherwise at any moment, also while it starts.
                wait_for_rows(tmp_path / "run", len(stored) + dice.randrange(1, 6), process)
                time.sleep(dice.uniform(0, 0.05))
            else:
                time.sleep(dice.uniform(0, 3))
            shown = read_rows(tmp_path / "run")
            assert process.poll() is None, process.communicate()[1]
            process.kill()
            process.communicate()
        left = read_rows(tmp_path / "run")
        assert stored | shown <= left
        early += left == stored
        stored = left
    finish(run, study, tmp_path, rows)
    show_row(
        "trials",
        "a run killed by SIGKILL",
        kills,
        f"{early} of them before a new row; every row is kept; the end is that of a whole run",
    )


SIGNALS = [signal.SIGKILL, signal.SIGTERM, signal.SIGINT]


@dataclass(frozen=True)
class Cluster:
    """What the trials of clusters have in common."""

    start: Any
    dask: Any
    scheduler: Any
    run: Any
    rows: Any
    folder: Path
    count: int
    show: Any

    def work(self, address, *options):
        """Start a worker, or a nanny with one."""
        return self.dask("worker", address, "--nthreads", 1, "--no-dashboard", *options, cwd=self.folder)

    def go_on(self, study, address):
        """Start the run, or resume it."""
        words = ("resume", "run") if (self.folder / "run" / "run.db").exists() else (*study, *PAUSE)
        return self.start(*words, "--scheduler", address, cwd=self.folder)

    def wait(self, rows, process):
        """Return the rows, once there are so many, of a run that goes on."""
        wait_for_rows(self.folder / "run", rows, process)
        assert process.poll() is None, process.communicate()[1]
        return read_rows(self.folder / "run")

    def finish(self, study, what, found):
        finish(self.run, study, self.folder, self.rows)
        self.show("trials", f"{what} of a cluster that has stored rows", self.count, found)


@pytest.fixture
def cluster(start, dask, dask_scheduler, run, rows, tmp_path, count_of, show_row):
    return Cluster(start, dask, dask_scheduler, run, rows, tmp_path, count_of("SIGNALS", 40), show_row)


def send(process, number):
    with suppress(ProcessLookupError):
        os.kill(process, number)


def read_command(process):
    try:
        return Path(f"/proc/{process}/cmdline").read_bytes()
    except OSError:
        return b""


@pytest.mark.peers
@pytest.mark.parametrize("number", SIGNALS, ids=lambda number: number.name)
def test_a_cluster_that_loses_workers_loses_no_row(cluster, number):
    study, stored = (*STUDY, "--evaluations", 40 * cluster.count), set()
    with cluster.scheduler() as (address, _), ExitStack() as nannies, cluster.go_on(study, address) as process:
        nanny = nannies.enter_context(cluster.work(address))
        for _ in range(cluster.count):
            cluster.wait(len(stored) + 3, process)
            workers = wait_for_workers(nanny.pid)
            shown = read_rows(cluster.folder / "run")
            for worker in workers:
                send(worker, number)
            if number == signal.SIGINT:
                # The nanny ends with an interrupted worker; otherwise it starts another in its place.
                nanny.wait(timeout=600)
                nanny = nannies.enter_context(cluster.work(address))
            stored = read_rows(cluster.folder / "run")
            assert shown <= stored
        wait_for_rows(cluster.folder / "run", len(stored) + 3, process)
        process.send_signal(signal.SIGINT)
        process.communicate()
        nanny.kill()
    assert stored <= read_rows(cluster.folder / "run")
    cluster.finish(study, f"{number.name} to the worker", "every row is kept; the run continues")


@pytest.mark.peers
@pytest.mark.parametrize("number", SIGNALS, ids=lambda number: number.name)
def test_a_coordinator_of_a_cluster_that_is_stopped_loses_no_row(cluster, number):
    study, stored = (*STUDY, "--evaluations", 12 * cluster.count), set()
    with cluster.scheduler() as (address, _), cluster.work(address, "--no-nanny") as worker:
        for _ in range(cluster.count):
            with cluster.go_on(study, address) as process:
                shown = cluster.wait(len(stored) + 3, process)
                process.send_signal(number)
                _, said = process.communicate(timeout=600)
            if number != signal.SIGKILL:
                assert process.returncode == 128 + number, said
                assert said.splitlines()[-1].endswith("resume with: driftform resume run"), said
            assert "Traceback" not in said
            stored = read_rows(cluster.folder / "run")
            assert shown <= stored
        worker.kill()
    cluster.finish(study, f"{number.name} to the coordinator", "every row is kept; it is resumed")


@pytest.mark.peers
@pytest.mark.parametrize("number", SIGNALS, ids=lambda number: number.name)
def test_a_cluster_that_loses_its_scheduler_loses_no_row(cluster, number):
    study, stored = (*STUDY, "--evaluations", 12 * cluster.count), set()
    for _ in range(cluster.count):
        with (
            cluster.scheduler() as (address, scheduler),
            cluster.work(address, "--no-nanny") as worker,
            cluster.go_on(study, address) as process,
        ):
            shown = cluster.wait(len(stored) + 3, process)
            send(scheduler.pid, number)
            _, said = process.communicate(timeout=600)
            worker.kill()
        assert process.returncode == 1, said
        assert "Traceback" not in said
        assert said.splitlines()[-1].endswith("resume with: driftform resume run"), said
        stored = read_rows(cluster.folder / "run")
        assert shown <= stored
    cluster.finish(study, f"{number.name} to the scheduler", "every row is kept; it is resumed")
