"""Evaluations on a Dask cluster, whose workers join from anywhere.

Each worker of the cluster evaluates in a process of its own, as :mod:`driftform.search.local` does: a genome that crashes
or takes too long ends that process, and not the worker. The cluster stores nothing of a run. Every task carries the study,
in two kilobytes, so that workers may join and leave.
"""

import asyncio
import json
import logging
import math
import multiprocessing
import sys
import threading
import time
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from contextlib import closing, suppress
from typing import Any

from driftform.errors import DriftformError, InputError, WorkFailedError, describe_error
from driftform.runs.versions import find_versions
from driftform.search.jobs import Cause, T, WorkerDiedError, WorkersLostError
from driftform.search.local import LocalProcesses
from driftform.search.pool import POLL_S, Executor
from driftform.search.worker import Worker, hold_back_interrupts
from driftform.study import Document, load_study
from driftform.util.cores import count_cores

CONNECT_TIMEOUT_S = 10.0
"""Time within which a scheduler must answer, s."""

NOISY_LOGGERS = ("distributed", "tornado", "asyncio", "bokeh")
"""Loggers that are silenced: a run reports what matters of their messages itself."""


class Cluster(Executor):
    """Evaluates on the workers of a Dask cluster."""

    def __init__(self, document: Mapping[str, Any], address: str) -> None:
        """Join the cluster of a running scheduler, and wait for its first worker.

        Raises InputError if the extra ``dask`` is not installed, or no scheduler answers.
        """
        super().__init__(len(document["targets"]), float(document["run"]["evaluation_timeout"]))
        self._document, self._address = document, address
        self._study = zlib.compress(json.dumps(document).encode(), 9)
        self._versions = find_versions(document)
        self._client = _connect(address)
        self._tasks = self._client.get_executor(pure=False)
        self._count, self._polled_at, self._seen_at = 0, -math.inf, -math.inf
        self._has_printed = False
        try:
            while not self._count:
                self._poll()
                time.sleep(0 if self._count else POLL_S / 10)
        except BaseException:
            self.close()
            raise

    def _start(self, function: Callable[[], T]) -> "Future[T]":
        future: Future[T] = self._tasks.submit(_call, self._study, self._versions, function)
        return future

    def _find_error(self, future: "Future[Any]") -> BaseException | None:
        from distributed.scheduler import KilledWorker

        if future.cancelled():
            return self._make_lost_error()
        error = future.exception()
        if isinstance(error, KilledWorker):
            # Genomes are evaluated in another process, and not to blame.
            return WorkerDiedError(
                Cause.START, "somebody killed them, or their nannies: see dask worker --memory-limit"
            )
        if error is None or isinstance(error, DriftformError):
            return error
        return WorkFailedError(
            f"{self._address}: its workers cannot evaluate ({describe_error(_find_cause(error))}); "
            "install the same driftform and plugins for the scheduler and all workers"
        )

    def _poll(self) -> None:
        now = time.monotonic()
        if now - self._polled_at < POLL_S:
            return
        self._polled_at = now
        try:
            workers = self._client.sync(self._client.scheduler.identity)["workers"].values()
        except Exception:
            raise self._make_lost_error() from None
        # Whatever their number of threads, each evaluates one genome at a time, and one that is near its limit of memory none.
        self._count = sum(worker["status"] == "running" for worker in workers)
        self.processes = max(1, self._count)
        if self._count:
            self._seen_at, self._has_printed = now, False
        # A dead worker is replaced within a few seconds.
        elif now - self._seen_at > CONNECT_TIMEOUT_S and not self._has_printed:
            self._has_printed = True
            why = "has only workers near their limit of memory (--memory-limit)" if workers else "has no worker"
            join = f"dask worker {self._address} --nthreads 1"
            print(f"{self._address} {why}; waiting for one: {join}", file=sys.stderr, flush=True)

    def call(self, functions: Sequence[Callable[[], T]]) -> Iterator[T]:
        """Call functions in processes on this machine, because the workers of the cluster may be on others."""
        with closing(LocalProcesses(self._document, min(len(functions), count_cores()))) as processes:
            yield from processes.call(functions)

    def close(self) -> None:
        """Leave the cluster."""
        if self._client.status == "running":
            with suppress(Exception):
                self._tasks.shutdown(wait=False)
        with suppress(Exception):
            self._client.close(timeout=POLL_S)

    def _make_lost_error(self) -> WorkersLostError:
        return WorkersLostError(f"{self._address}: the connection to the scheduler is lost")


