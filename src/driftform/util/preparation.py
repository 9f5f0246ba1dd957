"""Work that a machine does once, such as the compilation of kernels, and that no evaluation is charged for."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager


def _ignore(_: bool) -> None: ...


_report: Callable[[bool], object] = _ignore


def observe_preparation(report: Callable[[bool], object]) -> None:
    """Call ``report(True)`` whenever a preparation begins in this process, and ``report(False)`` when it ends."""
    global _report  # noqa: PLW0603 - a process has one coordinator
    _report = report


@contextmanager
def preparing() -> Iterator[None]:
    """Stop the clock of the evaluation that needs this preparation first, also while another process makes it."""
    _report(True)
    try:
        yield
    finally:
        _report(False)
