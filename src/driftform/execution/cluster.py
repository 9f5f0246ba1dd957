"""Evaluations on a Dask cluster: one on this machine, or one whose workers join from anywhere.

The cluster keeps nothing of a run. Every task brings the study with it, in two kilobytes, so workers may come and go.
"""

import asyncio
import json
import logging
import os
import signal
import sys
import threading
import time
import zlib
from collections.abc import Mapping, Sequence
from concurrent.futures import Future
from contextlib import suppress
from functools import lru_cache
from importlib import metadata
from typing import TYPE_CHECKING, Any

from driftform import __version__
from driftform.errors import DriftformError, InputError, WorkFailedError, describe_error
from driftform.execution.jobs import Job, Outcome, WorkersLostError, evaluate_batch
from driftform.execution.lanes import POLL_S, PoolExecutor, WorkerGroup
from driftform.execution.local import hold_back_interrupts
from driftform.pipeline import Pipeline
from driftform.registry import registry
from driftform.study import SELECTED, Document, load_study

if TYPE_CHECKING:
    from distributed import LocalCluster

TIMEOUT = 10.0
"""How long a scheduler may take to answer, s."""

PACKAGES = ("numba", "numpy", "scipy")
"""What decides the last digit of a flight beside driftform and its plugins."""

CHATTER = ("distributed", "tornado", "asyncio", "bokeh")
"""Loggers that say on stderr what a run says itself, or need not say."""


class Cluster(PoolExecutor):
    """Evaluates on the workers of a Dask cluster; all of them are one lane, since Dask moves tasks among them."""

    @classmethod
    def start(cls, document: Mapping[str, Any], workers: int) -> "Cluster":
        """A cluster of worker processes on this machine, which ends with this process.

        Raises
        ------
        InputError
            where the extra ``dask`` is not installed.
        WorkFailedError
            where the cluster does not start.
        """
        distributed = _import_distributed("--executor dask")
        try:
            with hold_back_interrupts():
                cluster = distributed.LocalCluster(
                    n_workers=workers,
                    threads_per_worker=1,
                    processes=True,
                    host="127.0.0.1",
                    dashboard_address=None,
                    memory_limit=0,
                    silence_logs=logging.CRITICAL,
                    # Who is to blame for a death is found out here, as with local processes.
                    scheduler_kwargs={"allowed_failures": 0},
                )
                client = distributed.Client(cluster, timeout=TIMEOUT, set_as_default=False)
        except Exception as error:
            raise WorkFailedError(
                f"--executor dask: no cluster starts here: {describe_error(_find_cause(error))}"
            ) from None
        return cls([_Workers(document, client, "the local Dask cluster", cluster)])

    @classmethod
    def join(cls, document: Mapping[str, Any], address: str) -> "Cluster":
        """The cluster of a scheduler that is running already; waits for the first worker.

        Raises
        ------
        InputError
            where the extra ``dask`` is not installed, or no scheduler answers.
        """
        distributed = _import_distributed("--scheduler")
        try:
            # Asked first, because a client waits for ever for what listens there and is no scheduler.
            kind = asyncio.run(asyncio.wait_for(_identity(distributed, address), TIMEOUT))
            if kind != "Scheduler":
                raise InputError(f"that is a {kind.lower()}")
            with hold_back_interrupts():
                client = distributed.Client(address, timeout=TIMEOUT, set_as_default=False)
        except Exception as error:
            # Whether nobody answers or nobody in time is a matter of how busy this machine is.
            silent = isinstance(_find_cause(error), TimeoutError | ConnectionRefusedError)
            why = "" if silent else f" ({describe_error(_find_cause(error))})"
            raise InputError(
                f"--scheduler {address}: no Dask scheduler answers there{why}; "
                "start one with 'dask scheduler', which prints its address"
            ) from None
        lane = _Workers(document, client, address)
        try:
            lane.wait_for_workers()
        except BaseException:
            lane.close()
            raise
        return cls([lane])


