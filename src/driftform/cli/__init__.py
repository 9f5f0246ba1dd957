"""The command line: one file for each command, and nothing heavy imported before a command runs."""

import io
import sys

from driftform.cli.app import app

__all__ = ["app", "main"]


def main() -> None:
    """Run the command line."""
    for stream in (sys.stdout, sys.stderr):
        # A name may have letters, or bytes, that the encoding of a terminal or of a pipe lacks.
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    app(prog_name="driftform")
