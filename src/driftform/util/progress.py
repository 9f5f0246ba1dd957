"""Progress of work in many equal steps: a bar on a terminal or in a notebook, lines elsewhere, or what a program shows."""

import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from contextvars import ContextVar
from html import escape
from typing import TypeVar

from driftform.util.notebook import find_display

T = TypeVar("T")

REFRESH = 4.0
"""Updates of the display on a terminal per second."""

FIRST_LINE_S = 2.0
"""Time before the progress is shown, s."""

FIRST_SHOWN_S = 0.3
"""Time before it is shown by a program, s."""

LINE_EVERY_S = 10.0
"""Time between two lines where there is no terminal, s."""

_shown: ContextVar[Callable[[str, int, int], None] | None] = ContextVar("shown", default=None)


@contextmanager
def show_progress(show: Callable[[str, int, int], None]) -> Iterator[None]:
    """Call ``show`` with what is counted, the finished steps and all steps, in place of printing them in this context."""
    token = _shown.set(show)
    try:
        yield
    finally:
        _shown.reset(token)


def is_shown() -> bool:
    """Return whether :func:`show_progress` shows the progress here."""
    return _shown.get() is not None


def format_duration(seconds: float) -> str:
    """A time in the two units that matter.

    >>> format_duration(7.4), format_duration(200), format_duration(7500), format_duration(266400)
    ('7 s', '3 min 20 s', '2 h 05 min', '3 d 2 h')
    """
    whole = round(seconds)
    minutes, hours, days = whole // 60, whole // 3600, whole // 86400
    if not minutes:
        return f"{whole} s"
    if not hours:
        return f"{minutes} min {whole % 60:02d} s"
    return f"{hours} h {minutes % 60:02d} min" if not days else f"{days} d {hours % 24} h"


class Count:
    """The state of work in equal steps, as a line of text, and as a bar in a notebook."""

    def __init__(self, what: str) -> None:
        self._what, self._done, self._total = what, 0, 0
        self._began = time.monotonic()
        # The first step may compile kernels: the speed is that of those after it.
        self._first: tuple[float, int] | None = None

    def set(self, done: int, total: int) -> bool:
        """Note the finished steps, and all steps; return whether another tenth is finished."""
        is_tenth = total > 0 and 10 * done // total > 10 * self._done // total
        self._done, self._total = done, total
        if self._first is None and done:
            self._first = time.monotonic(), done
        return is_tenth

    def __str__(self) -> str:
        return repr(self) if self._total else ""

    def __repr__(self) -> str:
        now, left = time.monotonic(), ""
        if self._first is not None and self._first[1] < self._done < self._total:
            started, first = self._first
            seconds = (now - started) * (self._total - self._done) / (self._done - first)
            left = f", {format_duration(seconds)} left"
        return f"{self._done}/{self._total or '?'} {self._what}, {format_duration(now - self._began)}{left}"

    def _repr_html_(self) -> str:
        return f'<progress value="{self._done}" max="{max(1, self._total)}"></progress> {escape(repr(self))}'


@contextmanager
def print_regularly(line: Callable[[], str], wait: Callable[[threading.Event], bool] | None = None) -> Iterator[None]:
    """Print a line on stderr after each :data:`LINE_EVERY_S`, and one at the end unless the work fails.

    Args:
        line: returns the line, empty if there is nothing to print yet.
        wait: returns at the time of the next line, ``True`` if the event is set; a test injects its own clock here.
    """
    over = threading.Event()

    def show() -> None:
        if text := line():
            print(text, file=sys.stderr, flush=True)

    def repeat() -> None:
        while not (over.wait(LINE_EVERY_S) if wait is None else wait(over)):
            show()

    thread = threading.Thread(target=repeat, daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()
    show()


@contextmanager
def count_progress(what: str) -> Iterator[Callable[[int, int], None]]:
    """Show the number of finished ``what``: a bar on a terminal or in a notebook, lines on stderr elsewhere.

    Yields a function of the number of finished steps and the number of all steps.
    """
    if (show := _shown.get()) is not None:
        yield lambda done, total: show(what, done, total)
        return
    state = Count(what)
    if (update := find_display()) is not None:
        yield lambda done, total: update(state, state.set(done, total))
        return
    if not (sys.stdout.isatty() and sys.stderr.isatty()):

        def note(done: int, total: int) -> None:
            state.set(done, total)

        with print_regularly(lambda: str(state)):
            yield note
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar

    columns = (BarColumn(), MofNCompleteColumn(), TextColumn(what), TimeRemainingColumn())
    with Bar(*columns, console=Console(stderr=True), refresh_per_second=REFRESH, transient=True) as bar:
        task = bar.add_task(what, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)


def track_progress(items: Iterable[T], total: int, what: str, delay: float | None = None) -> Iterator[T]:
    """Yield ``items``, and show the progress by :func:`count_progress` if it takes longer than ``delay``, s.

    By default that is :data:`FIRST_LINE_S`, or :data:`FIRST_SHOWN_S` inside :func:`show_progress`.

    The time of the first item does not count, because kernels may be compiled for it. Within work that is already shown
    nothing is.
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
                shown.enter_context(show_progress(lambda *_: None))
            if show is not None:
                show(done, max(done, total))