def _connect(address: str) -> Any:
    """Return a client of the scheduler at an address. Raises InputError if there is none, or no Dask here."""
    try:
        import distributed
    except ImportError as error:
        raise InputError(
            f"--scheduler needs Dask ({error}): uv sync --extra dask, or pip install 'driftform[dask]'"
        ) from None
    for name in list(logging.root.manager.loggerDict):
        if name.partition(".")[0] in NOISY_LOGGERS:
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    try:
        # Asked first, because a client waits forever for a listener that is not a scheduler.
        kind = asyncio.run(asyncio.wait_for(_identify(distributed, address), CONNECT_TIMEOUT_S))
        if kind != "Scheduler":
            raise InputError(f"it is a {kind.lower()}")
        with hold_back_interrupts():
            return distributed.Client(address, timeout=CONNECT_TIMEOUT_S, set_as_default=False)  # type: ignore[no-untyped-call]
    except Exception as error:
        # A refused connection and a timeout give one message: which of them occurs depends on the load.
        silent = isinstance(_find_cause(error), TimeoutError | ConnectionRefusedError)
        why = "" if silent else f" ({describe_error(_find_cause(error))})"
        raise InputError(
            f"--scheduler {address}: no Dask scheduler answers there{why}; "
            "start one with 'dask scheduler', which prints its address"
        ) from None


async def _identify(distributed: Any, address: str) -> str:
    """Return the kind of Dask process that answers at an address, such as "Scheduler"."""
    # Resolved first, because connecting retries an unknown host name until the timeout.
    await asyncio.to_thread(distributed.comm.resolve_address, address)
    security = distributed.Security().get_connection_args("client")
    async with distributed.rpc(address, connection_args=security) as process:
        return str((await process.identity())["type"])


def _find_cause(error: BaseException) -> BaseException:
    """Return the first error in the chain of causes."""
    while isinstance(error.__cause__, Exception):
        error = error.__cause__
    return error


# Functions that run on a worker.

_one_at_a_time = threading.Lock()
"""A worker may have many threads, and flies one genome at a time nevertheless."""

_processes: dict[bytes, Worker] = {}
"""The process that evaluates, by the study that it has loaded: one at a time."""


def _call(study: bytes, expected: Mapping[str, str], function: Callable[[], T]) -> T:
    with _one_at_a_time:
        if study not in _processes:
            while _processes:
                _processes.popitem()[1].close()
            _processes[study] = _open_process(json.loads(zlib.decompress(study)), expected)
        return _processes[study].start(function).result()


def _open_process(document: Mapping[str, Any], expected: Mapping[str, str]) -> Worker:
    """Return a process that evaluates as the coordinator would.

    Raises InputError if this worker has not what the study needs, or has it in other versions.
    """
    from distributed import get_worker

    where = f"worker {get_worker().address}"
    load_study(Document(where, document))
    here = find_versions(document)
    for name, version in expected.items():
        if here.get(name) != version:
            raise InputError(
                f"{where} has {name} {here.get(name)}, this run has {version}: "
                "install the same version, so that the same seed gives the same result"
            )
    # Python lets a daemonic process, such as a worker under a nanny, start no other; ours ends with it in any case.
    multiprocessing.current_process().daemon = False
    return Worker(document)
