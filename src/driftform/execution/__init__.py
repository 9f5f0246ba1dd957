"""Where evaluations run: here, in local processes, or on a Dask cluster; a crash costs the genome that is to blame."""

from driftform.execution.in_process import InProcess
from driftform.execution.jobs import ATTEMPTS, BATCH, Executor, Job, Outcome, WorkersLostError
from driftform.execution.local import LocalProcesses

__all__ = [
    "ATTEMPTS",
    "BATCH",
    "Executor",
    "InProcess",
    "Job",
    "LocalProcesses",
    "Outcome",
    "WorkersLostError",
]
