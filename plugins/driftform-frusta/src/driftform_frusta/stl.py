"""Binary STL files, and what keeps them sound: welding, closedness, volume.

An STL file holds loose triangles in single precision; a reader joins them again by their coordinates. So it
is the mesh after rounding and welding that must be closed, and that is the one to check and to write.
"""

import numpy as np
import numpy.typing as npt

from driftform.types import FloatArray

# A reader that finds "solid" at the beginning takes the file for the text form of STL.
_HEADER = b"driftform binary STL, lengths in mm".ljust(80)

# Odd numbers without a pattern; what overflows is cut off.
_MIXER = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], dtype=np.uint64)

_FACET = np.dtype([("normal", "<f4", (3,)), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def weld(
    vertices: npt.ArrayLike, triangles: npt.ArrayLike
) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.int64]]:
    """Round vertices to single precision and join those that fall together.

    Triangles that lose a corner by it are left out.

    Parameters
    ----------
    vertices
        (n, 3).
    triangles
        indices of their corners, (m, 3).
    """
    # Adding zero turns -0.0 into 0.0: some readers compare the bytes.
    rounded = np.asarray(vertices, dtype=np.float32) + np.float32(0)
    corners = np.asarray(triangles, dtype=np.int64)
    if _all_differ(rounded):
        return rounded, corners
    unique, index = np.unique(rounded, axis=0, return_inverse=True)
    welded = index.reshape(-1)[corners].astype(np.int64)
    a, b, c = welded.T
    return unique, welded[(a != b) & (b != c) & (c != a)]


def _all_differ(rounded: npt.NDArray[np.float32]) -> bool:
    """Tell whether surely no two vertices are the same: comparing one number of each is fast."""
    bits = np.ascontiguousarray(rounded).view(np.uint32).astype(np.uint64)
    keys = np.sort(bits @ _MIXER)
    return bool((keys[1:] != keys[:-1]).all())


def is_closed(triangles: npt.NDArray[np.int64]) -> bool:
    """Tell whether a mesh is closed and consistently oriented.

    It is where each edge belongs to exactly two triangles, once in each direction.
    """
    if not len(triangles):
        return False
    n = int(triangles.max()) + 1
    start = triangles.reshape(-1)
    end = np.roll(triangles, -1, axis=1).reshape(-1)
    # Short numbers sort faster.
    short = np.uint32 if n < 2**16 else np.int64
    forward = np.sort((start * n + end).astype(short))
    backward = np.sort((end * n + start).astype(short))
    return bool((forward[1:] != forward[:-1]).all() and (forward == backward).all())


def signed_volume(vertices: npt.ArrayLike, triangles: npt.ArrayLike) -> float:
    """Volume inside a closed mesh, in the cube of its unit; negative where its triangles face inward."""
    corners = _corners(vertices, triangles)
    # Seen from the mesh's middle, the tetrahedra are small and so is the rounding error.
    corners -= corners.reshape(-1, 3).mean(axis=0)
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def surface_area(vertices: npt.ArrayLike, triangles: npt.ArrayLike) -> float:
    """Area of a mesh, in the square of its unit."""
    return float(np.linalg.norm(_doubled_areas(_corners(vertices, triangles)), axis=1).sum() / 2)


def binary_stl(vertices: npt.ArrayLike, triangles: npt.ArrayLike) -> bytes:
    """Return a mesh as a little-endian binary STL file; normals follow from the triangles.

    Parameters
    ----------
    vertices
        mm, (n, 3); written in single precision.
    triangles
        indices of their corners, counterclockwise seen from outside, (m, 3).

    Raises
    ------
    ValueError
        where a coordinate is not finite.
    """
    corners = _corners(np.asarray(vertices, dtype=np.float32), triangles)
    if not np.isfinite(corners).all():
        raise ValueError("an STL file cannot hold coordinates that are not finite")
    normals = _doubled_areas(corners)
    size = np.linalg.norm(normals, axis=1, keepdims=True)
    facets = np.zeros(len(corners), dtype=_FACET)
    facets["normal"] = np.divide(normals, size, out=np.zeros_like(normals), where=size > 0)
    facets["corners"] = corners
    return _HEADER + len(facets).to_bytes(4, "little") + facets.tobytes()


def _corners(vertices: npt.ArrayLike, triangles: npt.ArrayLike) -> FloatArray:
    """The triangles' corners, (m, 3 corners, 3), in double precision."""
    corners: FloatArray = np.asarray(vertices, dtype=np.float64)[np.asarray(triangles, dtype=np.int64)]
    return corners


def _doubled_areas(corners: FloatArray) -> FloatArray:
    """Normals of the triangles, of twice their area's length, (m, 3)."""
    normals: FloatArray = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return normals
