"""Evaluations on a Dask cluster: one on this machine, or one whose workers join from anywhere.

Each worker of the cluster evaluates in a process of its own, as :mod:`driftform.search.local` does: a genome that crashes
or takes too long ends that process, and not the worker. The cluster stores nothing of a run. Every task carries the study,
in two kilobytes, so that workers may join and leave.
"""

import asyncio
import json
import logging
import multiprocessing
import os
import signal
import sys
import threading
import time
import zlib
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from contextlib import closing, suppress
from typing import Any

from driftform.errors import DriftformError, InputError, WorkFailedError, describe_error
from driftform.runs.versions import find_versions
from driftform.search.jobs import Cause, T, WorkerDiedError, WorkersLostError
from driftform.search.local import LocalProcesses
from driftform.search.pool import POLL_S, PoolExecutor
from driftform.search.worker import LocalProcess, hold_back_interrupts
from driftform.study import Document, load_study
from driftform.util.cores import count_cores

CONNECT_TIMEOUT_S = 10.0
"""Time within which a scheduler must answer, s."""

NOISY_LOGGERS = ("distributed", "tornado", "asyncio", "bokeh")
"""Loggers that are silenced: a run reports what matters of their messages itself."""


class Cluster(PoolExecutor):
    """Evaluates on the workers of a Dask cluster; ``where`` names it, and ``local`` is a cluster that ends with this executor."""

    def __init__(self, document: Mapping[str, Any], client: Any, where: str, local: Any = None) -> None:
        super().__init__(document)
        self._document = document
        self._study = zlib.compress(json.dumps(document).encode(), 9)
        self._versions = find_versions(document)
        self._client, self._local, self._where = client, local, where
        self._tasks = client.get_executor(pure=False)
        self._count_workers()
        self._polled_at = self._seen_at = time.monotonic()
        self._has_printed = False

    @classmethod
    def start(cls, document: Mapping[str, Any], workers: int) -> "Cluster":
        """Start a cluster of worker processes on this machine; it ends with this process.

        Any program that can connect to a Dask cluster can run code in it, and every user of a machine can connect to its
        local ports. The processes therefore talk by TLS, with keys that exist in their memory alone.

        Raises InputError if the extra ``dask`` is not installed, WorkFailedError if the cluster does not start.
        """
        distributed = _import_distributed("--executor dask")
        try:
            security = distributed.Security.temporary()
        except ImportError as error:
            raise _make_missing_error("--executor dask", error) from None
        try:
            with hold_back_interrupts():
                local = distributed.LocalCluster(
                    n_workers=workers,
                    threads_per_worker=1,
                    processes=True,
                    host="127.0.0.1",
                    security=security,
                    dashboard_address=None,
                    memory_limit=0,
                    silence_logs=logging.CRITICAL,
                    # Without a dashboard, too, the scheduler serves its state: here on any free port.
                    scheduler_kwargs={"dashboard_address": "127.0.0.1:0"},
                )
                client = distributed.Client(local, timeout=CONNECT_TIMEOUT_S, set_as_default=False)
        except Exception as error:
            raise WorkFailedError(
                f"--executor dask: cannot start a cluster: {describe_error(_find_cause(error))}"
            ) from None
        return cls(document, client, "the local Dask cluster", local)

    @classmethod
    def join(cls, document: Mapping[str, Any], address: str) -> "Cluster":
        """Join the cluster of a running scheduler, and wait for its first worker.

        Raises InputError if the extra ``dask`` is not installed, or no scheduler answers.
        """
        distributed = _import_distributed("--scheduler")
        try:
            # Asked first, because a client waits forever for a listener that is not a scheduler.
            kind = asyncio.run(asyncio.wait_for(_identify(distributed, address), CONNECT_TIMEOUT_S))
            if kind != "Scheduler":
                raise InputError(f"it is a {kind.lower()}")
            with hold_back_interrupts():
                client = distributed.Client(address, timeout=CONNECT_TIMEOUT_S, set_as_default=False)
        except Exception as error:
            # A refused connection and a timeout give one message: which of them occurs depends on the load.
            silent = isinstance(_find_cause(error), TimeoutError | ConnectionRefusedError)
            why = "" if silent else f" ({describe_error(_find_cause(error))})"
            raise InputError(
                f"--scheduler {address}: no Dask scheduler answers there{why}; "
                "start one with 'dask scheduler', which prints its address"
            ) from None
        joined = cls(document, client, address)
        try:
            while not joined._count:
                if not joined._has_printed:
                    joined._print_join_command()
                time.sleep(POLL_S / 10)
                joined._poll()
        except BaseException:
            joined.close()
            raise
        return joined

    def _count_workers(self) -> None:
        # Whatever their number of threads, each evaluates one genome at a time.
        self._count = len(self._client.nthreads())
        self.processes = max(1, self._count)

    def _submit(self, function: Callable[[], T]) -> "Future[T]":
        future: Future[T] = self._tasks.submit(_call, self._study, self._versions, function)
        return future

    def _find_error(self, future: "Future[Any]") -> BaseException | None:
        from distributed.scheduler import KilledWorker

        if future.cancelled():
            return self._make_lost_error()
        error = future.exception()
        if isinstance(error, KilledWorker):
            return WorkerDiedError(Cause.KILL)
        if error is None or isinstance(error, DriftformError):
            return error
        return WorkFailedError(
            f"{self._where}: its workers cannot evaluate ({describe_error(_find_cause(error))}); "
            "install the same driftform and plugins for the scheduler and all workers"
        )

    def _poll(self) -> None:
        now = time.monotonic()
        if now - self._polled_at < POLL_S:
            return
        self._polled_at = now
        try:
            self._count_workers()
        except Exception:
            raise self._make_lost_error() from None
        if self._count:
            self._seen_at, self._has_printed = now, False
        # A dead worker is replaced within a few seconds.
        elif now - self._seen_at > CONNECT_TIMEOUT_S and not self._has_printed:
            self._print_join_command()

    def call(self, functions: Sequence[Callable[[], T]]) -> list[T]:
        """Call functions in processes on this machine, because the workers of the cluster may be on others."""
        with closing(LocalProcesses(self._document, min(len(functions), count_cores()))) as processes:
            return processes.call(functions)

    def close(self) -> None:
        """Leave the cluster; one that was started here ends."""
        # The workers of a local cluster hold nothing to save, and would finish their flight first if asked to stop.
        for nanny in self._local.workers.values() if self._local is not None else ():
            nanny.close_gracefully()
            if nanny.pid is not None:
                with suppress(ProcessLookupError):
                    os.kill(nanny.pid, signal.SIGTERM if sys.platform == "win32" else signal.SIGKILL)
        if self._client.status == "running":
            with suppress(Exception):
                self._tasks.shutdown(wait=False)
        for end in (self._client, self._local):
            if end is not None:
                with suppress(Exception):
                    end.close(timeout=POLL_S)

    def _make_lost_error(self) -> WorkersLostError:
        return WorkersLostError(f"{self._where}: the connection to the scheduler is lost")

    def _print_join_command(self) -> None:
        self._has_printed = True
        print(
            f"{self._where} has no worker; waiting for one: dask worker {self._where} --nthreads 1",
            file=sys.stderr,
            flush=True,
        )


