"""Binary STL files, and what keeps them sound: welding, closedness, volume.

An STL file holds loose triangles in single precision; a reader joins them again by their coordinates. So it
is the mesh after rounding and welding that must be closed, and that is the one to check and to write.
"""

import numpy as np
import numpy.typing as npt

from driftform.types import FloatArray

# A reader that finds "solid" at the beginning takes the file for the text form of STL. NULs end the header, because
# admesh prints it as a C string: without one it prints the bytes that follow in memory too.
_HEADER = b"driftform binary STL, lengths in mm".ljust(80, b"\0")

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
    if not len(triangles) or len(triangles) % 2:
        return False
    n = int(triangles.max()) + 1
    corners = np.ascontiguousarray(triangles.T)
    start, end = corners.reshape(-1), corners[[1, 2, 0]].reshape(-1)
    # Short numbers sort faster. The last bit tells the direction, so that sorting brings both next to each other.
    both = 2 * (np.minimum(start, end) * n + np.maximum(start, end)) + (start > end)
    both = np.sort(both.astype(np.uint32 if 2 * n * n < 2**32 else np.int64))
    there, back = both[::2], both[1::2]
    return bool((there % 2 == 0).all() and (back == there + 1).all() and (there[1:] != there[:-1]).all())


def signed_volume(vertices: npt.ArrayLike, triangles: npt.ArrayLike) -> float:
    """Volume inside a closed mesh, in the cube of its unit; negative where its triangles face inward."""
    points = np.asarray(vertices, dtype=np.float64)
    # Seen from the mesh's middle, the tetrahedra are small and so is the rounding error.
    a, b, c = _corners(points - points.mean(axis=0), triangles)
    return float((a * _cross(b, c)).sum() / 6)


def surface_area(vertices: npt.ArrayLike, triangles: npt.ArrayLike) -> float:
    """Area of a mesh, in the square of its unit."""
    return float(_lengths(_doubled_areas(*_corners(vertices, triangles))).sum() / 2)


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
    a, b, c = corners = _corners(np.asarray(vertices, dtype=np.float32), triangles)
    if not np.isfinite(corners).all():
        raise ValueError("an STL file cannot hold coordinates that are not finite")
    normals = _doubled_areas(a, b, c)
    size = _lengths(normals)
    facets = np.zeros(corners.shape[-1], dtype=_FACET)
    facets["normal"] = np.divide(normals, size, out=np.zeros_like(normals), where=size > 0).T
    facets["corners"] = corners.transpose(2, 0, 1)
    return _HEADER + len(facets).to_bytes(4, "little") + facets.tobytes()


def _corners(vertices: npt.ArrayLike, triangles: npt.ArrayLike) -> FloatArray:
    """The triangles' corners in double precision, (3 corners, 3 coordinates, m): numpy is quick along long rows."""
    rows = np.ascontiguousarray(np.asarray(vertices, dtype=np.float64).T)
    index = np.ascontiguousarray(np.asarray(triangles, dtype=np.int64).T)
    return np.stack([row[index] for row in rows], axis=1)


def _doubled_areas(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Normals of triangles, of twice their area's length, (3, m)."""
    return _cross(b - a, c - a)


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Vector products, (3, m)."""
    return np.stack([a[i] * b[j] - a[j] * b[i] for i, j in ((1, 2), (2, 0), (0, 1))])


def _lengths(vectors: FloatArray) -> FloatArray:
    """Lengths of vectors, (m,)."""
    lengths: FloatArray = np.sqrt((vectors * vectors).sum(axis=0))
    return lengths
