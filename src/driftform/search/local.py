"""Evaluations in worker processes on this machine; a crash of one does not end the run."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from functools import partial
from itertools import cycle
from typing import Any

from driftform.search.jobs import ATTEMPTS, FunctionDiedError, Job, Outcome, T
from driftform.search.pool import Cause, PoolExecutor, WorkerDiedError, WorkerGroup
from driftform.search.worker import Worker, prepare, work


class LocalProcesses(PoolExecutor):
    """Evaluates in worker processes on this machine, each a worker group."""

    def __init__(self, document: Mapping[str, Any], workers: int) -> None:
        self._processes = [_Process(document, rehearses=number == 1) for number in range(workers)]
        super().__init__(self._processes)

    def start(self, count: int) -> None:
        """Start ``count`` of the processes, or all; they load what they need while the caller prepares their first tasks."""
        for process in self._processes[:count]:
            # If that fails, the first evaluation fails alike, and reports it.
            process.start(prepare)

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
            while len(results) < len(functions):
                missing = [index for index in range(len(functions)) if index not in results]
                started = [
                    (index, process.start(functions[index])) for process, index in zip(cycle(processes), missing)
                ]
                for index, future in started:
                    try:
                        results[index] = future.result()
                    except WorkerDiedError as error:
                        # The tasks that were waiting in the same process did not begin.
                        deaths[index] += error.death.cause is not Cause.NONE
                        if deaths[index] == ATTEMPTS:
                            raise FunctionDiedError(
                                index, f"its process died {ATTEMPTS} times ({error.death.detail})"
                            ) from None
        except BaseException:
            # Nothing may be written any more once the caller knows of the error.
            self.close()
            raise
        return [results[index] for index in range(len(functions))]


class _Process(WorkerGroup):
    """One worker process; it starts with the first task, if not before, and again after it died."""

    processes = 1

    def __init__(self, document: Mapping[str, Any], *, rehearses: bool) -> None:
        super().__init__(document)
        self._document = document
        self._rehearses = rehearses
        self._worker: Worker | None = None

    @property
    def is_running(self) -> bool:
        """True if the process was started and not closed."""
        return self._worker is not None

    def submit(self, batch: Sequence[Job]) -> "Future[list[Outcome]]":
        # Only once: a process that died in its rehearsal evaluates without.
        rehearses, self._rehearses = self._rehearses, False
        return self.start(partial(work, batch, rehearses=rehearses))

    def start(self, function: Callable[[], T]) -> "Future[T]":
        """Call a function in the process, which is started if necessary."""
        future = None if self._worker is None else self._worker.submit(function)
        while future is None:
            # There is no process, or it died while it waited for work.
            self.close()
            self._worker = Worker(self._document, self.timeout)
            future = self._worker.submit(function)
        return future

    def renew(self) -> None:
        self.close()

    def close(self) -> None:
        if self._worker is not None:
            self._worker.close()
            self._worker = None
