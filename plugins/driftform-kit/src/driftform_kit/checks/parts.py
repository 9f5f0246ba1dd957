"""The parts of a printable file: meshes with shared vertices in mm, as they lie on the bed."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from driftform.agent.meshes import IntArray, merge_vertices, signed_volume
from driftform.types import FloatArray

MM_PER_M = 1000.0

MOST_PIECES = 10_000
"""Largest number of meshes in a file, each counted as often as it is placed."""

MOST_ELEMENTS = 5_000_000
"""Largest number of triangles, and of vertices, in a file, with those of all placed copies."""

MM3_PER_M3 = 1e9


@dataclass(frozen=True, eq=False)
class Part:
    """One piece of a file.

    Attributes
    ----------
    name
        its name in the file, or the file's own name.
    vertices
        mm, z up, (n, 3); no two are the same.
    triangles
        indices of their corners, counterclockwise seen from outside, (m, 3).
    """

    name: str
    vertices: FloatArray
    triangles: IntArray

    @property
    def volume(self) -> float:
        """Volume inside the mesh, mm3; negative if its triangles face inward."""
        return signed_volume(self.vertices, self.triangles)

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


def check_counts(pieces: int, elements: int) -> None:
    """Refuse a file that a few bytes could make larger than any memory, by placing copies of copies.

    Raises
    ------
    ValueError
        if it has more than :data:`MOST_PIECES` meshes or :data:`MOST_ELEMENTS` triangles or vertices.
    """
    if pieces > MOST_PIECES:
        raise ValueError(f"places more than {MOST_PIECES} meshes")
    if elements > MOST_ELEMENTS:
        raise ValueError(f"has more than {MOST_ELEMENTS} triangles or vertices")


def make_part(name: str, vertices: npt.ArrayLike, triangles: npt.ArrayLike) -> Part:
    """Return a part with vertices of equal coordinates merged; triangles that collapse are left out.

    Files of loose triangles hold each vertex several times, and others do if normals or colours differ.
    """
    points = np.asarray(vertices, dtype=np.float64).reshape(-1, 3)
    return Part(name, *merge_vertices(points, np.asarray(triangles, dtype=np.int64).reshape(-1, 3)))
