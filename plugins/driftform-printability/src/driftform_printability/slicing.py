"""Files as the programs of a maker read them: one STL for each part, whatever the format was."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from driftform_printability.parts import Part, doubled_areas
from driftform_printability.reading import read_parts

_FACET = np.dtype([("normal", "<f4", (3,)), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def as_stl(files: Sequence[Path], folder: Path) -> list[Path]:
    """Return the STL files themselves, and for other formats a copy of each part in ``folder``."""
    found = []
    for path in files:
        if path.suffix.lower() == ".stl":
            found.append(path.resolve())
            continue
        for number, part in enumerate(read_parts(path), 1):
            copy = folder / f"{path.stem}-{number}.stl"
            _write(copy, part)
            found.append(copy)
    return found


def _write(path: Path, part: Part) -> None:
    corners = part.corners
    normals = doubled_areas(corners)
    size = np.linalg.norm(normals, axis=1, keepdims=True)
    facets = np.zeros(len(corners), dtype=_FACET)
    facets["normal"] = np.divide(normals, size, out=np.zeros_like(normals), where=size > 0)
    facets["corners"] = corners
    path.write_bytes(
        b"copy of a part, lengths in mm".ljust(80, b"\0")
        + np.uint32(len(facets)).tobytes()
        + facets.tobytes()
    )
