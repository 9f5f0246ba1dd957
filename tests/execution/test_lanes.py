"""Tasks handed out to groups of workers, and which genome a death is counted against."""

from collections import deque
from collections.abc import Sequence
from concurrent.futures import Future

import numpy as np
import pytest

from driftform.errors import InputError
from driftform.execution import ATTEMPTS, Job, Outcome
from driftform.execution.lanes import WorkerGroup
from driftform.types import Evaluation, Genome


class Pretended(WorkerGroup):
    """A lane whose tasks end when the test says so."""

    processes = 1

    def __init__(self) -> None:
        super().__init__(targets=1)
        self._tasks: list[tuple[Future[list[Outcome]], Sequence[Job]]] = []

    def submit(self, batch: Sequence[Job]) -> "Future[list[Outcome]]":
        self._tasks.append((Future(), batch))
        return self._tasks[-1][0]

    def deaths(self, error: BaseException) -> int:
        return int(isinstance(error, ChildProcessError))

    def close(self) -> None: ...

    def under_way(self) -> list[list[int]]:
        """The evaluations of each task that is not done."""
        return [[job.index for job in batch] for future, batch in self._tasks if not future.done()]

    def finish(self) -> None:
        future, batch = next((f, b) for f, b in self._tasks if not f.done())
        future.set_result([(job.index, Evaluation(job.genome, np.zeros(1))) for job in batch])

    def die(self) -> None:
        for future in self.running:
            future.set_exception(ChildProcessError())


def numbered(count: int) -> deque[Job]:
    return deque(Job(index, Genome("g", (str(index),))) for index in range(count))


def test_a_process_has_a_task_ready_beside_the_one_under_way() -> None:
    lane, waiting = Pretended(), numbered(6)
    assert [lane.take(waiting, 2) for _ in range(3)] == [True, True, False]
    assert lane.under_way() == [[0, 1], [2, 3]]
    lane.finish()
    assert [index for index, _ in lane.collect()] == [0, 1]
    assert lane.take(waiting, 3)
    assert lane.under_way() == [[2, 3], [4, 5]]


def test_what_a_death_took_along_is_tried_one_by_one_and_alone() -> None:
    lane, waiting = Pretended(), numbered(6)
    while lane.take(waiting, 2):
        pass
    lane.die()
    assert lane.collect() == []
    for index in range(4):
        for _ in range(2):
            lane.take(waiting, 2)
        assert lane.under_way() == [[index]]
        lane.finish()
        assert [found for found, _ in lane.collect()] == [index]
    assert lane.take(waiting, 2)
    assert lane.under_way() == [[4, 5]]


def test_alone_and_dead_too_often_a_genome_has_failed() -> None:
    lane, waiting = Pretended(), numbered(2)
    lane.take(waiting, 2)
    lane.die()
    for _ in range(ATTEMPTS):
        assert lane.collect() == []
        lane.take(waiting, 2)
        assert lane.under_way() == [[0]]
        lane.die()
    [(index, evaluation)] = lane.collect()
    assert (index, evaluation.failure) == (0, "its process died 2 times")
    # The next one starts with a clean sheet, and so does a genome of another run with the same index.
    for found in ([], [(1, None)]):
        lane.take(waiting, 2)
        assert lane.under_way() == [[1]]
        lane.finish() if found else lane.die()
        assert [(index, evaluation.failure) for index, evaluation in lane.collect()] == found
    lane.take(numbered(2), 2)
    lane.die()
    assert lane.collect() == []
    lane.take(waiting, 2)
    lane.die()
    assert lane.collect() == []


def test_what_no_death_explains_is_raised() -> None:
    lane = Pretended()
    lane.take(numbered(1), 1)
    lane.running[0].set_exception(InputError("no such plugin"))
    with pytest.raises(InputError, match="no such plugin"):
        lane.collect()
