"""Errors that plugins raise: each becomes one line that names seam, plugin and method."""

import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from driftform.errors import DriftformError, WorkFailedError, describe_error
from driftform.interfaces import SEAMS, Plugin

CAUGHT: tuple[type[BaseException], ...] = (Exception, SystemExit, GeneratorExit)
"""What a plugin may raise at the cost of its genome alone; in a worker that is anything, because nobody interrupts it."""


def name_plugin(plugin: Plugin[Any]) -> str:
    """Return seam and name of a plugin, such as ``simulator 'native'``."""
    seam = next((seam for seam, interface in SEAMS.items() if isinstance(plugin, interface)), "plugin")
    return f"{seam} '{getattr(plugin, 'name', type(plugin).__name__)}'"


def describe_fault(error: BaseException) -> str:
    """Describe an error in one line, with its place and the plugin that raised it unless it is meant for users."""
    if isinstance(error, DriftformError):
        return describe_error(error)
    return trace_fault(error) or describe_error(error, with_place=True)


def trace_fault(error: BaseException) -> str | None:
    """Describe an error that a plugin raised in one line, ``None`` if no plugin was at work; of nested ones the innermost.

    The place is the last one in the plugin's own file, whatever it called from there.
    """
    fault, file, place = None, "", ""
    for frame, line in traceback.walk_tb(error.__traceback__):
        code, acting = frame.f_code, frame.f_locals.get("self")
        if isinstance(acting, Plugin):
            fault, file = f"{name_plugin(acting)} failed in {code.co_name}()", code.co_filename
        if code.co_filename == file:
            place = f"in {code.co_name}, line {line}"
    return fault and f"{fault}: {describe_error(error)} ({place})"


@contextmanager
def report_faults() -> Iterator[None]:
    """Turn an error of a plugin that is not meant for users into one that is; errors of other code pass.

    Raises WorkFailedError for any error of a plugin, also if the plugin ends the program by ``sys.exit``.
    """
    try:
        yield
    except (DriftformError, OSError):
        raise
    except (Exception, SystemExit, GeneratorExit) as error:
        fault = trace_fault(error)
        if fault is None:
            raise
        raise WorkFailedError(fault) from None
