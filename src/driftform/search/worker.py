"""One worker process: the pipe to it, the tasks that it was sent, and how it ended.

The pipe has exactly two ends. A worker that dies while it sends a result therefore ends the pipe, and the coordinator
never waits for the rest of that result.
"""

import atexit
import logging
import multiprocessing
import os
import signal
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future
from contextlib import contextmanager, suppress
from functools import cache
from multiprocessing.connection import wait as wait_for_any
from multiprocessing.process import BaseProcess
from multiprocessing.reduction import ForkingPickler
from typing import TYPE_CHECKING, Any

from driftform.errors import DriftformError, WorkFailedError, describe_error
from driftform.pipeline import Pipeline
from driftform.plugins import faults
from driftform.search.jobs import Cause, T, WorkerDiedError, WorkersLostError
from driftform.study import Document, load_study
from driftform.util.files import keep_directory
from driftform.util.preparation import observe_preparation

_log = logging.getLogger(__name__)

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

TICK_S = 1.0
"""Longest time between two looks at a worker that sends nothing, s."""

PATIENCE = 10.0
"""Time that a task may wait, in times of the processor time that it may take."""

END_S = 5.0
"""Longest wait for a killed process to end, s; one that the kernel does not release stays."""


class Worker:
    """A worker process for the study of a document, which starts with its first task, and again after it died.

    It ends when it is closed, or when this process ends.
    """

    def __init__(self, document: Mapping[str, Any]) -> None:
        self._document, self._timeout = dict(document), float(document["run"]["evaluation_timeout"])
        self._lock = threading.Lock()
        self._process: BaseProcess | None = None
        self._tasks: deque[Future[Any]] = deque()

    def count_tasks(self) -> int:
        """Return the number of functions that are not answered yet."""
        return len(self._tasks)

    def start(self, function: Callable[[], T]) -> "Future[T]":
        """Call a function in the process, which is started if there is none."""
        future: Future[T] = Future()
        with self._lock:
            if self._process is None:
                self._open()
            self._tasks.append(future)
        self._send(function)
        return future

    def close(self) -> None:
        """End the process at once; its tasks are lost."""
        atexit.unregister(self.close)
        if (process := self._process) is not None:
            _kill(process)
            self._reader.join(END_S)

    def _open(self) -> None:
        # Spawned, not forked: the libraries of simulators keep threads and global state.
        context = multiprocessing.get_context("spawn")
        self._connection, theirs = context.Pipe()
        process = context.Process(target=_serve, args=(theirs,))
        try:
            with hold_back_interrupts(), leave_out_script():
                process.start()
        except OSError as error:
            raise WorkersLostError(f"workers cannot start here: {error}") from None
        except KeyboardInterrupt:
            if process.pid is not None:
                process.kill()
            raise
        finally:
            # Otherwise the pipe would not end with the worker.
            theirs.close()
        _log.info("worker process %s started", process.pid)
        self._process, self._tasks = process, deque()
        self._send(self._document)
        self._reader = threading.Thread(target=self._read, args=(process, self._connection, self._tasks), daemon=True)
        self._reader.start()
        # A script that never closes its executor ends nevertheless.
        atexit.register(self.close)

    def _send(self, message: object) -> None:
        # If the process has ended, the reader finds out, and answers for its tasks.
        with suppress(OSError):
            self._connection.send(message)

    def _read(self, process: BaseProcess, connection: "Connection[Any, Any]", tasks: deque[Future[Any]]) -> None:
        """Pass results on until the process ends or takes too long; runs in a thread of its own."""
        tick = min(TICK_S, self._timeout / 10)
        # Time that the first task may still take, s, without preparations; None before it evaluates anything.
        left: float | None = None
        pauses, since, spent = 0, time.monotonic(), _measure_processor(process)
        while left is None or left > 0:
            try:
                has_arrived = connection.poll(tick)
                now, used = time.monotonic(), _measure_processor(process)
                if left is not None and not pauses:
                    # Time in which this process was stopped does not count.
                    left -= min(now - since, 2 * tick, max(used - spent, (now - since) / PATIENCE))
                since, spent = now, used
                if not has_arrived:
                    # A process that the worker started may keep the pipe open.
                    if process.exitcode is None or connection.poll(0):
                        continue
                    break
                kind, value = connection.recv()
            except (EOFError, OSError):
                break
            except Exception as error:
                kind, value = "error", WorkFailedError(f"a result cannot be read: {describe_error(error)}")
            match kind:
                case "begun":
                    left, pauses = self._timeout, 0
                case "preparing":
                    pauses += 1 if value else -1
                case "result":
                    left = None
                    tasks.popleft().set_result(value)
                case _:
                    left = None
                    tasks.popleft().set_exception(value)
        self._end(process, connection, tasks, left)

    def _end(
        self, process: BaseProcess, connection: "Connection[Any, Any]", tasks: deque[Future[Any]], left: float | None
    ) -> None:
        """End the process, and report its death to all that wait for its tasks."""
        cause = Cause.START if left is None else Cause.TIMEOUT if left <= 0 else Cause.DEATH
        if cause is not Cause.TIMEOUT:
            process.join(TICK_S)
        _kill(process)
        process.join(END_S)
        connection.close()
        with self._lock:
            # No task can be added any more: the next one starts another process.
            self._process = None
        while tasks:
            # The second task was only waiting in the pipe.
            tasks.popleft().set_exception(WorkerDiedError(cause, _describe_exit(process.exitcode)))
            cause = Cause.NONE


