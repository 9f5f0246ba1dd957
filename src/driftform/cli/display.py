"""How a run's status looks: lines of text anywhere, and a table that fits the terminal."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice
from statistics import median
from typing import TYPE_CHECKING

from driftform.errors import escape_controls
from driftform.runs.status import PARTS, RunStatus, TargetStatus, Throughput
from driftform.util.progress import format_duration

if TYPE_CHECKING:
    from rich.console import Console, ConsoleOptions, OverflowMethod, RenderableType, RenderResult
    from rich.measure import Measurement
    from rich.table import Table

BARS = "▁▂▃▄▅▆▇█"
PLAIN_BARS = "_.-:=+*#"
"""The same where the terminal knows ASCII alone."""

DECADES = (10.0, 1e6)
"""Least and largest ratio that a curve spans: a little progress does not look like a lot, and zero has a place."""

PAGE_S = 5.0
"""Time for which some of the targets are shown, if there is no room for all, s."""

_AROUND = 8
"""Lines of a display that are not of a target."""

_MAX_IN_A_LINE = 20
"""Largest number of targets that a line of progress shows one by one."""

_ROOM_FOR_CURVES = 72
"""Columns of a terminal below which there are numbers alone."""


def draw_sparkline(errors: Sequence[float | None], lowest: float, highest: float, bars: str = BARS) -> str:
    """Errors as bars on a logarithmic scale from ``lowest`` to ``highest``; spaces where an error is missing.

    >>> draw_sparkline([None, 100, 30, 10, 3, 1], 1, 100)
    ' █▆▅▃▁'
    """
    low, span = math.log(lowest), math.log(highest / lowest)
    top = len(bars) - 1
    shares = [None if e is None else (math.log(max(e, lowest)) - low) / span for e in errors]
    return "".join(" " if s is None else bars[min(top, math.floor(s * top + 0.5))] for s in shares)


def format_throughput(status: RunStatus, throughput: Throughput) -> str:
    """How fast the run is and when it will be over, as far as that is known."""
    rate = throughput.measure(status.done)
    if rate is None:
        return ""
    left = status.budget - status.done
    return f"{rate:.3g}/s" + (f", {format_duration(left / rate)} left" if left > 0 else "")


def progress_line(status: RunStatus, throughput: Throughput) -> str:
    """The state of a run, in one line."""
    shown = {name: target.best for name, target in status.targets.items()}
    best = "  ".join(f"{name} {fitness:.2f}" for name, fitness in shown.items())
    if len(shown) > _MAX_IN_A_LINE:
        worst, middle = min(shown, key=shown.__getitem__), median(shown.values())
        best = f"best of {len(shown)} targets: median {middle:.2f}, worst {worst} {shown[worst]:.2f}"
    facts = ", ".join(filter(None, (format_throughput(status, throughput), format_failures(status.failed))))
    return f"{status.done}/{status.budget} evaluations{f', {facts}' if facts else ''}: {best}"


def format_failures(count: int) -> str:
    """How many evaluations failed, in words; nothing where none did."""
    return f"{count} failed" if count else ""


@dataclass(frozen=True)
class View:
    """A run's status as a table of its targets, a bar, and lines below, for a console of any size.

    ``facts`` are shown in one line, without those that are empty; ``footer`` is the last line. With ``fits`` it is no
    higher than the terminal: targets that find no room take turns.
    """

    status: RunStatus
    throughput: Throughput
    facts: tuple[str, ...]
    footer: str
    fits: bool = True

    def __rich_console__(self, console: "Console", options: "ConsoleOptions") -> "RenderResult":
        from rich.text import Text

        count = len(self.status.targets)
        notes = self._notes()[: max(1, console.size.height - _AROUND - 3) if self.fits else None]
        first, last = self._shown(console.size.height - len(notes))
        shown = f"targets {first + 1} to {last} of {count}" if last - first < count else ""
        rows = list(islice(self.status.targets.items(), first, last))
        yield self._table(rows, options)
        yield Text("")
        yield self._bar(min(40, max(10, options.max_width - 40)))
        yield Text(", ".join(filter(None, (*self.facts, shown))))
        for text in notes:
            yield Text(escape_controls(text), no_wrap=self.fits, overflow=_overflow(options))
        if self.footer:
            yield Text(self.footer, style="dim", no_wrap=True, overflow=_overflow(options))

    def _notes(self) -> list[str]:
        """What is most often wrong, which constraints are missed, and what was measured of best agents, in turn if it must fit."""
        (reason, alike), missed = self.status.commonest_failure, str(self.status.missed)
        notes = [f"failed most often ({alike} of {self.status.failed}): {reason}"] if alike else []
        notes += [f"missed: {missed}"] if missed else []
        measured = [
            f"best of {name}: {', '.join(f'{key} {v:.4g}' for key, v in one.measures.items() if math.isfinite(v))}"
            for name, one in self.status.targets.items()
            if one.measures
        ]
        turn = int(self.throughput.elapsed / PAGE_S) % max(1, len(measured))
        return notes + (measured[turn : turn + 1] if self.fits else measured)

    def _shown(self, height: int) -> tuple[int, int]:
        """Which targets are shown now: the first, and the one after the last."""
        count, room = len(self.status.targets), max(1, height - _AROUND)
        if not self.fits or count <= room:
            return 0, count
        pages = -(-count // room)
        page = int(self.throughput.elapsed / PAGE_S) % pages
        return page * room, min(count, (page + 1) * room)

    def _table(self, rows: "Sequence[tuple[str, TargetStatus]]", options: "ConsoleOptions") -> "Table":
        from rich import box
        from rich.table import Table
        from rich.text import Text

        table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, show_edge=False)
        widest = options.max_width // 6 if self.fits else None
        table.add_column("\ntarget", no_wrap=True, overflow=_overflow(options), max_width=widest)
        for title in ("best\nfitness %", "left to\n100 %", "\nevaluation", "last gen.\nmean %", "\nfailed"):
            table.add_column(title, justify="right", no_wrap=True, overflow=_overflow(options))
        columns = zip(*(_cells(name, target) for name, target in rows), strict=True)
        # One cell for a whole column: many cells would take several times as long to draw.
        cells: list[RenderableType] = [Text("\n".join(column)) for column in columns]
        if options.max_width >= _ROOM_FOR_CURVES:
            # The one column that gives way where there is little room.
            table.add_column("left to 100 %\n(log scale)")
            cells.append(Curves(tuple(target for _, target in rows)))
        table.add_row(*cells)
        return table

    def _bar(self, width: int) -> "Table":
        from rich.progress_bar import ProgressBar
        from rich.table import Table
        from rich.text import Text

        # A bar ends no line: side by side with its text in a grid.
        grid = Table.grid(padding=(0, 2))
        done, budget = self.status.done, self.status.budget
        bar = ProgressBar(total=budget, completed=done, width=width)
        grid.add_row(bar, Text(f"{done} of {budget} evaluations"))
        return grid


def _overflow(options: "ConsoleOptions") -> "OverflowMethod":
    """How text is cut: rich's ellipsis is not ASCII."""
    return "crop" if options.ascii_only else "ellipsis"