def _import_distributed(option: str) -> Any:
    try:
        import distributed
    except ImportError as error:
        raise _make_missing_error(option, error) from None
    for name in list(logging.root.manager.loggerDict):
        if name.partition(".")[0] in NOISY_LOGGERS:
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    return distributed


def _make_missing_error(option: str, error: ImportError) -> InputError:
    return InputError(f"{option} needs Dask ({error}): uv sync --extra dask, or pip install 'driftform[dask]'")


async def _identify(distributed: Any, address: str) -> str:
    """Return the kind of Dask process that answers at an address, such as "Scheduler"."""
    # Resolved first, because connecting retries an unknown host name until the timeout.
    await asyncio.to_thread(distributed.comm.resolve_address, address)
    security = distributed.Security().get_connection_args("client")
    comm = await distributed.comm.connect(address, CONNECT_TIMEOUT_S / 2, **security)
    try:
        return str((await distributed.core.send_recv(comm, op="identity"))["type"])
    finally:
        comm.abort()


def _find_cause(error: BaseException) -> BaseException:
    """Return the first error in the chain of causes."""
    while isinstance(error.__cause__, Exception):
        error = error.__cause__
    return error


# Functions that run on a worker.

_one_at_a_time = threading.Lock()
"""A worker may have many threads, and flies one genome at a time nevertheless."""

_processes: dict[bytes, LocalProcess] = {}
"""The process that evaluates, by the study that it has loaded: one at a time."""


def _call(study: bytes, expected: Mapping[str, str], function: Callable[[], T]) -> T:
    with _one_at_a_time:
        if study not in _processes:
            while _processes:
                _processes.popitem()[1].close()
            _processes[study] = _open_process(json.loads(zlib.decompress(study)), expected)
        return _processes[study].start(function).result()


def _open_process(document: Mapping[str, Any], expected: Mapping[str, str]) -> LocalProcess:
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
    return LocalProcess(document)
