"""Executors: a crash of a worker costs only the genome to blame, in local processes and on a cluster."""

import multiprocessing
import os
import signal
import sys
import time
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Future
from contextlib import closing
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from driftform.errors import InputError
from driftform.execution import ATTEMPTS, MAX_BATCH, InProcess, Job, LocalProcesses, Outcome
from driftform.execution.cluster import Cluster
from driftform.execution.jobs import MAX_TASK_S, MIN_TASK_S, task_size
from driftform.execution.pool import PoolExecutor, WorkerGroup
from driftform.study import Study, load_study
from driftform.types import Evaluation, Genome

Make = Callable[[Study], PoolExecutor]

pytestmark = pytest.mark.usefixtures("fakes")

COUNT = 24


def study_of(**options: Any) -> Study:
    settings = [f"simulator.{key}={value!r}" for key, value in options.items()]
    return load_study(None, settings, use={"simulator": "fake"}, targets=["TP1", "TP6"], run={"seed": 1})


@pytest.fixture(scope="module")
def jobs() -> list[Job]:
    grammar = load_study().make_plugin("grammar")
    rng = np.random.default_rng(5)
    return [Job(10 + index, grammar.random(rng)) for index in range(COUNT)]


@pytest.fixture(params=["local", "dask"])
def make(request: pytest.FixtureRequest) -> Make:
    """Makes an executor with two workers: local processes, or those of a running cluster."""
    if request.param == "local":
        return lambda study: LocalProcesses(study.document, 2)
    address = request.getfixturevalue("dask_cluster")
    return lambda study: Cluster.join(study.document, address)


def workers_of(executor: PoolExecutor, dask_cluster: str | None = None) -> list[int]:
    """The processes that evaluate."""
    if isinstance(executor, LocalProcesses):
        return [child.pid or 0 for child in multiprocessing.active_children()]
    from distributed import Client

    with Client(dask_cluster, set_as_default=False) as client:
        return list(client.run(os.getpid).values())


def number(genome: Any) -> float:
    from driftform_fake import number

    return float(number(genome))


def collect(outcomes: Iterable[Sequence[Outcome]]) -> dict[int, Evaluation]:
    found: dict[int, Evaluation] = {}
    for index, evaluation in chain.from_iterable(outcomes):
        assert index not in found, "an outcome arrived twice"
        found[index] = evaluation
    return found


def assert_same(a: dict[int, Evaluation], b: dict[int, Evaluation]) -> None:
    assert a.keys() == b.keys()
    for index, left in a.items():
        right = b[index]
        assert (left.genome, left.failure) == (right.genome, right.failure)
        assert left.fitness.tobytes() == right.fitness.tobytes()
        assert (left.trajectory is None) == (right.trajectory is None)
        if left.trajectory is not None and right.trajectory is not None:
            assert left.trajectory.position.tobytes() == right.trajectory.position.tobytes()


def test_workers_find_what_this_process_finds(jobs: list[Job], make: Make) -> None:
    study = study_of()
    here = collect(InProcess(study.make_pipeline()).evaluate(jobs))
    with closing(make(study)) as executor:
        there = collect(executor.evaluate(jobs))
        again = collect(executor.evaluate(jobs[:3]))
        assert collect(executor.evaluate([])) == {}
    assert sorted(here) == [job.index for job in jobs]
    assert_same(here, there)
    assert_same({job.index: here[job.index] for job in jobs[:3]}, again)


def test_a_genome_that_raises_fails_and_the_others_do_not(jobs: list[Job]) -> None:
    sound = collect(InProcess(study_of().make_pipeline()).evaluate(jobs))
    outcomes = collect(InProcess(study_of(fail=0.3).make_pipeline()).evaluate(jobs))
    guilty = {job.index for job in jobs if number(job.genome) > 0.7}
    assert 0 < len(guilty) < COUNT
    for index, evaluation in outcomes.items():
        if index in guilty:
            assert "RuntimeError: genome 0." in str(evaluation.failure)
            assert evaluation.fitness.tolist() == [0.0, 0.0]
        else:
            assert_same({index: evaluation}, {index: sound[index]})


