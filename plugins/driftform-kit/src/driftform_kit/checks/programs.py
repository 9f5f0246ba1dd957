"""Other programs: whether they are there, and what they say. Their exit codes prove little.

admesh always returns 0, OpenSCAD 0 with an ERROR line, PrusaSlicer nearly always 0.
"""

import shutil
from collections.abc import Sequence
from pathlib import Path

from driftform.util import foreign

MEMORY = 8 << 30
"""Most memory of a program, bytes."""


def explain_missing(program: str) -> str:
    """Return the reason why a program cannot be run, ``""`` if it can."""
    return "" if shutil.which(program) else f"{program} is not on PATH"


def run_program(command: Sequence[str], folder: Path, timeout: float, memory: int = MEMORY) -> str:
    """Run a program with limits of time (s) and memory (bytes); see :func:`driftform.util.foreign.run_program`."""
    return foreign.run_program(command, folder, timeout, memory)


def last_line(output: str) -> str:
    """Return the last line that is not empty: programs print the reason of a failure there."""
    return next((line.strip() for line in reversed(output.splitlines()) if line.strip()), "it printed nothing")