def _cells(name: str, target: TargetStatus) -> tuple[str, ...]:
    mean = "" if target.mean is None else f"{target.mean:.2f}"
    failed = str(target.failed or "")
    if target.index < 0:
        return name, "", "", "", mean, failed
    return name, f"{target.best:.3f}", f"{100 - target.best:.3f}", str(target.index), mean, failed


@dataclass(frozen=True)
class Curves:
    """The best error of targets along the budget, each on a scale of its own, as wide as there is room."""

    targets: tuple[TargetStatus, ...]

    narrowest = 8

    def __rich_console__(self, console: "Console", options: "ConsoleOptions") -> "RenderResult":
        from rich.text import Text

        bars, lines = PLAIN_BARS if options.ascii_only else BARS, []
        for target in self.targets:
            errors = target.list_errors()
            highest = next((error for error in errors if error is not None), 1.0) or 1.0
            lowest = max(highest / DECADES[1], min(highest / DECADES[0], 100 - target.best))
            # Of several parts in a column, the last.
            step = -(-PARTS // options.max_width)
            shown = errors[::-step][::-1]
            lines.append(draw_sparkline(shown, lowest, highest, bars))
        yield Text("\n".join(lines))

    def __rich_measure__(self, console: "Console", options: "ConsoleOptions") -> "Measurement":
        from rich.measure import Measurement

        return Measurement(self.narrowest, min(PARTS, options.max_width))
