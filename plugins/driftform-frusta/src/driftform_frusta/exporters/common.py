"""Shared by exporters of hulls: saving and naming files, and the facts of solids."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from driftform.errors import WorkFailedError
from driftform.interfaces import ExportJob
from driftform.types import Body, WrittenFile
from driftform.util import files

if TYPE_CHECKING:
    from driftform_frusta.kit_options import PartOptions
    from driftform_frusta.parts import Part


def save(path: Path, data: bytes | str) -> None:
    """Write a whole file; text in UTF-8.

    Raises
    ------
    WorkFailedError
        if it cannot be written.
    """
    raw = data.encode() if isinstance(data, str) else data
    try:
        files.write_whole(path, lambda part: part.write_bytes(raw))
    except OSError as error:
        raise WorkFailedError(f"cannot write {path}: {error.strerror or error}") from error


def write_sheet(name: str, job: ExportJob, options: "PartOptions", path: Path) -> tuple[WrittenFile, ...]:
    """Write the assembly sheet of a kit beside the file ``path`` of a format, as SVG, and as PDF if the extra ``pdf`` is
    installed; nothing without a kit.

    Raises
    ------
    WorkFailedError
        if it cannot be written.
    """
    if not options.kit:
        return ()
    from driftform.figures import files as picture_files
    from driftform_frusta.kits import find_maker

    target = path.with_name(f"{path.stem}-assembly.svg")
    drawn = find_maker().draw_sheet(job, options, name)
    save(target, drawn)
    printed = picture_files.make_pdf(drawn)
    if printed is None:
        return (WrittenFile(name, str(target)),)
    page = target.with_suffix(".pdf")
    save(page, printed)
    return (WrittenFile(name, str(target)), WrittenFile(name, str(page)))


def path_of_part(path: Path, part: "Part", parts: "Sequence[Part]") -> Path:
    """Return the file of one part, in a format that holds one solid: ``agent-fore-shell.stl`` for ``agent.stl``."""
    if len(parts) == 1:
        return path
    return path.with_name(f"{path.stem}-{part.name.replace(' ', '-')}{path.suffix}")


def facts_of_part(part: "Part", body: Body) -> dict[str, Any]:
    """Facts of one part: ``volume_mm3``, ``mass_kg``, ``size_mm`` and ``shells``."""
    from driftform_frusta.printable import MM3_PER_M3

    volume = part.solid.volume
    return {
        "volume_mm3": volume,
        "mass_kg": volume / MM3_PER_M3 * body.hull_density,
        "size_mm": np.ptp(part.solid.bounds, axis=0).tolist(),
        "shells": len(part.solid.shells),
    }


def facts_of_all(parts: "Sequence[Part]", body: Body) -> dict[str, Any]:
    """Facts of parts in one file: of the only one, or the sums and the ``parts`` by name."""
    from driftform_frusta.printable import MM3_PER_M3

    if len(parts) == 1:
        return facts_of_part(parts[0], body)
    volume = sum(part.solid.volume for part in parts)
    return {
        "parts": [part.name for part in parts],
        "volume_mm3": volume,
        "mass_kg": volume / MM3_PER_M3 * body.hull_density,
        "shells": sum(len(part.solid.shells) for part in parts),
    }
