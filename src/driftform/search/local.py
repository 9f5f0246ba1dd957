"""Evaluations on this machine: in this process, or in worker processes, of which a crash does not end the run."""

import math
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from functools import partial
from typing import Any

from driftform.pipeline import Pipeline
from driftform.search.jobs import T, rehearse
from driftform.search.pool import Executor
from driftform.search.worker import Worker, use_pipeline
from driftform.util.files import keep_directory


class InProcess(Executor):
    """Evaluates in this process, one task at a time: for a few genomes, and for debugging."""

    processes = tasks_per_process = 1

    def __init__(self, pipeline: Pipeline) -> None:
        super().__init__(len(pipeline.scenario.targets), math.inf)
        self._pipeline = pipeline

    def _start(self, function: Callable[[], T]) -> "Future[T]":
        future: Future[T] = Future()
        with keep_directory():
            future.set_result(function())
        return future

    def _submit(self, function: Callable[..., T], *args: Any) -> "Future[T]":
        return self._start(partial(function, self._pipeline, *args))


class LocalProcesses(Executor):
    """Evaluates in worker processes on this machine.

    The first ``start`` of them load what they need at once, while the caller prepares their first tasks.
    """

    def __init__(self, document: Mapping[str, Any], workers: int, start: int = 0) -> None:
        super().__init__(len(document["targets"]), float(document["run"]["evaluation_timeout"]))
        self._workers, self.processes = [Worker(document) for _ in range(workers)], workers
        for number, worker in enumerate(self._workers[:start]):
            # If that fails, the first evaluation fails alike, and reports it.
            worker.start(partial(use_pipeline, rehearse, number == 0))

    def _start(self, function: Callable[[], T]) -> "Future[T]":
        return min(self._workers, key=Worker.count_tasks).start(function)

    def close(self) -> None:
        """End the processes at once; their tasks are lost."""
        for worker in self._workers:
            worker.close()
