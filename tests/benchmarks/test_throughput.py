"""What a long run costs beside its flights, whether it slows down or grows, and what a second Dask worker brings.

Run by hand: ``pytest -m slow -s tests/benchmarks/test_throughput.py``, ``EVALUATIONS=5000`` for a shorter one and
``SIMULATOR=fake`` for flights that cost no CPU time: on a machine that does other things as well, they tell what the
machinery does.
"""

import os
import pickle
import re
import shutil
import subprocess
import sys
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, closing
from dataclasses import dataclass
from itertools import chain, cycle
from pathlib import Path

import numpy as np
import pytest

from driftform.runs.store import Store
from driftform.search.cluster import Cluster
from driftform.search.jobs import Job, Outcome
from driftform.search.local import InProcess, LocalProcesses
from driftform.search.loop import run_search
from driftform.search.pool import PoolExecutor
from driftform.study import Study, load_study

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="CPU time and memory are read from /proc"),
]

MEGABYTES = 500
OVERHEAD = 0.3
"""CPU time of store and strategy for an evaluation, at most, ms."""

GROUP = 8
"""Evaluations in a commit; with two workers there are rather more."""

TICK = 1 / os.sysconf("SC_CLK_TCK")
LINE = re.compile(r"(\d+)/\d+ evaluations")


class Replayed:
    """Outcomes as workers send them, again and again: what is left of a run when its flights cost nothing."""

    def __init__(self, study: Study, count: int = 400) -> None:
        grammar, rng = study.make_plugin("grammar"), np.random.default_rng(1)
        jobs = [Job(index, grammar.random(rng)) for index in range(count)]
        outcomes = list(chain.from_iterable(InProcess(study.make_pipeline()).evaluate(jobs)))
        self._sent = cycle([pickle.dumps(outcomes[i : i + GROUP]) for i in range(0, count, GROUP)])

    def evaluate(self, jobs: deque[Job]) -> Iterator[list[Outcome]]:
        while jobs:
            group = [jobs.popleft() for _ in range(min(GROUP, len(jobs)))]
            outcomes = pickle.loads(next(self._sent))
            yield [(job.index, evaluation) for job, (_, evaluation) in zip(group, outcomes, strict=False)]


def test_what_store_and_strategy_take_for_an_evaluation(tmp_path: Path) -> None:
    count = 4000
    lines = ["| strategy | unpickle, store, tell and ask, ms CPU each | bytes from a worker |", "|---|---|---|"]
    taken = {}
    for strategy in ("random", "paper"):
        use = {"simulator": "native", "strategy": strategy}
        study = load_study("paper", use=use, run={"seed": 1, "evaluations": count})
        replayed, times = Replayed(study), []
        for attempt in range(3):
            with Store.create(tmp_path / f"{strategy}-{attempt}.db", dict(study.document)) as store:
                began = time.process_time()
                run_search(study, store, replayed)
                times.append(1e3 * (time.process_time() - began) / count)
        taken[strategy] = min(times)
        size = sum(len(next(replayed._sent)) for _ in range(50)) / (50 * GROUP)
        lines.append(f"| {strategy} | {taken[strategy]:.3f} | {size:.0f} |")
    lines += ["", f"The best of three runs of {count} evaluations, {GROUP} to a commit."]
    print("", *lines, sep="\n")
    assert max(taken.values()) < OVERHEAD


@dataclass(frozen=True)
class Mark:
    """Where a run stands: evaluations, time, and CPU time (s) of its coordinator and of its workers."""

    done: int
    wall: float
    coordinator: float
    workers: float

    @property
    def cpu(self) -> float:
        return self.coordinator + self.workers


def cpu(process: str) -> float:
    """CPU time of a process, s; none of one that has ended."""
    try:
        fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) * TICK


def children(process: int) -> list[str]:
    """Processes that a process has started, by any of its threads."""
    return [child for task in Path(f"/proc/{process}/task").glob("*/children") for child in task.read_text().split()]


def marks(process: subprocess.Popen[str]) -> Iterator[Mark]:
    """A mark for each generation that the run tells of."""
    assert process.stderr is not None
    for line in process.stderr:
        if found := LINE.match(line):
            workers = sum(map(cpu, children(process.pid)))
            yield Mark(int(found[1]), time.monotonic(), cpu(str(process.pid)), workers)


