"""Evaluations on a Dask cluster: one on this machine, or one whose workers join from anywhere.

The cluster stores nothing of a run. Every task carries the study, in two kilobytes, so that workers may join and leave.
"""

import asyncio
import faulthandler
import hashlib
import json
import logging
import os
import secrets
import signal
import sys
import threading
import time
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from contextlib import closing, contextmanager, suppress
from functools import cache, lru_cache
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

from driftform import __version__
from driftform.errors import DriftformError, InputError, WorkFailedError, describe_error
from driftform.pipeline import Pipeline
from driftform.plugins import faults
from driftform.plugins.registry import registry
from driftform.search.jobs import Job, Outcome, T, WorkersLostError, evaluate_batch
from driftform.search.local import LocalProcesses
from driftform.search.pool import POLL_S, Cause, Death, PoolExecutor, WorkerGroup
from driftform.search.worker import hold_back_interrupts
from driftform.study import SELECTED, Document, load_study
from driftform.util.files import keep_directory
from driftform.util.preparation import observe_preparation

if TYPE_CHECKING:
    from distributed import LocalCluster

CONNECT_TIMEOUT_S = 10.0
"""Time within which a scheduler must answer, s."""

PACKAGES = ("numba", "numpy", "scipy")
"""Packages that, besides driftform and its plugins, affect the last digit of a result."""

NOISY_LOGGERS = ("distributed", "tornado", "asyncio", "bokeh")
"""Loggers that are silenced: a run reports what matters of their messages itself."""


class Cluster(PoolExecutor):
    """Evaluates on the workers of a Dask cluster, which form one worker group because Dask moves tasks among them."""

    def __init__(self, document: Mapping[str, Any], group: WorkerGroup) -> None:
        super().__init__([group])
        self._document = document

    def call(self, functions: Sequence[Callable[[], T]]) -> list[T]:
        """Call functions in processes on this machine, because the workers of the cluster may be on others."""
        with closing(LocalProcesses(self._document, min(len(functions), os.cpu_count() or 1))) as processes:
            return processes.call(functions)

    @classmethod
    def start(cls, document: Mapping[str, Any], workers: int) -> "Cluster":
        """Start a cluster of worker processes on this machine; it ends with this process.

        Whoever can connect to a Dask cluster can run code in it, and every user of a machine can connect to its local
        ports. The processes therefore talk by TLS, with keys that exist in their memory alone.

        Raises:
            InputError: if the extra ``dask`` is not installed.
            WorkFailedError: if the cluster does not start.
        """
        distributed = _import_distributed("--executor dask")
        try:
            security = distributed.Security.temporary()
        except ImportError as error:
            raise _make_missing_error("--executor dask", error) from None
        try:
            with hold_back_interrupts():
                cluster = distributed.LocalCluster(
                    n_workers=workers,
                    threads_per_worker=1,
                    processes=True,
                    host="127.0.0.1",
                    security=security,
                    dashboard_address=None,
                    memory_limit=0,
                    silence_logs=logging.CRITICAL,
                    scheduler_kwargs={
                        # Without a dashboard, too, the scheduler serves its state: here on any free port.
                        "dashboard_address": "127.0.0.1:0",
                        # WorkerGroup finds the genome to blame for a death, as with local processes.
                        "allowed_failures": 0,
                    },
                )
                client = distributed.Client(cluster, timeout=CONNECT_TIMEOUT_S, set_as_default=False)
        except Exception as error:
            raise WorkFailedError(
                f"--executor dask: cannot start a cluster: {describe_error(_find_cause(error))}"
            ) from None
        return cls(document, _Workers(document, client, "the local Dask cluster", cluster))

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
        group = _Workers(document, client, address)
        try:
            group.wait_for_workers()
        except BaseException:
            group.close()
            raise
        return cls(document, group)


