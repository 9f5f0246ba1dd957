"""Tasks submitted to worker groups, and the genome that a death is counted against."""

from collections import deque
from collections.abc import Iterable, Sequence
from concurrent.futures import Future

import numpy as np
import pytest

from driftform.errors import InputError
from driftform.search.jobs import ATTEMPTS, KILLS, STARTS, Job, Outcome, WorkersLostError
from driftform.search.pool import Call, Cause, Death, PoolExecutor, WorkerDiedError, WorkerGroup
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


def numbered(count: int) -> Call:
    return Call(deque(Job(index, Genome("g", (str(index),))) for index in range(count)))


def test_a_process_has_a_task_ready_beside_the_running_one() -> None:
    group, waiting = FakeGroup(), numbered(6)
    assert [group.take(waiting, 2) for _ in range(3)] == [True, True, False]
    assert group.list_running() == [[0, 1], [2, 3]]
    group.finish()
    assert [job.index for job, _ in group.collect()] == [0, 1]
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
        assert [job.index for job, _ in group.collect()] == [index]
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
    [(job, evaluation)] = group.collect()
    assert (job.index, evaluation.failure) == (0, "its process died 2 times (SIGSEGV)")
    # The next genome starts with no deaths, and so does a genome of another run with the same index.
    for found in ([], [(1, None)]):
        group.take(waiting, 2)
        assert group.list_running() == [[1]]
        group.finish() if found else group.die()
        assert [(job.index, evaluation.failure) for job, evaluation in group.collect()] == found
    group.take(numbered(2), 2)
    group.die()
    assert group.collect() == []
    group.take(waiting, 2)
    group.die()
    assert group.collect() == []


@pytest.mark.parametrize("answer", [(1, "0"), (0, "1")], ids=["index", "genome"])
def test_an_answer_to_what_was_not_asked_is_a_death(answer: tuple[int, str]) -> None:
    group, waiting, renewed = FakeGroup(), numbered(1), []
    group.renew = lambda: renewed.append(True)  # type: ignore[method-assign]
    index, symbol = answer
    for _ in range(ATTEMPTS + 1):
        group.take(waiting, 1)
        [future] = group.running
        future.set_result([(index, Evaluation(Genome("g", (symbol,)), np.zeros(1)))])
        found = group.collect()
    [(job, evaluation)] = found
    assert job.index == 0 and len(renewed) == ATTEMPTS + 1
    assert evaluation.failure == f"its process died {ATTEMPTS} times (it answered what it was not asked)"


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
        group.take(numbered(0), 1)
        assert group.list_running() == [[0]]
        group.finish()
        assert len(group.collect()) == 1


def test_a_kill_from_outside_is_not_the_fault_of_a_genome_unless_it_never_ends() -> None:
    group = FakeGroup()
    group.take(numbered(1), 1)
    for _ in range(KILLS):
        group.die(Cause.KILL, "SIGKILL")
        assert group.collect() == []
        group.take(numbered(0), 1)
    group.die(Cause.KILL, "SIGKILL")
    [(_, evaluation)] = group.collect()
    assert evaluation.failure == "its process was killed 5 times (SIGKILL), from outside or for want of memory"


def test_a_genome_that_takes_too_long_alone_fails_at_once() -> None:
    group, waiting = FakeGroup(), numbered(2)
    group.take(waiting, 2)
    group.die(Cause.TIMEOUT)
    assert group.collect() == []
    group.take(waiting, 2)
    group.die(Cause.TIMEOUT)
    [(job, evaluation)] = group.collect()
    assert job.index == 0
    assert evaluation.failure == "its evaluation did not end within 7 s (run.evaluation_timeout)"
    group.take(waiting, 2)
    assert group.list_running() == [[1]]


class Instant(FakeGroup):
    """A worker group whose tasks are done when the coordinator looks for them, the first one first."""

    def poll(self) -> None:
        if self.list_running():
            self.finish()

    @property
    def running(self) -> Sequence["Future[list[Outcome]]"]:
        return []


class InstantPool(PoolExecutor):
    def call(self, functions):
        return [function() for function in functions]


def jobs_of(name: str, count: int) -> list[Job]:
    return [Job(index, Genome(name, (str(index),))) for index in range(count)]


def flat(outcomes: Iterable[Sequence[Outcome]]) -> list[tuple[int, str]]:
    return [(index, evaluation.genome.grammar) for some in outcomes for index, evaluation in some]


def test_jobs_may_be_added_while_others_are_evaluated() -> None:
    waiting = deque(jobs_of("first", 3))
    outcomes = InstantPool([Instant()]).evaluate(waiting)
    found = flat([next(outcomes)])
    waiting.extend(jobs_of("next", 4))
    found += flat(outcomes)
    assert sorted(found) == sorted([(i, "first") for i in range(3)] + [(i, "next") for i in range(4)])


def test_a_call_within_another_gets_its_own_outcomes_and_loses_none_of_the_other() -> None:
    executor = InstantPool([Instant(), Instant()])
    outer = executor.evaluate(jobs_of("outer", 40))
    found = flat([next(outer)])
    # Equal indices tell nothing: the calls number their jobs alike.
    assert sorted(flat(executor.evaluate(jobs_of("inner", 5)))) == [(index, "inner") for index in range(5)]
    found += flat(outer)
    assert sorted(found) == [(index, "outer") for index in range(40)]


def test_a_call_that_was_given_up_does_not_disturb_the_next() -> None:
    executor = InstantPool([Instant()])
    given_up = executor.evaluate(jobs_of("given up", 40))
    next(given_up)
    given_up.close()
    assert sorted(flat(executor.evaluate(jobs_of("next", 5)))) == [(index, "next") for index in range(5)]
