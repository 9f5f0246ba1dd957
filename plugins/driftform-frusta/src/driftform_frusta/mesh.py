"""Solid -> the mesh that files hold: in single precision, welded, and compared with the solid.

Files for printers and viewers hold coordinates in single precision, or are read in it. So it is the mesh after
rounding and welding that must be closed and keep its volume, and that is the one to check and to write.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from driftform.agent.meshes import is_closed, merge_vertices, signed_volume, surface_area
from driftform.errors import WorkFailedError
from driftform.types import FloatArray
from driftform_frusta.boundary import Solid


@dataclass(frozen=True, eq=False)
class Mesh:
    """A closed mesh.

    Attributes
    ----------
    vertices
        (n, 3), in the unit of its frame.
    triangles
        indices of their corners, counterclockwise seen from outside, (m, 3).
    volume
        inside it, in the cube of the unit.
    """

    vertices: npt.NDArray[np.float32]
    triangles: npt.NDArray[np.int64]
    volume: float


def make_mesh(solid: Solid, what: str = "hull", frame: FloatArray | None = None) -> Mesh:
    """Return the mesh of a solid, rounded to single precision and checked after that.

    Parameters
    ----------
    solid
        in mm.
    what
        its name in messages.
    frame
        matrix from its points to those of the mesh, (3, 3); the identity by default.

    Raises
    ------
    WorkFailedError
        if the rounded mesh is not closed, or its volume differs from the solid's by more than rounding explains.
    """
    points, expected = solid.vertices, solid.volume
    if frame is not None:
        points = points @ frame.T
        expected *= float(np.linalg.det(frame))
    vertices, triangles = merge_vertices(points.astype(np.float32), solid.triangles)
    if not is_closed(triangles):
        raise WorkFailedError(f"the mesh of the {what} does not stay closed in single precision")
    volume = signed_volume(vertices, triangles)
    # Rounding moves a vertex by half a unit in the last place at most, in each of three directions, and so the
    # volume by no more than the surface times that.
    spacing = float(np.spacing(np.abs(vertices).max()))
    if abs(volume - expected) > np.sqrt(3) / 2 * spacing * surface_area(vertices, triangles):
        raise WorkFailedError(
            f"the mesh of the {what} has a volume of {volume:.6g} in single precision, its solid {expected:.6g}"
        )
    return Mesh(vertices, triangles, volume)
