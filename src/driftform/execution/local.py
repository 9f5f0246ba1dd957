"""Evaluations in worker processes on this machine; a crash of one does not end the run."""

import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from functools import cache, partial
from itertools import cycle
from multiprocessing.connection import wait as wait_for_any
from typing import TYPE_CHECKING, Any

from driftform.execution.jobs import Job, Outcome, T, evaluate_batch
from driftform.execution.pool import PoolExecutor, WorkerGroup
from driftform.pipeline import Pipeline
from driftform.study import Document, load_study

if TYPE_CHECKING:
    from multiprocessing.connection import Connection


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
                function() if isinstance(future.exception(), BrokenProcessPool) else future.result()
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
        super().__init__(len(document["targets"]))
        self._document = dict(document)
        self._pool: _Pool | None = None

    @property
    def is_running(self) -> bool:
        """True if the process was started and not closed."""
        return self._pool is not None

    def submit(self, batch: Sequence[Job]) -> "Future[list[Outcome]]":
        return self.start(partial(_work, batch))

    def start(self, function: Callable[[], T]) -> "Future[T]":
        """Call a function in the process, which is started if necessary."""
        if self._pool is None:
            self._pool = _Pool(self._document)
        try:
            return self._pool.submit(function)
        except BrokenProcessPool:
            # The process died while it waited for work.
            self.close()
            return self.start(function)

    def count_deaths(self, error: BaseException) -> int:
        if not isinstance(error, BrokenProcessPool):
            return 0
        self.close()
        return 1

    def close(self) -> None:
        if self._pool is not None:
            self._pool.close()
            self._pool = None


class _Pool:
    """A worker process that exits immediately when it is closed, or when this process exits."""

    def __init__(self, document: Mapping[str, Any]) -> None:
        # Spawned, not forked: the libraries behind the simulators keep threads and global state.
        context = multiprocessing.get_context("spawn")
        # Nothing is ever sent through this pipe: closing one end is the signal to exit.
        ended, self._end = context.Pipe(duplex=False)
        self._ended = ended
        self._executor = ProcessPoolExecutor(
            1, mp_context=context, initializer=_start, initargs=(dict(document), ended)
        )

    def submit(self, function: Callable[[], T]) -> "Future[T]":
        with hold_back_interrupts(), leave_out_script():
            return self._executor.submit(function)

    def close(self) -> None:
        self._end.close()
        # A process that is still importing does not watch the pipe yet, and has no work to lose.
        for process in list((getattr(self._executor, "_processes", None) or {}).values()):
            process.kill()
        self._executor.shutdown(wait=True, cancel_futures=True)
        self._ended.close()


@contextmanager
def hold_back_interrupts() -> Iterator[None]:
    """Block Ctrl-C in worker processes that start inside this context: the coordinator handles it.

    They inherit the signal mask, so that even a process that is still importing prints no traceback.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def leave_out_script() -> Iterator[None]:
    """Keep worker processes that start inside this context from importing the user's script, which they do not need.

    A script without ``if __name__ == "__main__":`` would otherwise start its run again in each of them.
    """
    names = vars(sys.modules["__main__"])
    kept: dict[str, Any] = {name: names.pop(name) for name in ("__spec__", "__file__") if name in names}
    names["__spec__"] = None
    try:
        yield
    finally:
        names.update(kept)


_document: Mapping[str, Any]


def _start(document: Mapping[str, Any], ended: "Connection[Any, Any]") -> None:
    global _document  # noqa: PLW0603 - a worker process has one study
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_exit_with_coordinator, args=(ended,), daemon=True).start()
    _document = document


def _exit_with_coordinator(ended: "Connection[Any, Any]") -> None:
    """Exit when the coordinator closes the pipe or dies, even in the middle of a long flight."""
    parent = multiprocessing.parent_process()
    wait_for_any([ended, *([parent.sentinel] if parent is not None else [])])
    os._exit(1)


@cache
def _load_pipeline() -> Pipeline:
    # Made by the first task: an exception is then the error of that task, and not a dead process.
    return load_study(Document("the study", _document)).make_pipeline()


def _work(batch: Sequence[Job]) -> list[Outcome]:
    return evaluate_batch(_load_pipeline(), batch)
