"""Files for other programs: one STL for each part, whatever the format."""

from collections.abc import Sequence
from pathlib import Path

from driftform_kit.reading import read_meshes


def provide_stl(files: Sequence[Path], folder: Path) -> list[Path]:
    """Return the STL files themselves, and for other formats a copy of each part in ``folder``."""
    found = []
    for path in files:
        if path.suffix.lower() == ".stl":
            found.append(path.resolve())
            continue
        for number, part in enumerate(read_meshes(path), 1):
            copy = folder / f"{path.stem}-{number}.stl"
            copy.write_bytes(part.to_stl())
            found.append(copy)
    return found
