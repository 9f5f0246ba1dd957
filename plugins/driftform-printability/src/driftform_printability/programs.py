"""Running other programs: in a separate folder, for a limited time; the result is their output.

Their exit codes prove little: admesh always returns 0, OpenSCAD 0 with an ERROR line, PrusaSlicer nearly always 0.
"""

import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

from driftform.errors import WorkFailedError


def explain_missing(program: str) -> str:
    """Return the reason why a program cannot be run, ``""`` if it can."""
    return "" if shutil.which(program) else f"{program} is not on PATH"


def run_program(command: Sequence[str], folder: Path, timeout: float) -> str:
    """Run a program in ``folder`` and return its output, standard error included.

    Raises
    ------
    WorkFailedError
        if it does not end within ``timeout`` seconds, or cannot be started.
    """
    try:
        done = subprocess.run(
            command,
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            timeout=timeout,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise WorkFailedError(f"{command[0]} did not end within {timeout:g} s") from None
    except OSError as error:
        raise WorkFailedError(f"{command[0]} cannot be run: {error.strerror}") from None
    return done.stdout.decode(errors="replace")


def last_line(output: str) -> str:
    """Return the last line that is not empty: programs print the reason of a failure there."""
    return next(
        (line.strip() for line in reversed(output.splitlines()) if line.strip()), "it printed nothing"
    )
