"""A run watched from another process: what is new of it, read-only, and whether anyone works on it."""

from math import isfinite
from pathlib import Path
from typing import Any

from driftform.errors import InputError
from driftform.runs.directory import check_run, is_worked_on, resume_command
from driftform.runs.status import RunStatus, Throughput
from driftform.runs.store import Store

RUNNING, WRITING, FINISHED, STOPPED = "running", "writing the best agents", "finished", "stopped"


class RunMonitor:
    """Reads what is new of a run, and nothing twice; holds neither its lock nor its database open.

    Attributes:
        directory: of the run.
        status: the evaluations counted so far, as of the last :meth:`poll`.
        state: one of :data:`RUNNING`, :data:`WRITING`, :data:`FINISHED` and :data:`STOPPED`, as of then.
        throughput: evaluations per second since the first poll. Raises InputError if the directory is not a run.
    """

    def __init__(self, directory: Path) -> None:
        self.directory = directory
        self.state = STOPPED
        self._database = check_run(directory)
        # Evaluations are stored as they come: all below the first are known, and some of those above.
        self._first = 0
        self._above: set[int] = set()
        self.status = RunStatus((), 0)
        self.throughput = Throughput(0)

    def poll(self) -> None:
        """Read what is new. Raises InputError if the database is damaged."""
        # Asked first: a process that has released the run has written all that is read below.
        held = is_worked_on(self.directory)
        with Store.open(self._database, read_only=True, check=False) as store:
            targets, budget = read_aims(self._database, store.read_study())
            begins = not self.status.targets
            if begins:
                self.status = RunStatus(targets, budget)
            self.status.budget = budget
            for summary in store.read_summaries(targets, self._first):
                if summary.index not in self._above:
                    self._above.add(summary.index)
                    self.status.add(summary)
        while self._first in self._above:
            self._above.remove(self._first)
            self._first += 1
        if begins:
            self.throughput = Throughput(self.status.done)
        self.throughput.mark(self.status.done)
        complete = self.status.done >= budget
        self.state = (WRITING if complete else RUNNING) if held else (FINISHED if complete else STOPPED)

    @property
    def is_over(self) -> bool:
        """Whether no process works on the run any more."""
        return self.state in (FINISHED, STOPPED)

    def describe_end(self) -> str:
        """Return one line on how the run ended, with the next step if it stopped early."""
        status = self.status
        if self.state == FINISHED:
            return (
                f"finished: {status.done} evaluations ({status.failed} failed), best agents in {self.directory}/best/"
            )
        return (
            f"stopped after {status.done} of {status.budget} evaluations; resume with: {resume_command(self.directory)}"
        )

    def document(self) -> dict[str, Any]:
        """Return the state in numbers, as ``driftform watch --json`` prints it."""
        reason, count = self.status.commonest_failure
        return {
            "run": str(self.directory),
            "state": self.state,
            "evaluations": self.status.done,
            "budget": self.status.budget,
            "failed": self.status.failed,
            "commonest_failure": {"reason": reason, "count": count} if count else None,
            "targets": {
                name: {
                    "fitness": target.best if target.index >= 0 else None,
                    "error_percent": 100 - target.best if target.index >= 0 else None,
                    "evaluation": target.index if target.index >= 0 else None,
                    "generation": target.generation if target.generation >= 0 else None,
                    "mean_fitness": target.mean,
                    "failed": target.failed,
                    "measures": {key: value for key, value in target.measures.items() if isfinite(value)},
                }
                for name, target in self.status.targets.items()
            },
        }


def read_aims(database: Path, document: dict[str, Any]) -> tuple[list[str], int]:
    """Return the targets and the budget of a stored study, which need not be one that could be carried out here."""
    try:
        return list(document["targets"].keys()), int(document["run"]["evaluations"])
    except (KeyError, TypeError, AttributeError, ValueError, OverflowError):
        raise InputError(f"{database}: is damaged: its study has no targets, or no budget") from None
