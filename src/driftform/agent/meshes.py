"""Triangle meshes: revolving a meridian, area and volume, shared vertices, and the text and bytes of STL and OBJ.

A mesh is ``vertices`` (n, 3) in any unit of length and ``triangles`` (m, 3): indices of their corners, counterclockwise
seen from outside.

A circle becomes a regular polygon. One of N corners on a circle of radius r has the area ``N/2 sin(2 pi/N) r^2``, less
than the circle's. Every radius is therefore scaled by :func:`area_factor`, so that each cross-section has its circle's
area, and the mesh has the volume, the centroid and the mass of the closed forms. The corners then lie outside the
circle, by 0.08 % of the radius with 64 of them.
"""

import math
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from driftform.types import FloatArray

IntArray = npt.NDArray[np.int64]
"""Indices of vertices."""

_Float = TypeVar("_Float", np.float32, np.float64)

# A reader that finds "solid" at the beginning takes the file for the text form of STL. NULs end the header, because
# admesh prints it as a C string: without one it prints the bytes that follow in memory too.
_STL_HEADER = b"driftform binary STL, lengths in mm".ljust(80, b"\0")
_FACET = np.dtype([("normal", "<f4", (3,)), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])

# Odd numbers without a pattern; the digits that overflow are cut off.
_MIXER = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], dtype=np.uint64)


def area_factor(segments: int) -> float:
    """Return the factor on a radius that gives a regular polygon of ``segments`` corners the area of its circle."""
    return 1 / math.sqrt(segments / (2 * math.pi) * math.sin(2 * math.pi / segments))


def revolve(line: FloatArray, segments: int, closed: bool = False) -> tuple[FloatArray, IntArray]:
    """Revolve a line about the z axis.

    Parameters
    ----------
    line
        r and z, (n, 2), with the material on its left. It begins and ends on the axis; or, if ``closed``, it never
        touches the axis, and the last point is joined to the first.
    segments
        corners of every circle; the first is on the x axis.

    Returns
    -------
    vertices
        a ring of ``segments`` for each point off the axis, in the order of the line; then the two poles, (k, 3).
    triangles
        of the bands between rings, two for each segment; then the caps around the first and the last pole, (m, 3).
    """
    swept = line if closed else line[1:-1]
    angle = np.arange(segments) * (2 * np.pi / segments)
    circle = area_factor(segments) * np.column_stack((np.cos(angle), np.sin(angle)))
    rings = np.empty((len(swept), segments, 3))
    rings[:, :, :2] = swept[:, None, :1] * circle
    rings[:, :, 2] = swept[:, None, 1]
    vertices = rings.reshape(-1, 3)

    index = np.arange(len(vertices)).reshape(len(swept), segments)
    if closed:
        index = np.concatenate((index, index[:1]))
    following = np.roll(index, -1, axis=1)
    bands = np.stack(
        (index[:-1], following[:-1], following[1:], index[:-1], following[1:], index[1:]), axis=-1
    ).reshape(-1, 3)
    if closed:
        return vertices, bands
    first, last = np.full(segments, len(vertices)), np.full(segments, len(vertices) + 1)
    caps = (
        np.column_stack((first, following[0], index[0])),
        np.column_stack((last, index[-1], following[-1])),
    )
    poles = np.array([[0.0, 0.0, line[0, 1]], [0.0, 0.0, line[-1, 1]]])
    return np.concatenate((vertices, poles)), np.concatenate((bands, *caps))


def merge_vertices(
    vertices: npt.NDArray[_Float], triangles: npt.ArrayLike
) -> tuple[npt.NDArray[_Float], IntArray]:
    """Merge vertices of equal coordinates, and leave out the triangles that collapse to an edge or a point.

    Parameters
    ----------
    vertices
        (n, 3), in single or double precision, which is kept.
    triangles
        indices of their corners, (m, 3).
    """
    # Adding zero turns -0.0 into 0.0: both are one coordinate, and some readers compare the bytes.
    points = vertices + vertices.dtype.type(0)
    corners = np.asarray(triangles, dtype=np.int64)
    if not _all_differ(points):
        points, index = np.unique(points, axis=0, return_inverse=True)
        corners = index.reshape(-1)[corners].astype(np.int64)
    a, b, c = corners.T
    return points, corners[(a != b) & (b != c) & (c != a)]


def _all_differ(points: npt.NDArray[np.floating]) -> bool:
    """Return whether surely no two points are the same: comparing one number of each is fast."""
    bits = np.ascontiguousarray(points).view(f"u{points.itemsize}").astype(np.uint64)
    keys = np.sort(bits @ _MIXER)
    return bool((keys[1:] != keys[:-1]).all())


