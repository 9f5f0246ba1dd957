"""What a run shows while it goes on: live on a terminal, now and then a line elsewhere."""

import sys
from pathlib import Path
from types import TracebackType

from driftform.cli.display import View, format_duration, format_failures, format_throughput, progress_line
from driftform.runs.status import RunStatus, Throughput
from driftform.runs.store import Record
from driftform.study import Study
from driftform.util.progress import REFRESH


class Progress:
    """Counts evaluations and shows where the run stands, on stderr: stdout is for results."""

    def __init__(self, study: Study, directory: Path, stored: int = 0) -> None:
        """Start counting; ``stored`` evaluations were there before, and say nothing about the speed."""
        self._standing = RunStatus(study.scenario.target_names, study.evaluations)
        self._pace = Throughput(stored)
        self._stored = stored
        self._live = sys.stdout.isatty() and sys.stderr.isatty()
        self._footer = f"{directory}: Ctrl-C stops, 'driftform resume' goes on"
        self._display = None
        if self._live:
            from rich.console import Console
            from rich.live import Live

            self._display = Live(
                console=Console(stderr=True),
                refresh_per_second=REFRESH,
                get_renderable=self._view,
                transient=True,
            )

    def __enter__(self) -> "Progress":
        if self._display is not None:
            self._display.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._display is not None:
            self._display.__exit__(kind, error, trace)

    def record(self, record: Record) -> None:
        """Count one evaluation."""
        candidate, evaluation = record.candidate, record.evaluation
        failed = evaluation.failure is not None
        fitness = evaluation.fitness.tolist()
        self._standing.add(record.index, candidate.generation, candidate.target, failed, fitness)
        self._pace.mark(self._standing.done)

    def generation(self, evaluations: int) -> None:
        """Say where the run stands, off a terminal; not for each generation that was stored before."""
        if not self._live and (evaluations > self._stored or evaluations == self._standing.budget):
            print(progress_line(self._standing, self._pace), file=sys.stderr, flush=True)

    def _state(self) -> str:
        if self._standing.done > self._stored:
            return ""
        if self._stored:
            return f"going on after {self._stored} that are stored"
        return "starting (the first run compiles the equations of motion)"

    def _view(self) -> View:
        elapsed = f"elapsed {format_duration(self._pace.elapsed)}"
        pace = format_throughput(self._standing, self._pace)
        facts = (self._state(), pace, elapsed, format_failures(self._standing.failed))
        return View(self._standing, self._pace, facts, self._footer)
