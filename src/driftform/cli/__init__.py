"""The command line: one file for each command, and nothing heavy imported before a command runs."""

import atexit
import gc
import io
import sys

from driftform.cli.app import app

__all__ = ["app", "main"]

BETWEEN_SEARCHES = 200_000
"""Objects that a command makes between two searches for unreachable ones.

Most objects, such as those of imported modules, live until the command ends. With Python's default of 700 the searches took
8 % of the time of a short command.
"""


def main() -> None:
    """Run the command line."""
    gc.set_threshold(BETWEEN_SEARCHES)
    # Python searches all objects once more when it ends, for a sixth of the time of a short command. Frozen ones it passes over.
    atexit.register(gc.freeze)
    for stream in (sys.stdout, sys.stderr):
        # A name may have letters, or bytes, that the encoding of a terminal or of a pipe lacks.
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    app(prog_name="driftform")