def test_a_long_run_neither_slows_down_nor_grows(
    start: Callable[..., subprocess.Popen[str]], count_of: Callable[[str, int], int], tmp_path: Path
) -> None:
    count, simulator = count_of("EVALUATIONS", 100_000), os.environ.get("SIMULATOR", "native")
    lines = [
        "| simulator | strategy | evaluations | a second | end over beginning | the same by CPU time "
        "| coordinator, ms CPU each | coordinator, MB |",
        "|---|---|---|---|---|---|---|---|",
    ]
    found = {}
    for strategy in ("random", "paper"):
        options = ("--simulator", simulator, "--strategy", strategy, "--evaluations", count, "--workers", 2)
        told, most = [], 0.0
        with start("evolve", *options, "--seed", 1, "--out", strategy, cwd=tmp_path) as process:
            for mark in marks(process):
                told.append(mark)
                most = max(most, peak(process.pid))
            assert process.wait() == 0
        assert told[-1].done == count
        shutil.rmtree(tmp_path / strategy)
        # In the first tenth the workers get warm.
        tenth = count // 10
        begin, end = part(told, tenth, 2 * tenth), part(told, count - tenth, count)
        whole = part(told, tenth, count)
        overhead = 1e3 * each(whole, "coordinator")
        by_wall = each(begin, "wall") / each(end, "wall")
        by_cpu = each(begin, "cpu") / each(end, "cpu")
        found[strategy] = (most, by_cpu)
        lines.append(
            f"| {simulator} | {strategy} | {count} | {1 / each(whole, 'wall'):.0f} | {by_wall:.3f} | {by_cpu:.3f} "
            f"| {overhead:.3f} | {most:.0f} |"
        )
    print("", *lines, sep="\n")
    assert max(most for most, _ in found.values()) < MEGABYTES
    # A search that gets better flies other agents than it began with, and those take their own time.
    assert found["random"][1] > 0.9


def part(told: list[Mark], first: int, last: int) -> tuple[Mark, Mark]:
    """The marks closest to two numbers of evaluations."""
    return (min(told, key=lambda mark: abs(mark.done - first)), min(told, key=lambda mark: abs(mark.done - last)))


def each(marks: tuple[Mark, Mark], what: str) -> float:
    """Seconds of something for each evaluation between two marks."""
    first, last = marks
    return float((getattr(last, what) - getattr(first, what)) / (last.done - first.done))


def peak(process: int) -> float:
    """The largest memory that a process has had in RAM, MB."""
    try:
        status = Path(f"/proc/{process}/status").read_text()
    except OSError:
        return 0.0
    found = re.search(r"VmHWM:\s+(\d+) kB", status)
    return int(found[1]) / 1e3 if found else 0.0


def test_a_second_dask_worker_almost_doubles_the_rate(
    dask: Callable[..., AbstractContextManager[object]],
    dask_scheduler: Callable[[], AbstractContextManager[tuple[str, object]]],
    fakes: None,
    count_of: Callable[[str, int], int],
    tmp_path: Path,
) -> None:
    count, simulator = count_of("EVALUATIONS", 1000), os.environ.get("SIMULATOR", "exudyn")
    settings = ["simulator.pause=0.03"] if simulator == "fake" else []
    study = load_study("paper", settings, use={"simulator": simulator}, run={"seed": 1})
    grammar, rng = study.make_plugin("grammar"), np.random.default_rng(1)
    jobs = [Job(index, grammar.random(rng)) for index in range(count)]
    # Beside processes of driftform's own, which tell what the machine has to give just now.
    rates = {"local": [rate(LocalProcesses(study.document, workers), jobs) for workers in (1, 2)], "dask": []}
    with dask_scheduler() as (address, _), ExitStack() as stack:
        for workers in (1, 2):
            process = stack.enter_context(dask("worker", address, "--nthreads", 1, cwd=tmp_path))
            stack.callback(process.terminate)
            # A cluster takes its first tasks before its last worker is there.
            wait_for(address, workers)
            rates["dask"].append(rate(Cluster(study.document, address), jobs))
    lines = [
        "| simulator | executor | one worker, 1/s | two workers, 1/s | ratio |",
        "|---|---|---|---|---|",
        *(f"| {simulator} | {name} | {a:.1f} | {b:.1f} | {b / a:.2f} |" for name, (a, b) in rates.items()),
        "",
        f"{count} random genomes each time.",
    ]
    print("", *lines, sep="\n")
    one, two = rates["dask"]
    assert two / one > 1.7


def rate(executor: PoolExecutor, jobs: Sequence[Job]) -> float:
    """Evaluations in a second, once all workers are under way."""
    with closing(executor):
        list(executor.evaluate(jobs[:40]))
        began = time.perf_counter()
        outcomes = list(chain.from_iterable(executor.evaluate(jobs)))
        taken = time.perf_counter() - began
    assert sorted(index for index, _ in outcomes) == [job.index for job in jobs]
    return len(jobs) / taken


def wait_for(address: str, workers: int) -> None:
    from distributed import Client

    with Client(address, set_as_default=False) as client:
        client.wait_for_workers(workers, timeout=120)
