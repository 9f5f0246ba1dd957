"""Printable files -> the meshes of their parts, in mm and z up, whatever the format."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from driftform.errors import InputError, WorkFailedError
from driftform_frusta.csg import MM
from driftform_frusta.triangles import Mesh
from driftform_kit.checks.programs import render
from driftform_kit.checks.threemf import check_counts, read_3mf

# glTF is in metres with y up: here z is up, and the axis towards the viewer points along -y.
_FROM_GLTF = MM * np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


_MAX_NAME = 40

_STL_HEAD, _STL_FACET = 84, 50
"""Bytes of a binary STL file: up to its first triangle, and of each."""


def read_meshes(path: Path) -> tuple[Mesh, ...]:
    """Return the meshes of a file, one for each part, at least one; no two vertices of a mesh are the same.

    STL, OBJ and PLY have no unit and are taken to be in mm; 3MF states its unit, GLB is in metres with y up. OpenSCAD
    source is rendered.

    Raises:
        InputError: if it is not a file of its format, or has no triangle.
        WorkFailedError: if OpenSCAD is needed and not installed.
    """
    try:
        status = path.stat()
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    return _read(path, status.st_mtime_ns, status.st_size)


@lru_cache(maxsize=32)
def _read(path: Path, _changed: int, _size: int) -> tuple[Mesh, ...]:
    suffix = path.suffix.lower()
    if suffix not in _READERS:
        raise InputError(f"{path}: is not a printable file by its suffix; known: {', '.join(sorted(_READERS))}")
    try:
        parts = _READERS[suffix](path)
    except (InputError, WorkFailedError):
        raise
    except Exception as error:
        # A reader of unknown files may fail in any way.
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"{path}: cannot be read as {suffix[1:].upper()}: {reason}") from None
    parts = tuple(part for part in parts if len(part.triangles))
    if not parts:
        raise InputError(f"{path}: has no triangle")
    for part in parts:
        if not np.isfinite(part.vertices).all():
            raise InputError(f"{path}: {part.name} has coordinates that are not finite")
    # Names that are safe in a line of a report: without control characters, and not too long.
    names = ("".join(filter(str.isprintable, part.name))[:_MAX_NAME] or "part" for part in parts)
    return tuple(replace(part, name=name) for part, name in zip(parts, names, strict=True))


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


def _read_with_trimesh(path: Path) -> tuple[Mesh, ...]:
    import trimesh

    scene = trimesh.load_scene(path, process=False, skip_materials=True, split_object=True)
    nodes = scene.graph.nodes_geometry
    check_counts(len(nodes), 0)
    sizes = {
        name: max(len(getattr(mesh, "faces", ())), len(getattr(mesh, "vertices", ())))
        for name, mesh in scene.geometry.items()
    }
    check_counts(0, sum(sizes[scene.graph[node][1]] for node in nodes))
    alone = len(scene.geometry) == 1
    return tuple(
        Mesh(
            np.array(mesh.vertices, dtype=np.float64).reshape(-1, 3),
            np.array(mesh.faces, dtype=np.int64).reshape(-1, 3),
            path.stem if alone else str(mesh.metadata["name"]),
        ).merge_vertices()
        for mesh in scene.dump()
        if isinstance(mesh, trimesh.Trimesh)
    )


def _read_stl(path: Path) -> tuple[Mesh, ...]:
    """Read a text or binary STL file. Raises ValueError if it ends too early: readers guess what such a file is."""
    content = path.read_bytes()
    if content.lstrip()[:5].lower() == b"solid" and b"\0" not in content[:_STL_HEAD]:
        if b"endsolid" not in content[content.rfind(b"vertex") :].lower():
            raise ValueError(
                f"is truncated in triangle {content.count(b'facet normal')}: it has no 'endsolid'; export it again"
            )
    elif len(content) < _STL_HEAD:
        raise ValueError(
            f"is truncated, or no STL file: it has {len(content)} bytes, fewer than the header; export it again"
        )
    else:
        stated, held = int.from_bytes(content[80:_STL_HEAD], "little"), (len(content) - _STL_HEAD) / _STL_FACET
        if held != stated:
            fault = "truncated, or no STL file" if held < stated else "no STL file"
            raise ValueError(f"is {fault}: it states {stated} triangles, and has {held:g}; export it again")
    return _read_with_trimesh(path)


def _read_gltf(path: Path) -> tuple[Mesh, ...]:
    parts = _read_with_trimesh(path)
    return tuple(replace(part, vertices=part.vertices @ _FROM_GLTF.T).merge_vertices() for part in parts)


def _read_scad(path: Path) -> tuple[Mesh, ...]:
    with TemporaryDirectory() as folder:
        [part] = _read_with_trimesh(render(path, Path(folder)))
    return (replace(part, name=path.stem),)


_READERS: dict[str, Callable[[Path], tuple[Mesh, ...]]] = {
    ".stl": _read_stl,
    ".obj": _read_with_trimesh,
    ".ply": _read_with_trimesh,
    ".glb": _read_gltf,
    ".3mf": read_3mf,
    ".scad": _read_scad,
}
