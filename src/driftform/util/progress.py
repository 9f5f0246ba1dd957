"""Progress of work in many equal steps: a bar on a terminal, occasional lines elsewhere, or what a program shows."""

import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from contextvars import ContextVar
from typing import TypeVar

T = TypeVar("T")

REFRESH = 4.0
"""Updates of the display on a terminal per second."""

FIRST_LINE_S = 2.0
"""Time before the progress is shown, s."""

FIRST_SHOWN_S = 0.3
"""Time before it is shown by a program, s."""

_shown: ContextVar[Callable[[str, int, int], None] | None] = ContextVar("shown", default=None)


@contextmanager
def show_progress(show: Callable[[str, int, int], None]) -> Iterator[None]:
    """Call ``show`` with what is counted, the finished steps and all steps, in place of printing them in this context."""
    token = _shown.set(show)
    try:
        yield
    finally:
        _shown.reset(token)


@contextmanager
def count_progress(what: str) -> Iterator[Callable[[int, int], None]]:
    """Show the number of finished ``what``: a bar on a terminal, a line of stderr for each tenth elsewhere.

    Yields a function of the number of finished steps and the number of all steps. Inside :func:`show_progress` nothing
    is printed.
    """
    if (show := _shown.get()) is not None:
        yield lambda done, total: show(what, done, total)
        return
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


def track_progress(items: Iterable[T], total: int, what: str, delay: float | None = None) -> Iterator[T]:
    """Yield ``items``, and show the progress by :func:`count_progress` if it takes longer than ``delay``, s.

    By default that is :data:`FIRST_LINE_S`, or :data:`FIRST_SHOWN_S` inside :func:`show_progress`.

    The time of the first item does not count, because kernels may be compiled for it.
    """
    began, show = time.monotonic(), None
    if delay is None:
        delay = FIRST_LINE_S if _shown.get() is None else FIRST_SHOWN_S
    with ExitStack() as shown:
        for done, item in enumerate(items, start=1):
            yield item
            if done == 1:
                began = time.monotonic()
            if show is None and time.monotonic() - began > delay:
                show = shown.enter_context(count_progress(what))
            if show is not None:
                show(done, max(done, total))
