"""Other programs: whether they are installed, and their output. Their exit codes prove little.

admesh always returns 0, OpenSCAD 0 with an ERROR line, PrusaSlicer nearly always 0.
"""

import shutil
from pathlib import Path

from driftform.errors import InputError, WorkFailedError
from driftform.util.foreign import run_program

TIMEOUT = 300.0
"""Time limit of a program for each file, s."""


def require_program(program: str) -> None:
    """Check that a program is on PATH. Raises WorkFailedError if it is not."""
    if shutil.which(program) is None:
        raise WorkFailedError(f"{program} is not on PATH")


def last_line(output: str) -> str:
    """Return the last line that is not empty: programs print the reason of a failure there."""
    return next((line.strip() for line in reversed(output.splitlines()) if line.strip()), "it printed nothing")


def render(source: Path, folder: Path) -> Path:
    """Render OpenSCAD source to a mesh within ``folder``, and return its path.

    Raises WorkFailedError if OpenSCAD is not installed or does not end in time, and InputError with its reason if the
    source has no solid, or a part of it is left out.
    """
    try:
        require_program("openscad")
    except WorkFailedError as error:
        raise WorkFailedError(f"{source}: only OpenSCAD can read it: {error}") from None
    mesh = folder / "rendered.stl"
    said = run_program(["openscad", "-o", str(mesh), str(source.resolve())], folder, TIMEOUT)
    # OpenSCAD leaves out a part that it cannot make, and prints such a line only.
    faults = [line.strip() for line in said.splitlines() if "ERROR" in line or "WARNING" in line]
    if faults or not mesh.is_file():
        raise InputError(f"{source}: OpenSCAD: {faults[0] if faults else 'no solid in the source'}")
    return mesh
