"""Reads meshes and STEP files of other programs: triangles, and nothing else; called in a process with limits."""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from driftform.errors import WorkFailedError
from driftform.types import FloatArray

MESHES = (".stl", ".obj", ".ply", ".glb", ".step", ".stp")
"""Formats that can be read."""

MAX_TRIANGLES = 2_000_000


def read_triangles(name: str) -> FloatArray:
    """Return the corners of the triangles of a file, in its unit (mm for STEP), (m, 3, 3).

    A ValueError says why it cannot be read, without its name.
    """
    path = Path(name)
    try:
        triangles = _read_step(path) if path.suffix.lower() in (".step", ".stp") else _load(path)
    except WorkFailedError:
        raise
    except Exception as error:
        # Readers of broken files raise whatever they stumble over.
        text = " ".join(str(error).split())[:120] or type(error).__name__
        raise ValueError(f"cannot be read as {path.suffix[1:].upper()}: {text}") from None
    if not 0 < len(triangles) <= MAX_TRIANGLES:
        raise ValueError(f"has {len(triangles)} triangles; a mesh has 1 to {MAX_TRIANGLES}")
    if not np.isfinite(triangles).all():
        raise ValueError("has coordinates that are not finite")
    return triangles


def _load(path: Path) -> FloatArray:
    import trimesh

    mesh: Any = trimesh.load(path, force="mesh", process=False, skip_materials=True)
    if not len(mesh.faces):
        raise ValueError("no triangle is in it")
    return np.asarray(mesh.vertices[mesh.faces], dtype=np.float64).reshape(-1, 3, 3)


def _read_step(path: Path) -> FloatArray:
    """Return triangles of the solids of a STEP file, within 1e-4 of their size."""
    from driftform_frusta.brep import require_opencascade

    require_opencascade()
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.IFSelect import IFSelect_RetDone
    from OCP.STEPControl import STEPControl_Reader
    from OCP.StlAPI import StlAPI_Writer

    reader, box, writer = STEPControl_Reader(), Bnd_Box(), StlAPI_Writer()
    if reader.ReadFile(str(path)) != IFSelect_RetDone:
        raise ValueError("it is not STEP")
    reader.TransferRoots()
    shape = reader.OneShape()
    BRepBndLib.Add_s(shape, box)
    BRepMesh_IncrementalMesh(shape, 1e-4 * box.SquareExtent() ** 0.5, False, 0.05)
    writer.ASCIIMode = False
    with TemporaryDirectory() as folder:
        writer.Write(shape, f"{folder}/solid.stl")
        return _load(Path(folder, "solid.stl"))