def test_a_genome_that_kills_its_process_fails_and_all_others_are_evaluated(
    jobs: list[Job], make: Make
) -> None:
    sound = collect(InProcess(study_of().make_pipeline()).evaluate(jobs))
    guilty = {job.index for job in jobs if number(job.genome) < 0.08}
    assert 0 < len(guilty) < COUNT / 3
    with closing(make(study_of(die=0.08))) as executor:
        outcomes = collect(executor.evaluate(jobs))
    assert outcomes.keys() == sound.keys()
    for index, evaluation in outcomes.items():
        if index in guilty:
            assert evaluation.failure == f"its process died {ATTEMPTS} times"
            assert evaluation.fitness.tolist() == [0.0, 0.0]
        else:
            assert_same({index: evaluation}, {index: sound[index]})


def test_a_process_that_dies_once_is_forgiven(jobs: list[Job], make: Make, tmp_path: Path) -> None:
    options = {"die": 0.08, "die_once": str(tmp_path)}
    with closing(make(study_of(**options))) as executor:
        outcomes = collect(executor.evaluate(jobs))
    assert list(tmp_path.iterdir())
    assert_same(outcomes, collect(InProcess(study_of().make_pipeline()).evaluate(jobs)))


@pytest.mark.skipif(sys.platform == "win32", reason="sends POSIX signals")
def test_a_worker_that_is_killed_from_outside_costs_nothing(
    jobs: list[Job], make: Make, dask_cluster: str
) -> None:
    study = study_of(pause=0.05)
    found: dict[int, Evaluation] = {}
    with closing(make(study)) as executor:
        for index, evaluation in chain.from_iterable(executor.evaluate(jobs)):
            if not found:
                os.kill(workers_of(executor, dask_cluster)[0], signal.SIGKILL)
            assert index not in found
            found[index] = evaluation
        # A worker that waits for work may be killed as well.
        os.kill(workers_of(executor, dask_cluster)[0], signal.SIGKILL)
        again = collect(executor.evaluate(jobs[:2]))
    sound = collect(InProcess(study.make_pipeline()).evaluate(jobs))
    assert_same(found, sound)
    assert_same(again, {job.index: sound[job.index] for job in jobs[:2]})


def test_closing_in_the_middle_does_not_wait_and_leaves_no_process(jobs: list[Job]) -> None:
    executor = LocalProcesses(study_of(pause=1.5).document, 2)
    outcomes = iter(executor.evaluate(jobs))
    next(outcomes)
    began = time.monotonic()
    executor.close()
    assert time.monotonic() - began < 1.5
    assert multiprocessing.active_children() == []
    executor.close()


def test_an_error_in_a_study_is_raised_and_no_genome_is_blamed(jobs: list[Job], make: Make) -> None:
    study = study_of()
    broken = Study({**study.document, "simulator": {"use": "fake", "pause": -1.0}}, study.scenario, study.run)
    with closing(make(broken)) as executor, pytest.raises(InputError, match=r"simulator\.pause = -1\.0"):
        list(executor.evaluate(jobs))


# Tasks, and the worker groups that they are submitted to.


class FakeGroup(WorkerGroup):
    """A worker group whose tasks end when the test calls for it."""

    processes = 1

    def __init__(self) -> None:
        super().__init__(targets=1)
        self._tasks: list[tuple[Future[list[Outcome]], Sequence[Job]]] = []

    def submit(self, batch: Sequence[Job]) -> "Future[list[Outcome]]":
        self._tasks.append((Future(), batch))
        return self._tasks[-1][0]

    def count_deaths(self, error: BaseException) -> int:
        return int(isinstance(error, ChildProcessError))

    def close(self) -> None: ...

    def list_running(self) -> list[list[int]]:
        """The indices of the jobs of each unfinished task."""
        return [[job.index for job in batch] for future, batch in self._tasks if not future.done()]

    def finish(self) -> None:
        future, batch = next((f, b) for f, b in self._tasks if not f.done())
        future.set_result([(job.index, Evaluation(job.genome, np.zeros(1))) for job in batch])

    def die(self) -> None:
        for future in self.running:
            future.set_exception(ChildProcessError())


