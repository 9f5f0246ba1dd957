"""Solid -> the mesh that files hold: in single precision, welded, and compared with the solid.

Files for printers and viewers hold coordinates in single precision, or are read in it. So it is the mesh after
rounding and welding that must be closed and keep its volume, and that is the one to check and to write.
"""

import numpy as np

from driftform.errors import WorkFailedError
from driftform.types import FloatArray
from driftform_frusta.boundary import Solid
from driftform_frusta.triangles import Mesh


def make_mesh(solid: Solid, name: str = "hull", frame: FloatArray | None = None) -> Mesh:
    """Return the mesh of a solid, rounded to single precision and checked after that.

    Args:
        solid: in mm.
        name: of the mesh.
        frame: matrix from its points to those of the mesh, (3, 3); the identity by default.

    Raises WorkFailedError if the rounded mesh is not closed, or its volume differs from the solid's by more than
    rounding explains.
    """
    points, expected = solid.vertices, solid.volume
    if frame is not None:
        points = points @ frame.T
        expected *= float(np.linalg.det(frame))
    mesh = Mesh(points.astype(np.float32), solid.triangles, name).merge_vertices()
    if not mesh.is_closed:
        raise WorkFailedError(f"the mesh of the {name} does not stay closed in single precision")
    # Rounding moves a vertex by half a unit in the last place at most, in each of three directions, and so the
    # volume by no more than the surface times that.
    spacing = float(np.spacing(np.abs(mesh.vertices).max()))
    if abs(mesh.volume - expected) > np.sqrt(3) / 2 * spacing * mesh.area:
        raise WorkFailedError(
            f"the mesh of the {name} has a volume of {mesh.volume:.6g} in single precision, its solid {expected:.6g}"
        )
    return mesh
