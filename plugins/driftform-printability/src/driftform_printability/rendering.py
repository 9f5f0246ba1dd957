"""OpenSCAD source, rendered to a mesh by OpenSCAD."""

from pathlib import Path

from driftform.errors import InputError, WorkFailedError
from driftform_printability.programs import explain_missing, run_program

TIMEOUT = 300.0


def render(source: Path, folder: Path, timeout: float = TIMEOUT) -> Path:
    """Render OpenSCAD source to a mesh within ``folder``, and return its path.

    Raises
    ------
    WorkFailedError
        where OpenSCAD is not there or does not come to an end.
    InputError
        where it makes no solid of the source, or leaves out a part of it; the message has its reason.
    """
    if reason := explain_missing("openscad"):
        raise WorkFailedError(f"{source}: can be read by OpenSCAD only: {reason}")
    mesh = folder / "rendered.stl"
    said = run_program(["openscad", "-o", str(mesh), str(source.resolve())], folder, timeout)
    # A part that could not be made is left out with no more than such a line.
    faults = [line.strip() for line in said.splitlines() if "ERROR" in line or "WARNING" in line]
    if faults or not mesh.is_file():
        raise InputError(f"{source}: OpenSCAD: {faults[0] if faults else 'it makes no solid of it'}")
    return mesh