def numbered(count: int) -> deque[Job]:
    return deque(Job(index, Genome("g", (str(index),))) for index in range(count))


def test_a_process_has_a_task_ready_beside_the_running_one() -> None:
    group, waiting = FakeGroup(), numbered(6)
    assert [group.take(waiting, 2) for _ in range(3)] == [True, True, False]
    assert group.list_running() == [[0, 1], [2, 3]]
    group.finish()
    assert [index for index, _ in group.collect()] == [0, 1]
    assert group.take(waiting, 3)
    assert group.list_running() == [[2, 3], [4, 5]]


def test_genomes_that_a_death_interrupted_are_evaluated_again_one_by_one() -> None:
    group, waiting = FakeGroup(), numbered(6)
    while group.take(waiting, 2):
        pass
    group.die()
    assert group.collect() == []
    for index in range(4):
        for _ in range(2):
            group.take(waiting, 2)
        assert group.list_running() == [[index]]
        group.finish()
        assert [found for found, _ in group.collect()] == [index]
    assert group.take(waiting, 2)
    assert group.list_running() == [[4, 5]]


def test_a_genome_whose_process_dies_too_often_while_alone_fails() -> None:
    group, waiting = FakeGroup(), numbered(2)
    group.take(waiting, 2)
    group.die()
    for _ in range(ATTEMPTS):
        assert group.collect() == []
        group.take(waiting, 2)
        assert group.list_running() == [[0]]
        group.die()
    [(index, evaluation)] = group.collect()
    assert (index, evaluation.failure) == (0, "its process died 2 times")
    # The next genome starts with no deaths, and so does a genome of another run with the same index.
    for found in ([], [(1, None)]):
        group.take(waiting, 2)
        assert group.list_running() == [[1]]
        group.finish() if found else group.die()
        assert [(index, evaluation.failure) for index, evaluation in group.collect()] == found
    group.take(numbered(2), 2)
    group.die()
    assert group.collect() == []
    group.take(waiting, 2)
    group.die()
    assert group.collect() == []


def test_an_error_that_is_not_a_death_is_raised() -> None:
    group = FakeGroup()
    group.take(numbered(1), 1)
    group.running[0].set_exception(InputError("no such plugin"))
    with pytest.raises(InputError, match="no such plugin"):
        group.collect()


@given(st.integers(1, 10**6), st.integers(1, 500), st.none() | st.floats(0, 1e4))
def test_tasks_are_short_enough_to_be_lost_and_long_enough_to_be_worth_it(
    waiting: int, processes: int, seconds: float | None
) -> None:
    size = task_size(waiting, processes, seconds)
    assert 1 <= size <= min(MAX_BATCH, waiting)
    if seconds is not None:
        assert size == 1 or size * seconds <= MAX_TASK_S
        assert size == min(MAX_BATCH, waiting) or (size + 1) * seconds >= min(MIN_TASK_S, MAX_TASK_S)


@pytest.mark.parametrize("seconds", [0.005, 0.03, 0.2])
def test_the_tasks_of_a_generation_let_two_processes_finish_together(seconds: float) -> None:
    waiting, busy, tasks = 100, [0.0, 0.0], 0
    while waiting:
        size = task_size(waiting, 2, seconds)
        busy[busy.index(min(busy))] += size * seconds
        waiting, tasks = waiting - size, tasks + 1
    assert abs(busy[0] - busy[1]) <= max(seconds, 1.5 * MIN_TASK_S)
    assert tasks <= 30
