"""Tasks of an executor, and the genome that a death is counted against."""

from collections import deque
from concurrent.futures import Future

import numpy as np
import pytest

from driftform.errors import InputError
from driftform.search.jobs import ATTEMPTS, Cause, Job, WorkerDiedError, WorkersLostError
from driftform.search.pool import Executor
from driftform.types import Evaluation, Genome

CRASH = WorkerDiedError(Cause.DEATH, "SIGSEGV")
START, TIMEOUT = WorkerDiedError(Cause.START, "exit code 3"), WorkerDiedError(Cause.TIMEOUT)


class FakePool(Executor):
    """One process: each poll ends its first task as the script says, or by success at the end of the script."""

    processes = 1

    def __init__(self, *script):
        super().__init__(1, 7.0)
        self._script = deque(script)
        self._tasks = deque()
        self.seen = []
        """Before each end, the jobs of each task."""

    def _submit(self, function, batch):
        self._tasks.append((Future(), batch))
        return self._tasks[-1][0]

    def _poll(self):
        self.seen.append([[job.index for job in batch] for _, batch in self._tasks])
        future, batch = self._tasks.popleft()
        error = self._script.popleft() if self._script else None
        if error is None:
            future.set_result([(job.index, Evaluation(job.genome, np.zeros(1))) for job in batch])
            return
        future.set_exception(error)
        while self._tasks and isinstance(error, WorkerDiedError):
            self._tasks.popleft()[0].set_exception(WorkerDiedError(Cause.NONE))


def jobs_of(name, count):
    return [Job(index, Genome(name, (str(index),))) for index in range(count)]


def failures(executor, count):
    return {index: evaluation.failure for some in executor.evaluate(jobs_of("g", count)) for index, evaluation in some}


def test_a_process_has_one_task_ready_while_another_runs():
    executor = FakePool()
    assert failures(executor, 8) == dict.fromkeys(range(8))
    assert executor.seen[:2] == [[[0, 1, 2, 3], [4, 5]], [[4, 5], [6]]]


def test_genomes_that_a_death_interrupted_are_evaluated_again_one_by_one():
    executor = FakePool(CRASH)
    assert failures(executor, 6) == dict.fromkeys(range(6))
    # The task that was only waiting is as innocent as genomes in no task.
    assert executor.seen[:4] == [[[0, 1, 2], [3, 4]], [[0], [1]], [[1], [2]], [[2], [3, 4]]]


@pytest.mark.parametrize(
    ("deaths", "failure"),
    [
        ([CRASH] * (ATTEMPTS - 1), None),
        ([CRASH] * ATTEMPTS, "its process died 5 times (SIGSEGV)"),
        ([TIMEOUT], "its evaluation did not end within 7 s (run.evaluation_timeout)"),
        ([START] * (ATTEMPTS - 1) + [None], None),
        (([START] * (ATTEMPTS - 1) + [CRASH]) * (ATTEMPTS - 1), None),
    ],
)
def test_a_genome_alone_fails_after_so_many_deaths(deaths, failure):
    executor = FakePool(*deaths)
    assert failures(executor, 1) == {0: failure}
    # The next genome starts with no deaths, also one of another call with the same index.
    executor._script = deque(deaths[1:])
    assert failures(executor, 1) == {0: None}


def test_deaths_before_anything_began_are_blamed_on_no_genome_and_stop_the_run_after_a_few():
    executor = FakePool(*[START] * ATTEMPTS)
    with pytest.raises(WorkersLostError, match=r"^workers cannot start here: .*\(exit code 3\)$"):
        failures(executor, 6)
    assert executor.seen[0] == executor.seen[-1]


def test_an_error_that_is_not_a_death_is_raised():
    with pytest.raises(InputError, match="no such plugin"):
        failures(FakePool(InputError("no such plugin")), 1)


def flat(outcomes):
    return [(index, evaluation.genome.grammar) for some in outcomes for index, evaluation in some]


def test_jobs_may_be_added_while_others_are_evaluated():
    waiting = deque(jobs_of("first", 3))
    outcomes = FakePool().evaluate(waiting)
    found = flat([next(outcomes)])
    waiting.extend(jobs_of("next", 4))
    found += flat(outcomes)
    assert sorted(found) == sorted([(i, "first") for i in range(3)] + [(i, "next") for i in range(4)])


def test_a_call_within_another_gets_its_own_outcomes_and_loses_none_of_the_other():
    executor = FakePool()
    outer = executor.evaluate(jobs_of("outer", 40))
    found = flat([next(outer)])
    # Equal indices tell nothing: the calls number their jobs alike.
    assert sorted(flat(executor.evaluate(jobs_of("inner", 5)))) == [(index, "inner") for index in range(5)]
    found += flat(outer)
    assert sorted(found) == [(index, "outer") for index in range(40)]


def test_a_call_that_was_given_up_does_not_disturb_the_next():
    executor = FakePool()
    given_up = executor.evaluate(jobs_of("given up", 40))
    next(given_up)
    given_up.close()
    assert sorted(flat(executor.evaluate(jobs_of("next", 5)))) == [(index, "next") for index in range(5)]


class Dying(FakePool):
    """Each call ends at once, as the script says."""

    def _submit(self, function, *_):
        self.seen.append(function)
        future = Future()
        error = self._script.popleft() if self._script else None
        future.set_result("a shape") if error is None else future.set_exception(error)
        return future


def test_a_call_is_repeated_where_its_process_dies_and_so_is_its_result():
    executor = Dying(CRASH, START, WorkerDiedError(Cause.NONE))
    wait_for_shape = executor.begin(min, 1)
    assert wait_for_shape() == wait_for_shape() == "a shape"
    assert len(executor.seen) == 4
    with pytest.raises(WorkerDiedError, match="SIGSEGV"):
        Dying(*[CRASH] * ATTEMPTS).begin(min, 1)()
    broken = Dying(InputError("it has no plugin"))
    with pytest.raises(InputError, match="no plugin"):
        broken.begin(min, 1)()
    assert len(broken.seen) == 1
