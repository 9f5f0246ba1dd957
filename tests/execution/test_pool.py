"""Tasks submitted to worker groups, and the genome that a death is counted against."""

from collections import deque
from collections.abc import Sequence
from concurrent.futures import Future

import numpy as np
import pytest

from driftform.errors import InputError
from driftform.execution import ATTEMPTS, KILLS, STARTS, Job, Outcome, WorkersLostError
from driftform.execution.pool import Cause, Death, WorkerDiedError, WorkerGroup
from driftform.types import Evaluation, Genome


class FakeGroup(WorkerGroup):
    """A worker group whose tasks end when the test calls for it."""

    processes = 1

    def __init__(self) -> None:
        super().__init__({"targets": {"A": []}, "run": {"evaluation_timeout": 7.0}})
        self._tasks: list[tuple[Future[list[Outcome]], Sequence[Job]]] = []

    def submit(self, batch: Sequence[Job]) -> "Future[list[Outcome]]":
        self._tasks.append((Future(), batch))
        return self._tasks[-1][0]

    def find_death(self, error: BaseException) -> Death | None:
        return error.death if isinstance(error, WorkerDiedError) else None

    def close(self) -> None: ...

    def list_running(self) -> list[list[int]]:
        """The indices of the jobs of each unfinished task."""
        return [[job.index for job in batch] for future, batch in self._tasks if not future.done()]

    def finish(self) -> None:
        future, batch = next((f, b) for f, b in self._tasks if not f.done())
        future.set_result([(job.index, Evaluation(job.genome, np.zeros(1))) for job in batch])

    def die(self, cause: Cause = Cause.CRASH, detail: str = "SIGSEGV") -> None:
        """Die in the middle of the first task, while the others wait."""
        for number, future in enumerate(self.running):
            future.set_exception(WorkerDiedError(Death(Cause.NONE if number else cause, detail)))


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
    for index in range(2):
        for _ in range(2):
            group.take(waiting, 2)
        assert group.list_running() == [[index]]
        group.finish()
        assert [found for found, _ in group.collect()] == [index]
    # The task that was only waiting is as innocent as those that nobody has taken.
    while group.take(waiting, 2):
        pass
    assert group.list_running() == [[2, 3], [4, 5]]


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
    assert (index, evaluation.failure) == (0, "its process died 2 times (SIGSEGV)")
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


def test_deaths_before_anything_began_are_nobodys_and_after_a_few_the_run_stops() -> None:
    group, waiting = FakeGroup(), numbered(4)
    for _ in range(STARTS - 1):
        while group.take(waiting, 2):
            pass
        assert group.list_running() == [[0, 1], [2, 3]]
        group.die(Cause.START, "exit code 3")
        assert group.collect() == []
        assert group.is_busy
    while group.take(waiting, 2):
        pass
    group.die(Cause.START, "exit code 3")
    with pytest.raises(WorkersLostError, match=r"^workers cannot start here: .*\(exit code 3\)$"):
        group.collect()


def test_workers_that_start_between_deaths_are_no_reason_to_stop() -> None:
    group = FakeGroup()
    for _ in range(3 * STARTS):
        group.take(numbered(1), 1)
        group.die(Cause.START)
        assert group.collect() == []
        group.take(deque(), 1)
        assert group.list_running() == [[0]]
        group.finish()
        assert len(group.collect()) == 1


def test_a_kill_from_outside_is_not_the_fault_of_a_genome_unless_it_never_ends() -> None:
    group = FakeGroup()
    group.take(numbered(1), 1)
    for _ in range(KILLS):
        group.die(Cause.KILL, "SIGKILL")
        assert group.collect() == []
        group.take(deque(), 1)
    group.die(Cause.KILL, "SIGKILL")
    [(_, evaluation)] = group.collect()
    assert (
        evaluation.failure == "its process was killed 5 times (SIGKILL), from outside or for want of memory"
    )


def test_a_genome_that_takes_too_long_alone_fails_at_once() -> None:
    group, waiting = FakeGroup(), numbered(2)
    group.take(waiting, 2)
    group.die(Cause.TIMEOUT)
    assert group.collect() == []
    group.take(waiting, 2)
    group.die(Cause.TIMEOUT)
    [(index, evaluation)] = group.collect()
    assert index == 0
    assert evaluation.failure == "its evaluation did not end within 7 s (run.evaluation_timeout)"
    group.take(waiting, 2)
    assert group.list_running() == [[1]]
