"""Evaluations on this machine: in this process, or in worker processes, of which a crash does not end the run."""

from collections import Counter, deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from functools import partial
from itertools import cycle
from typing import Any

from driftform.pipeline import Pipeline
from driftform.search.jobs import (
    ATTEMPTS,
    Cause,
    FunctionDiedError,
    Job,
    Outcome,
    T,
    WorkerDiedError,
    evaluate_batch,
    task_size,
)
from driftform.search.pool import PoolExecutor
from driftform.search.worker import LocalProcess, prepare
from driftform.util.files import keep_directory


class InProcess:
    """Evaluates in this process, one task at a time: for a few genomes, and for debugging."""

    begin = None

    def __init__(self, pipeline: Pipeline) -> None:
        self._pipeline = pipeline
        self._seconds: float | None = None

    def evaluate(self, jobs: "Sequence[Job] | deque[Job]") -> Iterator[list[Outcome]]:
        """Yield the outcomes of one task after another; see :meth:`driftform.search.jobs.Executor.evaluate`."""
        waiting = jobs if isinstance(jobs, deque) else deque(jobs)
        while waiting:
            size = task_size(len(waiting), 1, self._seconds)
            with keep_directory():
                outcomes = evaluate_batch(self._pipeline, [waiting.popleft() for _ in range(size)])
            self._seconds = outcomes[0][1].seconds
            yield outcomes

    def call(self, functions: Sequence[Callable[[], T]]) -> list[T]:
        """Call functions one after the other, and return what they return."""
        with keep_directory():
            return [function() for function in functions]

    def close(self) -> None:
        """Do nothing: there are no workers to stop."""


class LocalProcesses(PoolExecutor):
    """Evaluates in worker processes on this machine."""

    def __init__(self, document: Mapping[str, Any], workers: int) -> None:
        super().__init__(document)
        self._processes, self.processes = [LocalProcess(document) for _ in range(workers)], workers

    def start(self, count: int) -> None:
        """Start ``count`` of the processes, or all; they load what they need while the caller prepares their first tasks."""
        for number, process in enumerate(self._processes[:count]):
            # If that fails, the first evaluation fails alike, and reports it.
            process.start(partial(prepare, rehearses=number == 0))

    def _submit(self, function: Callable[[], T]) -> "Future[T]":
        return min(self._processes, key=lambda process: process.worker.tasks if process.worker else 0).start(function)

    def call(self, functions: "Sequence[Callable[[], T]]") -> list[T]:
        """Call functions in the worker processes, in turn, and return what they return, in their order.

        Functions and results must be picklable. Processes that run already are preferred to new ones. A function whose
        process dies is called again in a new one.

        Raises FunctionDiedError if a process dies :data:`ATTEMPTS` times of the same function.
        """
        processes = [process for process in self._processes if process.worker is not None] or self._processes
        results: dict[int, T] = {}
        deaths: Counter[int] = Counter()
        try:
            while missing := [index for index in range(len(functions)) if index not in results]:
                started = [process.start(functions[index]) for process, index in zip(cycle(processes), missing)]
                for index, future in zip(missing, started, strict=True):
                    try:
                        results[index] = future.result()
                    except WorkerDiedError as error:
                        # The tasks that were waiting in the same process did not begin.
                        deaths[index] += error.cause is not Cause.NONE
                        if deaths[index] == ATTEMPTS:
                            text = f"its process died {ATTEMPTS} times ({error.detail})"
                            raise FunctionDiedError(index, text) from None
        except BaseException:
            # Nothing may be written any more once the caller knows of the error.
            self.close()
            raise
        return [results[index] for index in range(len(functions))]

    def close(self) -> None:
        """End the processes at once; their tasks are lost."""
        for process in self._processes:
            process.close()
