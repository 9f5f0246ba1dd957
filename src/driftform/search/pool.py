"""Evaluations in processes that share one queue, and the genome to blame when a process dies.

:class:`concurrent.futures.ProcessPoolExecutor` and loky give up all processes when one dies, do not say which task it had,
limit no task's time, and leave their processes behind when the coordinator is killed.
"""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from driftform.pipeline import Pipeline
from driftform.search.jobs import (
    ATTEMPTS,
    Cause,
    Job,
    Outcome,
    T,
    WorkerDiedError,
    WorkersLostError,
    evaluate_batch,
    task_size,
)
from driftform.search.worker import use_pipeline
from driftform.types import Evaluation

POLL_S = 2.0
"""Time between two polls of the workers while no task finishes, s."""


@dataclass(eq=False)
class _Call:
    """One call of :meth:`PoolExecutor.evaluate`: jobs that wait, the number that run, and outcomes to be yielded."""

    waiting: deque[Job]
    running: int = 0
    arrived: list[Outcome] = field(default_factory=list)


@dataclass(eq=False)
class _Task:
    """Jobs of a call that one process evaluates, and how often it died while it evaluated the only one of them."""

    call: _Call
    jobs: Sequence[Job]
    deaths: int = 0


class Executor:
    """Evaluates jobs, in this process or in others that share one queue: a base class.

    A task that had not begun when its process died is started again: its genomes are not to blame. If processes die
    :data:`ATTEMPTS` times as often as there are processes before any begins, the run stops.

    The genomes of a task that had begun are evaluated again one by one, so that the genome to blame is known. It fails if
    its process dies :data:`ATTEMPTS` times. One that takes more processor time than ``run.evaluation_timeout`` fails at once.

    Attributes:
        processes: number of genomes that are evaluated at the same time.
        tasks_per_process: tasks submitted for each: one running, and one ready to run next.
    """

    processes: int
    tasks_per_process = 2

    def __init__(self, targets: int, timeout: float) -> None:
        """Make an executor of genomes with so many targets, of which no evaluation may take longer than ``timeout``, s."""
        self._targets, self._timeout = targets, timeout
        self._calls: list[_Call] = []
        self._repeated: deque[_Task] = deque()
        self._running: dict[Future[list[Outcome]], _Task] = {}
        self._failed_starts = 0
        self._seconds: float | None = None

    def _start(self, function: Callable[[], T]) -> "Future[T]":
        """Call a function in the process that is free first."""
        raise NotImplementedError

    def _submit(self, function: Callable[..., T], *args: Any) -> "Future[T]":
        """Call a function with the pipeline of the study, and arguments, in the process that is free first."""
        return self._start(partial(use_pipeline, function, *args))

    def call(self, functions: Sequence[Callable[[], T]]) -> Iterator[T]:
        """Call functions on this machine, at the same time if possible, and yield what they return, in their order.

        Functions and results must be picklable. A function whose process dies is called again in a new one. Raises
        WorkerDiedError in place of a result if its function ends its process each time it is called.
        """
        try:
            for wait_for_result in [self._begin(partial(self._start, function)) for function in functions]:
                yield wait_for_result()
        except BaseException:
            # Nothing may be written any more once the caller knows of the error.
            self.close()
            raise

    def close(self) -> None:
        """Stop the workers, if there are any."""

    def _find_error(self, future: "Future[Any]") -> BaseException | None:
        """Wait for a task, and return its error, ``None`` if it succeeded."""
        return future.exception()

    def _poll(self) -> None:
        """Check the state of the workers; called at least every :data:`POLL_S`."""

    def evaluate(self, jobs: "Sequence[Job] | deque[Job]") -> Iterator[list[Outcome]]:
        """Yield the outcomes as they arrive, in any order, in batches of any size.

        Jobs may be added to a deque until the last outcome has arrived, and a call may begin while another is under way: its
        jobs come first, and the workers evaluate those of the other in the time that they have left.
        """
        call = _Call(jobs if isinstance(jobs, deque) else deque(jobs))
        self._calls.append(call)
        try:
            while call.waiting or call.running or call.arrived:
                while len(self._running) < self.tasks_per_process * self.processes and (task := self._next_task()):
                    self._running[self._submit(evaluate_batch, task.jobs)] = task
                if not call.arrived:
                    self._collect()
                if call.arrived:
                    outcomes, call.arrived = call.arrived, []
                    self._seconds = outcomes[-1][1].seconds or self._seconds
                    yield outcomes
        finally:
            self._calls.remove(call)

    def begin(self, function: Callable[..., T], *args: Any) -> Callable[[], T]:
        """Begin a call in a worker for :meth:`driftform.interfaces.SearchSpace.begin`; what it raises, the waiting raises."""
        return self._begin(partial(self._submit, _compute, function, args))

    def _begin(self, start: "Callable[[], Future[T]]") -> Callable[[], T]:
        """Start a call, and return what waits for its result; it is repeated until its process died :data:`ATTEMPTS` times."""
        futures, deaths = [start()], 0

        def wait_for_result() -> T:
            nonlocal deaths
            while (error := self._find_error(futures[-1])) is not None:
                # A call that was waiting in the process of another did not begin.
                deaths += isinstance(error, WorkerDiedError) and error.cause is not Cause.NONE
                if deaths == ATTEMPTS or not isinstance(error, WorkerDiedError):
                    raise error
                futures.append(start())
            return futures[-1].result()

        return wait_for_result

    def _next_task(self) -> _Task | None:
        if self._repeated:
            return self._repeated.popleft()
        for call in reversed(self._calls):
            if call.waiting:
                size = task_size(len(call.waiting), self.processes, self._seconds)
                call.running += size
                return _Task(call, [call.waiting.popleft() for _ in range(size)])
        return None

    def _collect(self) -> None:
        """Wait until a task ends, and keep the outcomes for the calls whose jobs they are of; raise errors of tasks."""
        self._poll()
        wait(self._running, POLL_S, FIRST_COMPLETED)
        for future in [future for future in self._running if future.done()]:
            task, error = self._running.pop(future), self._find_error(future)
            if error is None:
                self._failed_starts = 0
                self._finish(task, future.result())
            elif isinstance(error, WorkerDiedError):
                self._repeat(task, error)
            else:
                raise error

    def _finish(self, task: _Task, outcomes: Sequence[Outcome]) -> None:
        task.call.running -= len(task.jobs)
        task.call.arrived += outcomes

    def _repeat(self, task: _Task, death: WorkerDiedError) -> None:
        """Evaluate the genomes of a task again, or fail its only one."""
        if death.cause in (Cause.NONE, Cause.START):
            self._failed_starts += death.cause is Cause.START
            if self._failed_starts >= ATTEMPTS * self.processes:
                raise WorkersLostError(
                    f"workers cannot start here: {self._failed_starts} in a row died before they could evaluate anything "
                    f"({death.detail})"
                )
            self._repeated.append(task)
            return
        self._failed_starts = 0
        if len(task.jobs) > 1:
            self._repeated.extend(_Task(task.call, [job]) for job in task.jobs)
            return
        task.deaths += 1
        if death.cause is Cause.TIMEOUT:
            failure = f"its evaluation did not end within {self._timeout:g} s (run.evaluation_timeout)"
        elif task.deaths >= ATTEMPTS:
            failure = f"its process died {ATTEMPTS} times ({death.detail})"
        else:
            self._repeated.append(task)
            return
        [job] = task.jobs
        self._finish(task, [(job.index, Evaluation.failed(job.genome, self._targets, failure))])


def _compute(pipeline: Pipeline, function: Callable[..., T], args: Sequence[Any]) -> T:
    """Call a function with the grammar and the builder of the study, and arguments."""
    return function(pipeline.grammar, pipeline.builder, *args)
