"""The executor of a run: processes on this machine, or a cluster."""

from collections.abc import Iterator
from contextlib import closing, contextmanager

from driftform.errors import InputError
from driftform.search.local import LocalProcesses
from driftform.search.pool import Executor
from driftform.study import Study
from driftform.util.cores import count_cores


@contextmanager
def open_executor(study: Study, scheduler: str | None = None, workers: int | None = None) -> Iterator[Executor]:
    """Give workers that evaluate genomes of a study, and stop them at the end of the context.

    Args:
        study: what they evaluate.
        scheduler: address of a running Dask scheduler, ``None`` for processes on this machine.
        workers: number of these processes, ``None`` for one on each core. The result does not depend on it.

    Raises InputError if both are given, or no scheduler answers.
    """
    if scheduler is not None and workers is not None:
        raise InputError(
            f"--workers {workers}: a cluster has the workers that joined it; start more with: "
            f"dask worker {scheduler} --nthreads 1"
        )
    executor: Executor
    if scheduler is None:
        executor = LocalProcesses(study.document, workers or count_cores(), start=study.evaluations)
    else:
        from driftform.search.cluster import Cluster

        executor = Cluster(study.document, scheduler)
    with closing(executor):
        yield executor