class _Workers(WorkerGroup):
    """All workers of a cluster."""

    def __init__(
        self, document: Mapping[str, Any], client: Any, where: str, cluster: "LocalCluster | None" = None
    ) -> None:
        super().__init__(document)
        self._study = zlib.compress(json.dumps(document).encode(), 9)
        self._versions = find_versions(document)
        self._client, self._cluster, self._where = client, cluster, where
        self._tasks = client.get_executor(pure=False)
        self._count = len(client.nthreads())
        self._polled_at = self._seen_at = time.monotonic()
        self._begun_at: float | None = None
        self._topic = f"driftform-{secrets.token_hex(8)}"
        client.subscribe_topic(self._topic, self._note_begun)
        self._has_printed = False

    @property
    def processes(self) -> int:
        """Number of worker processes, whatever their number of threads: each evaluates one genome at a time."""
        return max(1, self._count)

    def submit(self, batch: Sequence[Job]) -> "Future[list[Outcome]]":
        self._begun_at = None
        future: Future[list[Outcome]] = self._tasks.submit(
            _work, self._study, self._versions, batch, self.timeout, self._topic
        )
        return future

    def _note_begun(self, _: object) -> None:
        self._begun_at = time.monotonic()

    def find_error(self, future: "Future[list[Outcome]]") -> BaseException | None:
        from distributed.scheduler import KilledWorker

        if future.cancelled():
            return self._make_lost_error()
        error = future.exception()
        if error is None or isinstance(error, DriftformError | KilledWorker):
            return error
        return WorkFailedError(
            f"{self._where}: its workers cannot evaluate ({describe_error(_find_cause(error))}); "
            "install the same driftform and plugins for the scheduler and all workers"
        )

    def find_death(self, error: BaseException) -> Death | None:
        from distributed.scheduler import KilledWorker

        if not isinstance(error, KilledWorker):
            return super().find_death(error)
        # Dask does not say why a worker died; one that took too long ended itself then.
        is_overdue = self._begun_at is not None and time.monotonic() - self._begun_at >= self.timeout
        return Death(Cause.TIMEOUT if is_overdue else Cause.KILL, count=error.allowed_failures + 1)

    def poll(self) -> None:
        now = time.monotonic()
        if now - self._polled_at < POLL_S:
            return
        self._polled_at = now
        try:
            self._count = len(self._client.nthreads())
        except Exception:
            raise self._make_lost_error() from None
        if self._count:
            self._seen_at, self._has_printed = now, False
        # A dead worker is replaced within a few seconds.
        elif now - self._seen_at > CONNECT_TIMEOUT_S and not self._has_printed:
            self._print_join_command()

    def wait_for_workers(self) -> None:
        """Wait until the cluster has a worker."""
        while not self._count:
            if not self._has_printed:
                self._print_join_command()
            time.sleep(POLL_S / 10)
            self.poll()

    def close(self) -> None:
        # The workers of a local cluster hold nothing to save, and would finish their flight first if asked to stop.
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

    def _make_lost_error(self) -> WorkersLostError:
        return WorkersLostError(f"{self._where}: the connection to the scheduler is lost")

    def _print_join_command(self) -> None:
        self._has_printed = True
        print(
            f"{self._where} has no worker; waiting for one: dask worker {self._where} --nthreads 1",
            file=sys.stderr,
            flush=True,
        )


def find_versions(document: Mapping[str, Any]) -> dict[str, str]:
    """Return the versions of all that affects the outcome of an evaluation: driftform, the study's plugins, numerics.

    Of driftform and the plugins it has the digests of their sources too, which may differ within a version.
    """
    found = {"driftform": __version__} | {name: metadata.version(name) for name in PACKAGES}
    modules = {"driftform": "driftform"}
    for seam in SELECTED:
        if seam != "strategy":
            for row in registry().seam(seam):
                if row.name == document[seam]["use"] and row.cls is not None:
                    found[row.distribution] = row.version
                    modules[row.distribution] = row.cls.__module__.partition(".")[0]
    return found | {f"sources of {name}": _hash_sources(module) for name, module in modules.items()}


@cache
def _hash_sources(module: str) -> str:
    """Return a digest of the Python files of a package that is imported, or of a module."""
    digest, file = hashlib.sha256(), Path(str(sys.modules[module].__file__))
    for source in sorted(file.parent.rglob("*.py")) if file.name == "__init__.py" else [file]:
        digest.update(source.relative_to(file.parent).as_posix().encode() + source.read_bytes())
    return digest.hexdigest()[:12]


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
"""A worker may have many threads, and a simulator need not be thread-safe."""


def _work(study: bytes, expected: Mapping[str, str], batch: Sequence[Job], timeout: float, topic: str) -> list[Outcome]:
    from distributed import get_worker

    with _one_at_a_time, keep_directory():
        pipeline = _load_pipeline(study, tuple(expected.items()))
        get_worker().log_event(topic, "begun")
        process, faults.CAUGHT = os.getpid(), (BaseException,)
        with _limit_time(timeout):
            outcomes = evaluate_batch(pipeline, batch)
        if os.getpid() != process:
            # A plugin has made a clone of the worker. Only the original answers.
            os._exit(1)
        return outcomes


@contextmanager
def _limit_time(seconds: float) -> Iterator[None]:
    """End this process if the context takes longer, preparations aside; its nanny then starts another.

    The timer of faulthandler needs no Python thread: it ends the process even if a library never returns.
    """
    left, since, pauses = seconds, time.monotonic(), 0
    silence = Path(os.devnull).open("w")  # noqa: SIM115 - closed below
    lock = threading.Lock()

    def count_preparation(begins: bool) -> None:
        nonlocal left, since, pauses
        with lock:
            pauses += 1 if begins else -1
            if begins and pauses == 1:
                faulthandler.cancel_dump_traceback_later()
                left -= time.monotonic() - since
            elif not pauses:
                since = time.monotonic()
                faulthandler.dump_traceback_later(max(left, 1e-3), exit=True, file=silence)

    observe_preparation(count_preparation)
    faulthandler.dump_traceback_later(seconds, exit=True, file=silence)
    try:
        yield
    finally:
        observe_preparation(lambda _: None)
        faulthandler.cancel_dump_traceback_later()
        silence.close()


@lru_cache(maxsize=8)
def _load_pipeline(study: bytes, expected: tuple[tuple[str, str], ...]) -> Pipeline:
    from distributed import get_worker

    document = json.loads(zlib.decompress(study))
    where = f"worker {get_worker().address}"
    pipeline = load_study(Document(where, document)).make_pipeline()
    here = find_versions(document)
    for name, version in expected:
        if here.get(name) != version:
            raise InputError(
                f"{where} has {name} {here.get(name)}, this run has {version}: "
                "install the same version, so that the same seed gives the same result"
            )
    return pipeline
