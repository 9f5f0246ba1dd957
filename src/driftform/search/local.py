"""Evaluations on this machine: in this process, or in worker processes, of which a crash does not end the run."""

from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from functools import partial
from typing import Any

from driftform.pipeline import Pipeline
from driftform.search.jobs import (
    ATTEMPTS,
    FunctionDiedError,
    Job,
    Outcome,
    T,
    WorkerDiedError,
    evaluate_batch,
    rehearse,
    task_size,
)
from driftform.search.pool import PoolExecutor
from driftform.search.worker import Worker, use_pipeline
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
        self._workers, self.processes = [Worker(document) for _ in range(workers)], workers

    def start(self, count: int) -> None:
        """Start ``count`` of the processes, or all; they load what they need while the caller prepares their first tasks."""
        for number, worker in enumerate(self._workers[:count]):
            # If that fails, the first evaluation fails alike, and reports it.
            worker.start(partial(use_pipeline, rehearse, number == 0))

    def _submit(self, function: Callable[[], T]) -> "Future[T]":
        return min(self._workers, key=lambda worker: worker.tasks or 0).start(function)

    def call(self, functions: "Sequence[Callable[[], T]]") -> list[T]:
        """Call functions in the worker processes, at the same time, and return what they return, in their order.

        Functions and results must be picklable. A function whose process dies is called again in a new one.

        Raises FunctionDiedError if a process dies :data:`ATTEMPTS` times of the same function.
        """
        try:
            results = []
            for index, wait_for_result in enumerate([self._begin(function, ATTEMPTS) for function in functions]):
                try:
                    results.append(wait_for_result())
                except WorkerDiedError as error:
                    text = f"its process died {ATTEMPTS} times ({error.detail})"
                    raise FunctionDiedError(index, text) from None
        except BaseException:
            # Nothing may be written any more once the caller knows of the error.
            self.close()
            raise
        return results

    def close(self) -> None:
        """End the processes at once; their tasks are lost."""
        for worker in self._workers:
            worker.close()
