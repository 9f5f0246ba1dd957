"""The executor of a run: processes on this machine, or a cluster."""

from collections.abc import Iterator
from contextlib import closing, contextmanager
from typing import TYPE_CHECKING

from driftform.errors import InputError, did_you_mean
from driftform.search.jobs import Executor
from driftform.search.local import LocalProcesses
from driftform.study import Study
from driftform.util.cores import count_cores

if TYPE_CHECKING:
    from driftform.search.cluster import Cluster

EXECUTORS = ("local", "dask")


@contextmanager
def open_executor(
    study: Study, name: str | None = None, scheduler: str | None = None, workers: int | None = None
) -> Iterator[Executor]:
    """Give workers that evaluate genomes of a study, and stop them at the end of the context.

    Args:
        study: what they evaluate.
        name: ``"local"`` for processes on this machine, ``"dask"`` for a cluster; ``None`` for the one that ``scheduler`` needs.
        scheduler: address of a running Dask scheduler.
        workers: number of processes; ``None`` for one on each core. The result does not depend on it.

    Raises InputError if the options exclude each other, or no cluster answers.
    """
    name = name or ("local" if scheduler is None else "dask")
    if name not in EXECUTORS:
        raise InputError(f"--executor {name}: unknown executor{did_you_mean(name, EXECUTORS)}")
    if scheduler is not None and name != "dask":
        raise InputError(f"--scheduler {scheduler}: needs --executor dask")
    if scheduler is not None and workers is not None:
        raise InputError(
            f"--workers {workers}: a cluster has the workers that joined it; start more with: "
            f"dask worker {scheduler} --nthreads 1"
        )
    with closing(_make_executor(study, name, scheduler, workers or count_cores())) as executor:
        yield executor


def _make_executor(study: Study, name: str, scheduler: str | None, workers: int) -> "LocalProcesses | Cluster":
    if name == "local":
        processes = LocalProcesses(study.document, workers)
        processes.start(study.evaluations)
        return processes
    from driftform.search.cluster import Cluster

    if scheduler is None:
        return Cluster.start(study.document, workers)
    return Cluster.join(study.document, scheduler)
