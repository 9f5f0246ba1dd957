"""How far work of many alike steps is: a bar on a terminal, now and then a line elsewhere."""

import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from typing import TypeVar

T = TypeVar("T")

REFRESH = 4.0
"""Frames a second of what is shown on a terminal."""

FIRST_LINE_S = 2.0
"""Seconds that work may take before it says how far it is."""


@contextmanager
def count_progress(what: str) -> Iterator[Callable[[int, int], None]]:
    """Show on stderr how many of ``what`` are done: a bar on a terminal, a line for each tenth elsewhere.

    Yields a function that takes the number of those that are done, and of all.
    """
    if not (sys.stdout.isatty() and sys.stderr.isatty()):
        yield lambda done, total: _print_tenths(done, total, what)
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar

    columns = (BarColumn(), MofNCompleteColumn(), TextColumn(what), TimeRemainingColumn())
    with Bar(*columns, console=Console(stderr=True), refresh_per_second=REFRESH, transient=True) as bar:
        task = bar.add_task(what, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)


def _print_tenths(done: int, total: int, what: str) -> None:
    if 10 * done // total > 10 * (done - 1) // total:
        print(f"{done}/{total} {what}", file=sys.stderr, flush=True)


def track_progress(items: Iterable[T], total: int, what: str, patience: float = FIRST_LINE_S) -> Iterator[T]:
    """Yield ``items``; where going through them takes longer than ``patience`` (s), show it as :func:`count_progress` does.

    The first does not count: with it, kernels may be compiled.
    """
    began, tell = time.monotonic(), None
    with ExitStack() as shown:
        for done, item in enumerate(items, start=1):
            yield item
            if done == 1:
                began = time.monotonic()
            if tell is None and time.monotonic() - began > patience:
                tell = shown.enter_context(count_progress(what))
            if tell is not None:
                tell(done, max(done, total))
