"""Running the programs of a maker: in a folder of their own, for a limited time, and read by what they print.

Their exit codes prove little: admesh always says 0, OpenSCAD says 0 with an ERROR line, PrusaSlicer nearly always.
"""

import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

from driftform.errors import WorkFailedError


def explain_missing(program: str) -> str:
    """The reason why a program cannot be asked, ``""`` where it can."""
    return "" if shutil.which(program) else f"{program} is not on PATH"


def run_program(command: Sequence[str], folder: Path, timeout: float) -> str:
    """Run a program in ``folder`` and return what it printed, its errors too.

    Raises
    ------
    WorkFailedError
        where it does not end within ``timeout`` seconds, or cannot be started.
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
    """The last line that is not empty: where programs say what went wrong."""
    return next(
        (line.strip() for line in reversed(output.splitlines()) if line.strip()), "it printed nothing"
    )
