"""The parts of a printable file: welded meshes in mm, as they stand on the bed."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from driftform.types import FloatArray

IntArray = npt.NDArray[np.int64]

MM_PER_M = 1000.0
MM3_PER_M3 = 1e9


@dataclass(frozen=True, eq=False)
class Part:
    """One piece of a file.

    Attributes
    ----------
    name
        what the file calls it, or the file's own name.
    vertices
        mm, z up, (n, 3); no two are the same.
    triangles
        indices of their corners, counterclockwise seen from outside, (m, 3).
    """

    name: str
    vertices: FloatArray
    triangles: IntArray

    @property
    def corners(self) -> FloatArray:
        """The triangles' corners, (m, 3 corners, 3), mm."""
        corners: FloatArray = self.vertices[self.triangles]
        return corners

    @property
    def bounds(self) -> FloatArray:
        """Lowest and highest coordinates, mm, (2, 3)."""
        return np.array([self.vertices.min(axis=0), self.vertices.max(axis=0)])

    @property
    def size(self) -> FloatArray:
        """Width, depth and height, mm, (3,)."""
        lowest, highest = self.bounds
        extent: FloatArray = highest - lowest
        return extent


def welded(name: str, vertices: npt.ArrayLike, triangles: npt.ArrayLike) -> Part:
    """Return a part whose vertices of equal coordinates are joined; triangles that collapse by it are left out.

    Files of loose triangles hold each vertex several times, and others do where normals or colours differ.
    """
    # Adding zero turns -0.0 into 0.0, so that both are one vertex.
    points = np.asarray(vertices, dtype=np.float64).reshape(-1, 3) + 0.0
    unique, index = np.unique(points, axis=0, return_inverse=True)
    joined = index.reshape(-1)[np.asarray(triangles, dtype=np.int64).reshape(-1, 3)].astype(np.int64)
    a, b, c = joined.T
    return Part(name, unique, joined[(a != b) & (b != c) & (c != a)])


def doubled_areas(corners: FloatArray) -> FloatArray:
    """Normals of triangles, of twice their area's length, (m, 3)."""
    normals: FloatArray = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return normals


def signed_volume(corners: FloatArray) -> float:
    """Volume inside a closed mesh, in the cube of its unit; negative where its triangles face inward."""
    # Seen from the mesh's middle, the tetrahedra are small and so is the rounding error.
    a, b, c = np.moveaxis(corners - corners.reshape(-1, 3).mean(axis=0), 1, 0)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)
