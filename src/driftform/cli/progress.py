"""What a run shows while it advances: a live table on a terminal, a line every 10 s elsewhere."""

import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

from driftform.cli.display import View, format_failures, format_throughput, progress_line
from driftform.runs.run import StoredRun
from driftform.runs.status import RunStatus, Throughput
from driftform.runs.store import Record
from driftform.search.advance import Observer
from driftform.util.progress import REFRESH, count_progress, format_duration, is_shown, print_regularly


class Progress(Observer):
    """Counts evaluations and shows the state of the run on stderr: stdout is for results."""

    def __init__(self, run: StoredRun) -> None:
        self.warnings: list[str] = []
        self._status = RunStatus(run.study.scenario.target_names, run.study.evaluations)
        self._throughput = Throughput(0)
        self._stored = 0
        self._live = sys.stdout.isatty() and sys.stderr.isatty() and not is_shown()
        self._flies_finalists = run.study.scenario.robustness.conditions > 0
        self._footer = f"{run.path}: Ctrl-C stops, 'driftform resume' continues"

    @contextmanager
    def open_search(self, stored: int) -> Iterator[None]:
        """Show the search; ``stored`` evaluations were there before, and do not count for the speed."""
        self._stored, self._throughput = stored, Throughput(stored)
        if is_shown():
            yield
            return
        if not self._live:
            with print_regularly(self._line):
                yield
            return
        from rich.console import Console
        from rich.live import Live

        with Live(console=Console(stderr=True), refresh_per_second=REFRESH, get_renderable=self._view) as shown:
            yield
            # The results take the place of the table. It stays if the search is interrupted, or not yet the end.
            shown.transient = not self._flies_finalists

    def open_finalists(self) -> AbstractContextManager[Callable[[int, int], None]]:
        """Show the disturbed flights."""
        return count_progress("disturbed flights")

    def record(self, record: Record) -> None:
        """Count one evaluation."""
        self._status.add(record.summary)
        self._throughput.mark(self._status.done)

    def warn(self, text: str) -> None:
        """Print a warning, above the live table if there is one, and keep it."""
        self.warnings.append(text)
        print(f"warning: {text}", file=sys.stderr, flush=True)

    def _line(self) -> str:
        elapsed = format_duration(self._throughput.elapsed)
        return f"{elapsed}: {self._state() or progress_line(self._status, self._throughput)}"

    def _state(self) -> str:
        if self._status.done > self._stored:
            return ""
        if self._stored:
            return f"resuming after {self._stored} stored evaluations"
        return "starting (the first run compiles the equations of motion)"

    def _view(self) -> View:
        elapsed = f"elapsed {format_duration(self._throughput.elapsed)}"
        speed = format_throughput(self._status, self._throughput)
        facts = (self._state(), speed, elapsed, format_failures(self._status.failed))
        return View(self._status, self._throughput, facts, self._footer)