def _kill(process: BaseProcess) -> None:
    """End a process, and those that a plugin started in it."""
    if hasattr(os, "killpg") and process.pid is not None:
        with suppress(OSError):
            os.killpg(process.pid, signal.SIGKILL)
    process.kill()


def _measure_processor(process: BaseProcess) -> float:
    """Return the processor time of a process, s; or wall time where the system does not give it."""
    with suppress(AttributeError, OSError, TypeError):
        # The clock of a process of Linux by its number, as clock_getcpuclockid(3) makes it.
        return time.clock_gettime((~process.pid << 3) | 2)  # type: ignore[operator]
    return time.monotonic()


def _describe_exit(code: int | None) -> str:
    if code is None:
        return "it does not end"
    # Not every signal has a name.
    names = {-number.value: number.name for number in signal.Signals}
    name = f"exit code {code}" if code >= 0 else names.get(code, f"signal {-code}")
    return f"{name}, from outside or for want of memory" if name == "SIGKILL" else name


@contextmanager
def hold_back_interrupts() -> Iterator[None]:
    """Block Ctrl-C in worker processes that start inside this context: the coordinator handles it.

    They inherit the signal mask, so that even a process that is still importing prints no traceback.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    from multiprocessing import resource_tracker

    # Started with the first process otherwise, and its start unblocks what is blocked here.
    resource_tracker.ensure_running()
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


# Functions that run in the worker process.

_connection: "Connection[Any, Any]"
_document: Mapping[str, Any]
_sending = threading.Lock()
_process = 0


def _serve(connection: "Connection[Any, Any]") -> None:
    """Call one function after another, and send back what it returns or raises."""
    global _connection, _document, _process  # noqa: PLW0603 - a worker process has one coordinator and one study
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(os, "setpgrp"):
        # What plugins start in this process ends with it.
        os.setpgrp()
    _process, faults.CAUGHT = os.getpid(), (BaseException,)
    threading.Thread(target=_exit_with_coordinator, daemon=True).start()
    _connection = connection
    # A coordinator that has ended needs no answer.
    with suppress(EOFError, OSError):
        _document = connection.recv()
        while True:
            _answer()


def _answer() -> None:
    received = _connection.recv_bytes()
    try:
        with keep_directory():
            answer = "result", ForkingPickler.loads(received)()
    except DriftformError as error:
        answer = "error", error
    except BaseException as error:
        # Not every error can be sent, and none is sent with its traceback.
        answer = "error", WorkFailedError(faults.describe_fault(error))
    try:
        _report(*answer)
    except OSError:
        raise
    except Exception as error:
        _report("error", WorkFailedError(f"a result cannot be sent: {describe_error(error)}"))


def _report(kind: str, value: object = None) -> None:
    if os.getpid() != _process:
        # A plugin has made a clone of this process. Only the original answers.
        os._exit(1)
    # Several threads of a simulator may prepare something.
    with _sending:
        _connection.send((kind, value))


def _exit_with_coordinator() -> None:
    """Exit when the coordinator ends, even in the middle of a long flight."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        wait_for_any([parent.sentinel])
        if hasattr(os, "killpg"):
            os.killpg(0, signal.SIGKILL)
        os._exit(1)


@cache
def _load_pipeline() -> Pipeline:
    observe_preparation(lambda begins: _report("preparing", begins))
    return load_study(Document("the study", _document)).make_pipeline()


def use_pipeline(function: Callable[..., T], *args: Any) -> T:
    """Call a function with the pipeline of the study, and arguments, in a worker process."""
    # Loaded by a task: an exception is then the error of that task, and not a dead process.
    pipeline = _load_pipeline()
    _report("begun")
    return function(pipeline, *args)
