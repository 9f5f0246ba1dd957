"""A folder of files for one agent, written whole, with the hull's meshes in it."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from driftform.errors import WorkFailedError
from driftform.types import Body, FloatArray, WrittenFile
from driftform.util.files import write_folder
from driftform_robotics.models.link import Link
from driftform_robotics.models.meshes import Piece, convex_pieces, obj_text, revolved

HULL = "meshes/hull.obj"
"""The outside of the hull, about the centre of gravity."""

PIPE = "meshes/pipe.obj"
"""The pipe's wall, about its middle."""


def piece_path(index: int) -> str:
    """Return the file of one of the pieces that collide, about its own centroid."""
    return f"meshes/piece_{index:02d}.obj"


def hull_files(body: Body, cog: FloatArray, pieces: list[Piece]) -> dict[str, str]:
    """Return the hull's meshes, by their paths in the folder."""
    files = {HULL: obj_text(revolved(body.outer).moved(-cog))}
    return files | {piece_path(i): obj_text(piece.mesh) for i, piece in enumerate(pieces)}


def cut_hull(body: Body) -> list[Piece]:
    """Return the convex pieces of the outside of the hull.

    Raises
    ------
    WorkFailedError
        where the contour has no solid.
    """
    contour = body.outer
    if len(contour) < 3 or contour[0, 1] or contour[-1, 1] or not (contour[1:-1, 1] > 0).any():
        raise WorkFailedError(
            "the hull has no solid: its outer contour does not go from the axis to the axis"
        )
    return convex_pieces(contour)


def save_folder(
    name: str, folder: Path, files: Mapping[str, str], facts: dict[str, Any]
) -> tuple[WrittenFile, ...]:
    """Write texts by their paths in the folder; the first is the one to open, and has the facts.

    Raises
    ------
    WorkFailedError
        where they cannot be written.
    """
    try:
        with write_folder(folder) as part:
            for path, text in files.items():
                (part / path).parent.mkdir(parents=True, exist_ok=True)
                (part / path).write_text(text, encoding="utf-8")
    except OSError as error:
        raise WorkFailedError(f"cannot write {folder}: {error.strerror or error}") from error
    first = next(iter(files))
    return tuple(WrittenFile(name, str(folder / path), facts if path == first else {}) for path in files)


def model_facts(link: Link, beware: list[str]) -> dict[str, Any]:
    """Facts of a model: ``mass_kg``, ``cog_mm`` and ``cob_mm`` along the axis from the core's centre,
    ``volume_mm3``, ``added_over_own_mass``, and what to ``beware`` of, if anything.
    """
    facts = {
        "mass_kg": link.mass,
        "cog_mm": -1e3 * float(link.core[0]),
        "cob_mm": 1e3 * float(link.buoyancy[0] - link.core[0]),
        "volume_mm3": 1e9 * link.volume,
        "added_over_own_mass": link.added_mass_ratio,
    }
    return facts | ({"beware": " ".join(beware)} if beware else {})
