"""Evaluations in this process, in local processes, or on a Dask cluster; a crash costs only the genome to blame."""

from driftform.execution.in_process import InProcess
from driftform.execution.jobs import ATTEMPTS, MAX_BATCH, Executor, Job, Outcome, WorkersLostError
from driftform.execution.local import LocalProcesses

__all__ = [
    "ATTEMPTS",
    "MAX_BATCH",
    "Executor",
    "InProcess",
    "Job",
    "LocalProcesses",
    "Outcome",
    "WorkersLostError",
]
