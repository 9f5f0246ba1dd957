"""Evaluations in worker processes on this machine; a crash of one does not end the run."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from functools import partial
from itertools import cycle
from typing import Any

from driftform.execution.jobs import Job, Outcome, T
from driftform.execution.pool import Death, PoolExecutor, WorkerDiedError, WorkerGroup
from driftform.execution.worker import Worker, work


class LocalProcesses(PoolExecutor):
    """Evaluates in worker processes on this machine, each a worker group."""

    def __init__(self, document: Mapping[str, Any], workers: int) -> None:
        self._processes = [_Process(document) for _ in range(workers)]
        super().__init__(self._processes)

    def call(self, functions: "Sequence[Callable[[], T]]") -> list[T]:
        """Call functions in the processes that run already, in turn, and return what they return, in their order.

        Functions and results must be picklable. A function whose process dies is called again in this process.
        """
        running = [process for process in self._processes if process.is_running]
        if not running:
            return super().call(functions)
        started = [process.start(function) for process, function in zip(cycle(running), functions)]
        try:
            return [
                function() if isinstance(future.exception(), WorkerDiedError) else future.result()
                for future, function in zip(started, functions, strict=True)
            ]
        except BaseException:
            # Nothing may be written any more once the caller knows of the error.
            self.close()
            raise


class _Process(WorkerGroup):
    """One worker process; it starts with the first task, and again after it died."""

    processes = 1

    def __init__(self, document: Mapping[str, Any]) -> None:
        super().__init__(document)
        self._document = document
        self._worker: Worker | None = None

    @property
    def is_running(self) -> bool:
        """True if the process was started and not closed."""
        return self._worker is not None

    def submit(self, batch: Sequence[Job]) -> "Future[list[Outcome]]":
        return self.start(partial(work, batch))

    def start(self, function: Callable[[], T]) -> "Future[T]":
        """Call a function in the process, which is started if necessary."""
        future = None if self._worker is None else self._worker.submit(function)
        while future is None:
            # There is no process, or it died while it waited for work.
            self.close()
            self._worker = Worker(self._document, self.timeout)
            future = self._worker.submit(function)
        return future

    def find_death(self, error: BaseException) -> Death | None:
        return error.death if isinstance(error, WorkerDiedError) else None

    def close(self) -> None:
        if self._worker is not None:
            self._worker.close()
            self._worker = None
