"""The command line: one file per command, and nothing heavy imported before a command runs."""

import _thread
import atexit
import gc
import io
import os
import sys
import threading
import time
from functools import partial

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

BETWEEN_SEARCHES = 200_000
"""Objects that a command makes between two searches for unreachable ones.

Most objects, such as those of imported modules, live until the command ends. With Python's default of 700 the searches took
8 % of the time of a short command.
"""

THREADS_S = 5.0
"""Time that threads which a command left have to end, s."""

_end_process = os._exit


def main() -> None:
    """Run the command line."""
    codes: list[int] = []
    # Last of what is done at the end, because it is registered first.
    atexit.register(_leave, codes)
    os._exit = partial(_refuse_exit, os.getpid())
    sys.unraisablehook = _repeat_interrupt
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        # What is closed is opened, in order, before a file of a run gets its number and then what is printed.
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(os.open(os.devnull, os.O_RDWR), mode, encoding="utf-8"))
    try:
        _run()
    except KeyboardInterrupt:
        # While modules are imported; commands say themselves where they were interrupted.
        print("interrupted", file=sys.stderr)
        codes.append(130)
    except SystemExit as end:
        if isinstance(end.code, int):
            codes.append(end.code)
        raise
    finally:
        threading.Thread(target=_leave_threads, args=(codes,), daemon=True).start()


def _run() -> None:
    from driftform.cli.app import app

    gc.set_threshold(BETWEEN_SEARCHES)
    for stream in (sys.stdout, sys.stderr):
        # A name may have letters, or bytes, that the encoding of a terminal or of a pipe lacks.
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    app(prog_name="driftform")


def _leave(codes: list[int]) -> None:
    """End the process with the exit code of its command, if it has one.

    Python would search all objects for unreachable ones, and free them one by one, for a fifth of the time of a short command.
    """
    for stream in (sys.stdout, sys.stderr):
        if stream is not None and not stream.closed:
            stream.flush()
    for code in codes:
        _end_process(code)


def _refuse_exit(process: int, code: int) -> None:
    """Stand in place of ``os._exit``, by which a plugin would end the command without a word; what a plugin forks may use it."""
    if os.getpid() != process:
        _end_process(code)
    raise SystemExit(f"os._exit({code})")


def _repeat_interrupt(found: "sys.UnraisableHookArgs") -> None:
    """Repeat a Ctrl-C that reached a callback of a library, such as the compiler, which cannot pass it on."""
    if not issubclass(found.exc_type, KeyboardInterrupt):
        sys.__unraisablehook__(found)
        return
    # Later, when the library has returned.
    timer = threading.Timer(0.05, _thread.interrupt_main)
    timer.daemon = True
    timer.start()


def _leave_threads(codes: list[int]) -> None:
    """End a process that a thread of a plugin keeps from its end."""
    time.sleep(THREADS_S)
    left = [thread for thread in threading.enumerate() if not thread.daemon and thread is not threading.main_thread()]
    if left:
        print(f"warning: a plugin left the thread '{left[0].name}', which ends with the command", file=sys.stderr)
        _leave(codes or [1])
