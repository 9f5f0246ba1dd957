"""Exudyn, imported so that it opens no window, prints nothing, and ignores the settings of the user."""

import contextlib
import io
import os
import signal
import threading
from collections.abc import Iterator

# Exudyn reads this when it is imported: no settings from the user's home, which would change results.
os.environ.setdefault("EXUDYN_NO_USER_SETTINGS", "1")

with contextlib.redirect_stdout(io.StringIO()):
    import exudyn
    import exudyn.itemInterface

exudyn.config.printToConsole = False
# The environment variable for this would also import matplotlib, for 0.1 s.
exudyn.special.userInterface.SuppressAll(True)

items = exudyn.itemInterface

__all__ = ["defer_interrupts", "exudyn", "items"]


@contextlib.contextmanager
def defer_interrupts() -> Iterator[None]:
    """Defer an interrupt (SIGINT) until the end: Exudyn would report it as an error in its input."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    held: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, _: held.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
        for number in held[:1]:
            signal.raise_signal(number)
