"""Runs of 20 000 evaluations: memory, descriptors, size and time of what evaluates, and the time of what reads them.

``EVALUATIONS=4000 uv run pytest -m slow -s tests/endurance/test_long_run.py`` shortens it.
"""

import os
import subprocess
import sys
import sysconfig
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack, suppress
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from driftform.errors import DriftformError
from driftform.runs.store import Store

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="memory and descriptors are read from /proc"),
]

PROGRAM = Path(sysconfig.get_path("scripts")) / "driftform"

WARM_UP = 2000
"""Evaluations before the first look: after them nothing is loaded or compiled any more."""

MOST_GROWTH_MB = 40.0
"""That a process may grow by between the first look and the last."""

RESUME_S = 2.0
"""CPU time of ``resume`` of a run that has ended."""

POINT = ("3", "0", "-0.2")
"""That ``pick`` asks for, m."""

COUNTS = (500, 5_000, 20_000)
"""Evaluations of a run by its own strategy, with its disturbed flights, at which the time of coordinator and workers is read."""

STUDIES = {
    "tuned": ("pipe-inspection", "--robust", "0", "--target", "TP9"),
    "evolution": ("paper", "--target", "TP9", "--strategy", "evolution", "--simulator", "native"),
}


def look(process):
    """Resident memory (MB), open descriptors and CPU time (s) of a process."""
    folder = Path(f"/proc/{process}")
    pages, times = (folder / "statm").read_text().split()[1], (folder / "stat").read_text().rpartition(")")[2].split()
    seconds = (int(times[11]) + int(times[12])) / os.sysconf("SC_CLK_TCK")
    return int(pages) * os.sysconf("SC_PAGESIZE") / 1e6, len(list((folder / "fd").iterdir())), seconds


def list_workers(process):
    children = Path(f"/proc/{process}/task/{process}/children").read_text().split()
    return [int(c) for c in children if b"spawn_main" in Path(f"/proc/{c}/cmdline").read_bytes()]


def count_done(log):
    """Return how many evaluations the last line of progress has, as in "12 s: 300/20000 evaluations"."""
    counts = [part for line in log.read_text().splitlines() for part in line.split() if "/" in part]
    numbers = [part.partition("/")[0] for part in counts if part.partition("/")[2].isdigit()]
    return max((int(number) for number in numbers if number.isdigit()), default=0)


def follow(process, log):
    """Look at a run's processes from :data:`WARM_UP` on until it ends; return what was seen of each, its own first."""
    seen = {process.pid: []}
    while process.poll() is None:
        if count_done(log) >= WARM_UP:
            with suppress(OSError):
                for number in (process.pid, *list_workers(process.pid)):
                    seen.setdefault(number, []).append(look(number))
        time.sleep(1.0)
    return list(seen.values())


def measure(cwd, *words):
    """Processor time (s) and largest memory (MB) of a command."""
    # As most people have it: what is imported is compiled once.
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    with subprocess.Popen([PROGRAM, *words], cwd=cwd, env=environment, stdout=subprocess.DEVNULL) as process:
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 0, words
    return used.ru_utime + used.ru_stime, used.ru_maxrss / 1e3


@pytest.mark.parametrize("strategy", STUDIES)
def test_a_run_of_20_000_evaluations_stays_small_and_is_read_quickly(tmp_path, strategy, count_of, show_row):
    count, log = count_of("EVALUATIONS", 20_000), tmp_path / "log"
    words = ("evolve", *STUDIES[strategy], "--seed", "1", "--evaluations", str(count), "--workers", "1", "--out", "run")
    began = time.monotonic()
    with log.open("wb") as file:
        process = subprocess.Popen([PROGRAM, *words], cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=file)
        # At its end a run flies some evaluations again, in a process of their own.
        coordinator, worker, *_ = follow(process, log)
    assert process.returncode == 0, log.read_text()[-2000:]
    each = 1e3 * (coordinator[-1][2] - coordinator[0][2]) / (count - WARM_UP)
    print(f"{strategy}: {time.monotonic() - began:.0f} s; the coordinator needs {each:.2g} ms for an evaluation")
    size = sum(file.stat().st_size for file in (tmp_path / "run").glob("run.db*")) / 1e6
    times = [measure(tmp_path, *words) for words in (("resume", "run"), ("report", "run"), ("pick", "run", *POINT))]
    parts = [coordinator, worker]
    growths = [f"{part[0][0]:.0f} to {part[-1][0]:.0f}" for part in parts]
    descriptors = f"{coordinator[0][1]} to {coordinator[-1][1]}"
    cells = [*growths, descriptors, f"{size:.0f}", *(f"{seconds:.1f}; {memory:.0f}" for seconds, memory in times)]
    show_row("long runs", f"`{strategy}`", count, *cells)
    for part in parts:
        assert part[-1][0] - part[0][0] < MOST_GROWTH_MB
        assert part[-1][1] <= part[0][1] + 2
    assert times[0][0] < RESUME_S


@pytest.mark.parametrize("place", ["this machine", "Dask"])
def test_the_coordinator_needs_little_of_an_evaluation_however_long_the_run(
    tmp_path: Path,
    place: str,
    dask: Callable[..., AbstractContextManager[Any]],
    dask_scheduler: Callable[[], AbstractContextManager[tuple[str, Any]]],
    count_of: Callable[[str, int], int],
    show_row: Callable[..., None],
) -> None:
    counts = [count for count in COUNTS if count <= count_of("EVALUATIONS", COUNTS[-1])]
    words = ["evolve", "--seed", "1", "--evaluations", str(counts[-1]), "--workers", "2", "--out", "run"]
    with ExitStack() as stack:
        others: list[int] = []
        if place == "Dask":
            address, _ = stack.enter_context(dask_scheduler())
            workers = [stack.enter_context(dask("worker", address, "--nthreads", 1, cwd=tmp_path)) for _ in range(2)]
            for worker in workers:
                stack.callback(worker.terminate)
            others = [worker.pid for worker in workers]
            words = [*words[:5], "--scheduler", address, *words[7:]]
        log = stack.enter_context((tmp_path / "log").open("wb"))
        process = stack.enter_context(subprocess.Popen([PROGRAM, *words], cwd=tmp_path, stdout=log, stderr=log))
        marks: list[tuple[int, float, float]] = []
        for wanted in (COUNTS[0] // 10, *counts):
            while (done := read_count(tmp_path / "run")) < wanted and process.poll() is None:
                time.sleep(0.2)
            pids = others or list_workers(process.pid)
            marks.append((done, look(process.pid)[2], sum(cpu_of_family(pid) for pid in pids)))
        process.terminate()
    cells = []
    for (first, own, workers_own), (done, later, workers_later) in pairwise(marks):
        mine, theirs = (1e3 * (b - a) / (done - first) for a, b in ((own, later), (workers_own, workers_later)))
        cells.append(f"{mine:.2f}; {theirs:.1f}; {theirs / mine:.0f}")
    show_row("coordinator", place, *cells)
    assert len(cells) == len(counts)


def read_count(run: Path) -> int:
    """How many evaluations a run has stored, 0 before it begins."""
    with suppress(DriftformError, OSError), Store.open(run / "run.db", read_only=True, check=False) as store:
        return store.count()
    return 0


def cpu_of_family(process: int) -> float:
    """CPU time (s) of a process and of those that it started: a Dask worker has a nanny."""
    children = [c for of in Path(f"/proc/{process}/task").glob("*/children") for c in of.read_text().split()]
    return look(process)[2] + sum(map(cpu_of_family, map(int, children)))
