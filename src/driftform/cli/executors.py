"""``--executor``, ``--scheduler`` and ``--workers``: where the evaluations of a command run."""

from collections.abc import Iterator
from contextlib import closing, contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from driftform.search.jobs import Executor
    from driftform.search.pool import PoolExecutor
    from driftform.study import Study

EXECUTORS = ("local", "dask")


@contextmanager
def open_executor(
    study: "Study", name: str | None, scheduler: str | None, workers: int | None
) -> Iterator["Executor"]:
    """Give what the options ask for, and end it; before a cluster is there, nothing has begun.

    Raises
    ------
    InputError
        where the options do not go together, or there is no such cluster.
    """
    name = name or ("local" if scheduler is None else "dask")
    _check(name, scheduler, workers)
    with closing(_executor(study, name, scheduler, workers)) as executor:
        yield executor


def _executor(study: "Study", name: str, scheduler: str | None, workers: int | None) -> "PoolExecutor":
    import os

    count = workers or os.cpu_count() or 1
    if name == "local":
        from driftform.search import LocalProcesses

        processes = LocalProcesses(study.document, count)
        processes.start(study.evaluations)
        return processes
    from driftform.search.cluster import Cluster

    if scheduler is None:
        return Cluster.start(study.document, count)
    return Cluster.join(study.document, scheduler)


def _check(name: str, scheduler: str | None, workers: int | None) -> None:
    from driftform.errors import InputError, did_you_mean

    if name not in EXECUTORS:
        raise InputError(f"--executor {name}: no such executor{did_you_mean(name, EXECUTORS)}")
    if scheduler is not None and name != "dask":
        raise InputError(f"--scheduler {scheduler}: only goes with --executor dask")
    if scheduler is not None and workers is not None:
        raise InputError(
            f"--workers {workers}: a cluster has the workers that joined it; start more with: "
            f"dask worker {scheduler} --nthreads 1"
        )