def is_closed(triangles: IntArray) -> bool:
    """Return whether a mesh is closed and consistently oriented.

    It is if each edge belongs to exactly two triangles, once in each direction.
    """
    if not len(triangles) or len(triangles) % 2:
        return False
    n = int(triangles.max()) + 1
    corners = np.ascontiguousarray(triangles.T)
    start, end = corners.reshape(-1), corners[[1, 2, 0]].reshape(-1)
    # Short numbers sort faster. The last bit is the direction, so that sorting brings both next to each other.
    both = 2 * (np.minimum(start, end) * n + np.maximum(start, end)) + (start > end)
    both = np.sort(both.astype(np.uint32 if 2 * n * n < 2**32 else np.int64))
    there, back = both[::2], both[1::2]
    return bool((there % 2 == 0).all() and (back == there + 1).all() and (there[1:] != there[:-1]).all())


def area_vectors(vertices: npt.ArrayLike, triangles: npt.ArrayLike) -> FloatArray:
    """Return the outward normals of triangles, each as long as the area (the square of the unit), (m, 3)."""
    return _area_vectors(_corners(vertices, triangles)).T


def surface_area(vertices: npt.ArrayLike, triangles: npt.ArrayLike) -> float:
    """Return the area of a mesh, in the square of its unit."""
    return float(_lengths(_area_vectors(_corners(vertices, triangles))).sum())


def signed_volume(vertices: npt.ArrayLike, triangles: npt.ArrayLike) -> float:
    """Return the volume inside a closed mesh, in the cube of its unit; negative if its triangles face inward.

    The sum of the signed tetrahedra between each triangle and the mean of the vertices, where they are small and so is
    the rounding error.
    """
    points = np.asarray(vertices, dtype=np.float64)
    a, b, c = _corners(points - points.mean(axis=0), triangles)
    return float((a * _cross(b, c)).sum() / 6)


def stl_bytes(vertices: npt.ArrayLike, triangles: npt.ArrayLike) -> bytes:
    """Return a mesh as a little-endian binary STL file; normals follow from the triangles.

    Format: 3D Systems, "StereoLithography Interface Specification" (1989).

    Parameters
    ----------
    vertices
        mm, (n, 3); written in single precision.
    triangles
        indices of their corners, counterclockwise seen from outside, (m, 3).

    Raises
    ------
    ValueError
        if a coordinate is not finite.
    """
    corners = _corners(np.asarray(vertices, dtype=np.float32), triangles)
    if not np.isfinite(corners).all():
        raise ValueError("an STL file cannot hold coordinates that are not finite")
    normals = _area_vectors(corners)
    area = _lengths(normals)
    facets = np.zeros(corners.shape[-1], dtype=_FACET)
    facets["normal"] = np.divide(normals, area, out=np.zeros_like(normals), where=area > 0).T
    facets["corners"] = corners.transpose(2, 0, 1)
    return _STL_HEADER + len(facets).to_bytes(4, "little") + facets.tobytes()


def obj_lines(vertices: npt.NDArray[np.floating], triangles: IntArray, first: int = 1) -> str:
    """Return the lines of an OBJ file for a mesh: ``v`` for each vertex, ``f`` for each triangle.

    Format: Wavefront Technologies, "Object Files (.obj)", Advanced Visualizer manual, appendix B1.

    Parameters
    ----------
    vertices
        (n, 3), written with nine digits, which bring back the same number in single precision.
    triangles
        indices of their corners, (m, 3).
    first
        number of the first vertex in the file: 1 plus the vertices of the meshes before this one.
    """
    points = "v %.9g %.9g %.9g\n" * len(vertices) % tuple((vertices + 0.0).ravel().tolist())
    return points + "f %d %d %d\n" * len(triangles) % tuple((triangles + first).ravel().tolist())


def _corners(vertices: npt.ArrayLike, triangles: npt.ArrayLike) -> FloatArray:
    """The triangles' corners in double precision, (3 corners, 3 coordinates, m): numpy is quick along long rows."""
    rows = np.ascontiguousarray(np.asarray(vertices, dtype=np.float64).T)
    index = np.ascontiguousarray(np.asarray(triangles, dtype=np.int64).T)
    return np.stack([row[index] for row in rows], axis=1)


def _area_vectors(corners: FloatArray) -> FloatArray:
    """Normals of triangles, as long as their areas, (3, m)."""
    a, b, c = corners
    return _cross(b - a, c - a) / 2


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Vector products, (3, m)."""
    return np.stack([a[i] * b[j] - a[j] * b[i] for i, j in ((1, 2), (2, 0), (0, 1))])


def _lengths(vectors: FloatArray) -> FloatArray:
    """Lengths of vectors, (m,)."""
    lengths: FloatArray = np.sqrt((vectors * vectors).sum(axis=0))
    return lengths
