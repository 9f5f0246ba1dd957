"""The folder of files of one agent: the meshes of its hull, the facts, and writing it in one step."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from driftform.errors import WorkFailedError
from driftform.types import Body, FloatArray, WrittenFile
from driftform.util import files
from driftform_robotics.models.link import Link
from driftform_robotics.models.meshes import Piece, convex_pieces, obj_text, revolve_contour

HULL = "meshes/hull.obj"
"""File of the outer surface of the hull, about the centre of gravity."""

PIPE = "meshes/pipe.obj"
"""File of the pipe's wall, about its middle."""


def piece_path(index: int) -> str:
    """Return the path of one convex piece, whose mesh is about its own centroid."""
    return f"meshes/piece_{index:02d}.obj"


def hull_files(body: Body, cog: FloatArray, pieces: list[Piece]) -> dict[str, str]:
    """Return the meshes of the hull by their paths in the folder."""
    hull = {HULL: obj_text(revolve_contour(body.outer).translate(-cog))}
    return hull | {piece_path(i): obj_text(piece.mesh) for i, piece in enumerate(pieces)}


def cut_hull(body: Body) -> list[Piece]:
    """Return the convex pieces of the outer hull.

    Raises
    ------
    WorkFailedError
        if the contour does not enclose a solid.
    """
    contour = body.outer
    if len(contour) < 3 or contour[0, 1] or contour[-1, 1] or not (contour[1:-1, 1] > 0).any():
        raise WorkFailedError("the hull is not a solid: its outer contour does not start and end on the axis")
    return convex_pieces(contour)


def save_folder(
    name: str, folder: Path, texts: Mapping[str, str], facts: dict[str, Any]
) -> tuple[WrittenFile, ...]:
    """Write texts by their paths in the folder; the facts belong to the first file, which is the file to open.

    Raises
    ------
    WorkFailedError
        if they cannot be written.
    """
    try:
        with files.write_folder(folder) as part:
            for path, text in texts.items():
                (part / path).parent.mkdir(parents=True, exist_ok=True)
                (part / path).write_text(text, encoding="utf-8")
                if text.startswith("#!"):
                    (part / path).chmod(0o755)
    except OSError as error:
        raise WorkFailedError(f"cannot write {folder}: {error.strerror or error}") from error
    first = next(iter(texts))
    return tuple(WrittenFile(name, str(folder / path), facts if path == first else {}) for path in texts)


def model_facts(link: Link, warnings: list[str]) -> dict[str, Any]:
    """Return the facts of a model, see :meth:`driftform_robotics.models.exporter.ModelExporter.write`."""
    facts = {
        "mass_kg": link.mass,
        "cog_mm": -1e3 * float(link.core[0]),
        "cob_mm": 1e3 * float(link.buoyancy[0] - link.core[0]),
        "volume_mm3": 1e9 * link.volume,
        "added_over_own_mass": link.added_mass_ratio,
    }
    return facts | ({"warnings": " ".join(warnings)} if warnings else {})
