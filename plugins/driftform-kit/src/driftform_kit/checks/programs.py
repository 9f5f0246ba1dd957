"""Running other programs: in a separate folder, with limits of time, memory and output; the result is their output.

Their exit codes prove little: admesh always returns 0, OpenSCAD 0 with an ERROR line, PrusaSlicer nearly always 0.
"""

import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from driftform.errors import WorkFailedError

MEMORY = 8 << 30
"""Largest address space of a program, bytes."""

FILE_SIZE = 1 << 30
"""Largest file that a program may write, its output included, bytes."""

_READ = 1 << 24
"""Bytes of a program's output that are read."""

# Limits are set by a process of its own, which then becomes the program: between fork and exec of a process with threads
# no Python may run.
_LIMITED = """
import os, resource, sys
for limit, value in ((resource.RLIMIT_AS, sys.argv[1]), (resource.RLIMIT_FSIZE, sys.argv[2])):
    hard = resource.getrlimit(limit)[1]
    value = int(value) if hard == resource.RLIM_INFINITY else min(int(value), hard)
    resource.setrlimit(limit, (value, value))
os.execv(sys.argv[3], sys.argv[3:])
"""


def explain_missing(program: str) -> str:
    """Return the reason why a program cannot be run, ``""`` if it can."""
    return "" if shutil.which(program) else f"{program} is not on PATH"


def run_program(command: Sequence[str], folder: Path, timeout: float, memory: int = MEMORY) -> str:
    """Run a program with its arguments in ``folder``; return the beginning of its output, standard error included.

    The limit of time is in s, that of its address space in bytes; Windows has no limit of memory.

    Raises
    ------
    WorkFailedError
        if it does not end in time, or cannot be started.
    """
    program = shutil.which(command[0])
    if program is None:
        raise WorkFailedError(f"{command[0]} cannot be run: it is not on PATH")
    output = folder / "output.txt"
    limited = [program, *command[1:]]
    if sys.platform != "win32":
        limited = [sys.executable, "-I", "-S", "-c", _LIMITED, str(memory), str(FILE_SIZE), *limited]
    try:
        with output.open("wb") as file:
            subprocess.run(
                limited,
                cwd=folder,
                stdin=subprocess.DEVNULL,
                stdout=file,
                stderr=subprocess.STDOUT,
                timeout=timeout,
                check=False,
            )
    except subprocess.TimeoutExpired:
        raise WorkFailedError(f"{command[0]} did not end within {timeout:g} s") from None
    except OSError as error:
        raise WorkFailedError(f"{command[0]} cannot be run: {error.strerror}") from None
    with output.open("rb") as file:
        return file.read(_READ).decode(errors="replace")


def last_line(output: str) -> str:
    """Return the last line that is not empty: programs print the reason of a failure there."""
    return next(
        (line.strip() for line in reversed(output.splitlines()) if line.strip()), "it printed nothing"
    )
