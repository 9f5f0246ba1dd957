"""Evaluations in this process, in local processes, or on a Dask cluster; a crash costs only the genome to blame."""

from driftform.search.in_process import InProcess
from driftform.search.jobs import (
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
from driftform.search.local import LocalProcesses

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
