"""What long work shows while it goes on: live on a terminal, now and then a line elsewhere."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import TracebackType
from typing import TYPE_CHECKING

from driftform.store import Record
from driftform.study import Study

if TYPE_CHECKING:
    from rich.console import Group

REFRESH = 4.0
"""Frames a second."""


class Progress:
    """Counts evaluations and shows where the run stands, on stderr: stdout is for results."""

    def __init__(self, study: Study, stored: int = 0) -> None:
        """Start counting; ``stored`` evaluations were there before, and say nothing about the speed."""
        self._targets = study.scenario.target_names
        self._budget = study.evaluations
        self._best: list[tuple[float, int]] = [(0.0, -1)] * len(self._targets)
        self._done = self._failed = 0
        self._stored = stored
        self._started = time.perf_counter()
        self._live = sys.stdout.isatty() and sys.stderr.isatty()
        self._display = None
        if self._live:
            from rich.console import Console
            from rich.live import Live

            self._display = Live(
                console=Console(stderr=True),
                refresh_per_second=REFRESH,
                get_renderable=self._table,
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
        self._done += 1
        self._failed += record.evaluation.failure is not None
        for i, value in enumerate(record.evaluation.fitness):
            if value > self._best[i][0]:
                self._best[i] = (float(value), record.index)

    def generation(self, evaluations: int) -> None:
        """Say where the run stands, off a terminal."""
        if not self._live:
            best = "  ".join(f"{t} {f:.2f}" for t, (f, _) in zip(self._targets, self._best, strict=True))
            print(
                f"{evaluations}/{self._budget} evaluations, {self._rate()}: {best}",
                file=sys.stderr,
                flush=True,
            )

    def _rate(self) -> str:
        failures = f", {self._failed} failed" if self._failed else ""
        elapsed = time.perf_counter() - self._started
        new = self._done - self._stored
        if new <= 0:
            before = f"{self._done} of them stored before"
            return (
                before if self._done else "starting (the first run compiles the equations of motion)"
            ) + failures
        rate = new / elapsed
        left = (self._budget - self._done) / rate
        return f"{rate:.3g}/s, {left:.0f} s left{failures}"

    def _table(self) -> "Group":
        from rich import box
        from rich.console import Group
        from rich.progress_bar import ProgressBar
        from rich.table import Table
        from rich.text import Text

        table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
        table.add_column("target")
        for title in ("best fitness %", "error %", "evaluation"):
            table.add_column(title, justify="right")
        for target, (fitness, index) in zip(self._targets, self._best, strict=True):
            row = (f"{fitness:.3f}", f"{100 - fitness:.3f}", str(index)) if index >= 0 else ("", "", "")
            table.add_row(target, *row)
        # A bar ends no line: side by side with its text in a grid.
        line = Table.grid(padding=(0, 2))
        bar = ProgressBar(total=self._budget, completed=self._done, width=30)
        line.add_row(bar, Text(f"{self._done} of {self._budget} evaluations, {self._rate()}"))
        return Group(table, line)


@contextmanager
def counter(what: str) -> Iterator[Callable[[int, int], None]]:
    """Show on stderr how many of ``what`` are done: a bar on a terminal, a line for each tenth elsewhere.

    Yields a function that takes the number of those that are done, and of all.
    """
    if not (sys.stdout.isatty() and sys.stderr.isatty()):
        yield lambda done, total: _tell_tenths(done, total, what)
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar

    columns = (BarColumn(), MofNCompleteColumn(), TextColumn(what), TimeRemainingColumn())
    with Bar(*columns, console=Console(stderr=True), refresh_per_second=REFRESH, transient=True) as bar:
        task = bar.add_task(what, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)


def _tell_tenths(done: int, total: int, what: str) -> None:
    if 10 * done // total > 10 * (done - 1) // total:
        print(f"{done}/{total} {what}", file=sys.stderr, flush=True)