class _Workers(WorkerGroup):
    """All workers of a cluster."""

    def __init__(
        self,
        document: Mapping[str, Any],
        client: Any,
        where: str,
        cluster: "LocalCluster | None" = None,
    ) -> None:
        super().__init__(len(document["targets"]))
        self._study = zlib.compress(json.dumps(document).encode(), 9)
        self._versions = versions(document)
        self._client, self._cluster, self._where = client, cluster, where
        self._tasks = client.get_executor(pure=False)
        self._count = len(client.nthreads())
        self._looked = self._seen = time.monotonic()
        self._has_told = False

    @property
    def processes(self) -> int:
        """Worker processes, whatever the number of their threads: one evaluates one genome at a time."""
        return max(1, self._count)

    def submit(self, batch: Sequence[Job]) -> "Future[list[Outcome]]":
        future: Future[list[Outcome]] = self._tasks.submit(_work, self._study, self._versions, batch)
        return future

    def error(self, future: "Future[list[Outcome]]") -> BaseException | None:
        from distributed.scheduler import KilledWorker

        if future.cancelled():
            return self._lost()
        error = future.exception()
        if error is None or isinstance(error, DriftformError | KilledWorker):
            return error
        return WorkFailedError(
            f"{self._where}: its workers cannot evaluate ({describe_error(_find_cause(error))}); "
            "install the same driftform and plugins for the scheduler and all workers"
        )

    def deaths(self, error: BaseException) -> int:
        from distributed.scheduler import KilledWorker

        return error.allowed_failures + 1 if isinstance(error, KilledWorker) else 0

    def look(self) -> None:
        now = time.monotonic()
        if now - self._looked < POLL_S:
            return
        self._looked = now
        try:
            self._count = len(self._client.nthreads())
        except Exception:
            raise self._lost() from None
        if self._count:
            self._seen, self._has_told = now, False
        # A worker that died is replaced within some seconds.
        elif now - self._seen > TIMEOUT and not self._has_told:
            self._print_how_to_join()

    def wait_for_workers(self) -> None:
        """Return when there is one."""
        while not self._count:
            if not self._has_told:
                self._print_how_to_join()
            time.sleep(POLL_S / 10)
            self.look()

    def close(self) -> None:
        # Nothing is left to lose, and workers of our own end with this process at the latest. Asked to end, they
        # would finish their flight first.
        for nanny in self._cluster.workers.values() if self._cluster is not None else ():
            nanny.close_gracefully()
            if nanny.pid is not None:
                with suppress(ProcessLookupError):
                    os.kill(nanny.pid, signal.SIGTERM if sys.platform == "win32" else signal.SIGKILL)
        if self._client.status == "running":
            with suppress(Exception):
                self._tasks.shutdown(wait=False)
        for end in (self._client, self._cluster):
            if end is not None:
                with suppress(Exception):
                    end.close(timeout=POLL_S)

    def _lost(self) -> WorkersLostError:
        return WorkersLostError(f"{self._where}: the scheduler is gone")

    def _print_how_to_join(self) -> None:
        self._has_told = True
        print(
            f"{self._where} has no worker; waiting for one: dask worker {self._where} --nthreads 1",
            file=sys.stderr,
            flush=True,
        )


def versions(document: Mapping[str, Any]) -> dict[str, str]:
    """The versions of what decides the outcome of an evaluation: driftform, the study's plugins, numerics."""
    found = {"driftform": __version__} | {name: metadata.version(name) for name in PACKAGES}
    for seam in SELECTED:
        if seam != "strategy":
            rows = [row for row in registry().seam(seam) if row.name == document[seam]["use"]]
            found |= {row.distribution: row.version for row in rows if row.available}
    return found


def _import_distributed(option: str) -> Any:
    try:
        import distributed
    except ImportError as error:
        raise InputError(f"{option} needs Dask ({error}): pip install 'driftform[dask]'") from None
    for name in list(logging.root.manager.loggerDict):
        if name.partition(".")[0] in CHATTER:
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    return distributed


async def _identity(distributed: Any, address: str) -> str:
    """What answers at an address, such as "Scheduler"."""
    # Connecting looks up a name that nobody knows again and again, until the time is over.
    await asyncio.to_thread(distributed.comm.resolve_address, address)
    security = distributed.Security().get_connection_args("client")
    comm = await distributed.comm.connect(address, TIMEOUT / 2, **security)
    try:
        return str((await distributed.core.send_recv(comm, op="identity"))["type"])
    finally:
        comm.abort()


def _find_cause(error: BaseException) -> BaseException:
    while isinstance(error.__cause__, Exception):
        error = error.__cause__
    return error


# What runs on a worker.

_one_at_a_time = threading.Lock()
"""A worker may have many threads, and a simulator need not be safe with them."""


def _work(study: bytes, expected: Mapping[str, str], batch: Sequence[Job]) -> list[Outcome]:
    with _one_at_a_time:
        return evaluate_batch(_pipeline(study, tuple(expected.items())), batch)


@lru_cache(maxsize=8)
def _pipeline(study: bytes, expected: tuple[tuple[str, str], ...]) -> Pipeline:
    from distributed import get_worker

    document = json.loads(zlib.decompress(study))
    where = f"worker {get_worker().address}"
    pipeline = load_study(Document(where, document)).make_pipeline()
    here = versions(document)
    for name, version in expected:
        if here.get(name) != version:
            raise InputError(
                f"{where} has {name} {here.get(name)}, this run has {version}: "
                "install the same version, so that the same seed gives the same result"
            )
    return pipeline
