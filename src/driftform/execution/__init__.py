"""Evaluations in this process, in local processes, or on a Dask cluster; a crash costs only the genome to blame."""

from driftform.execution.in_process import InProcess
from driftform.execution.jobs import (
    ATTEMPTS,
    KILLS,
    MAX_BATCH,
    STARTS,
    Executor,
    FunctionDiedError,
    Job,
    Outcome,
    WorkersLostError,
)
from driftform.execution.local import LocalProcesses

__all__ = [
    "ATTEMPTS",
    "KILLS",
    "MAX_BATCH",
    "STARTS",
    "Executor",
    "FunctionDiedError",
    "InProcess",
    "Job",
    "LocalProcesses",
    "Outcome",
    "WorkersLostError",
]
