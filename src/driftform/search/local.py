"""Evaluations in worker processes on this machine; a crash of one does not end the run."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from functools import partial
from itertools import cycle
from typing import Any

from driftform.search.jobs import ATTEMPTS, FunctionDiedError, Job, Outcome, T
from driftform.search.pool import Cause, PoolExecutor, WorkerDiedError
from driftform.search.worker import Worker, prepare, work


class LocalProcess:
    """A worker process that starts with its first task, and again after it died."""

    def __init__(self, document: Mapping[str, Any]) -> None:
        self._document = document
        self._worker: Worker | None = None

    @property
    def tasks(self) -> int:
        """Number of functions that are not answered yet."""
        return 0 if self._worker is None else self._worker.tasks

    @property
    def is_running(self) -> bool:
        """True if the process was started and not closed."""
        return self._worker is not None

    def start(self, function: Callable[[], T]) -> "Future[T]":
        """Call a function in the process, which is started if necessary."""
        future = None if self._worker is None else self._worker.submit(function)
        while future is None:
            # There is no process, or it died while it waited for work.
            self.close()
            self._worker = Worker(self._document)
            future = self._worker.submit(function)
        return future

    def close(self) -> None:
        """End the process at once; its tasks are lost."""
        if self._worker is not None:
            self._worker.close()
            self._worker = None


class LocalProcesses(PoolExecutor):
    """Evaluates in worker processes on this machine."""

    def __init__(self, document: Mapping[str, Any], workers: int) -> None:
        super().__init__(document)
        self._processes = [LocalProcess(document) for _ in range(workers)]

    @property
    def processes(self) -> int:
        """Number of worker processes."""
        return len(self._processes)

    def start(self, count: int) -> None:
        """Start ``count`` of the processes, or all; they load what they need while the caller prepares their first tasks."""
        for number, process in enumerate(self._processes[:count]):
            # If that fails, the first evaluation fails alike, and reports it.
            process.start(partial(prepare, rehearses=number == 0))

    def _submit(self, batch: Sequence[Job]) -> "Future[list[Outcome]]":
        process = min(self._processes, key=lambda process: process.tasks)
        return process.start(partial(work, batch))

    def call(self, functions: "Sequence[Callable[[], T]]") -> list[T]:
        """Call functions in the worker processes, in turn, and return what they return, in their order.

        Functions and results must be picklable. Processes that run already are preferred to new ones. A function whose
        process dies is called again in a new one.

        Raises:
            FunctionDiedError: if a process dies :data:`ATTEMPTS` times of the same function.
        """
        processes = [process for process in self._processes if process.is_running] or self._processes
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
