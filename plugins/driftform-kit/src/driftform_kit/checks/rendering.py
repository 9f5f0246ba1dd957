"""OpenSCAD source, rendered to a mesh by OpenSCAD."""

from pathlib import Path

from driftform.errors import InputError, WorkFailedError
from driftform_kit.checks.programs import explain_missing, run_program

TIMEOUT = 300.0


def render(source: Path, folder: Path, timeout: float = TIMEOUT) -> Path:
    """Render OpenSCAD source to a mesh within ``folder``, and return its path.

    Raises WorkFailedError if OpenSCAD is not installed or does not end in time, and InputError with its reason if the
    source has no solid, or a part of it is left out.
    """
    if reason := explain_missing("openscad"):
        raise WorkFailedError(f"{source}: only OpenSCAD can read it: {reason}")
    mesh = folder / "rendered.stl"
    said = run_program(["openscad", "-o", str(mesh), str(source.resolve())], folder, timeout)
    # OpenSCAD leaves out a part that it cannot make, and prints such a line only.
    faults = [line.strip() for line in said.splitlines() if "ERROR" in line or "WARNING" in line]
    if faults or not mesh.is_file():
        raise InputError(f"{source}: OpenSCAD: {faults[0] if faults else 'no solid in the source'}")
    return mesh
