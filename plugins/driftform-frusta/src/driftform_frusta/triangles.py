"""Triangle meshes: revolving a meridian, area and volume, shared vertices, the bytes of STL, and the text of OBJ."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

import numpy as np
import numpy.typing as npt

from driftform.types import FloatArray

if TYPE_CHECKING:
    from manifold3d import Manifold

IntArray = npt.NDArray[np.int64]
"""Indices of vertices."""

# A reader that finds "solid" at the beginning takes the file for the text form of STL. NULs end the header, because
# admesh prints it as a C string: without one it prints the bytes that follow in memory too.
_STL_HEADER = b"driftform binary STL, lengths in mm".ljust(80, b"\0")
_FACET = np.dtype([("normal", "<f4", (3,)), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


@dataclass(frozen=True, eq=False)
class Mesh:
    """A mesh of triangles, with the name of its solid in a file of several, such as ``fore shell``.

    Vertices are in any unit of length, (n, 3), in single or double precision; triangles are the indices of their corners,
    counterclockwise seen from outside, (m, 3).
    """

    vertices: npt.NDArray[Any]
    triangles: IntArray
    name: str = ""

    @classmethod
    def revolve(cls, line: FloatArray, segments: int, closed: bool = False) -> "Mesh":
        """Revolve a line about the z axis.

        A circle becomes a regular polygon. One of N corners on a circle of radius r has the area
        ``N/2 sin(2 pi/N) r^2``, less than the circle's. Every radius is therefore scaled so that each cross-section has
        its circle's area, and the mesh has the volume, the centroid and the mass of the closed forms. The corners then
        lie outside the circle, by 0.08 % of the radius with 64 of them.

        The line is r and z, (n, 2), with the material on its left. It begins and ends on the axis; or, if ``closed``, it never
        touches the axis, and the last point is joined to the first. Vertices: a ring of ``segments`` for each point off the axis,
        in the order of the line, from the x axis on; then the two poles. Triangles: of the bands between rings, two for each
        segment; then the caps around the first and the last pole.
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
            return cls(vertices, bands)
        first, last = np.full(segments, len(vertices)), np.full(segments, len(vertices) + 1)
        caps = (np.column_stack((first, following[0], index[0])), np.column_stack((last, index[-1], following[-1])))
        poles = np.array([[0.0, 0.0, line[0, 1]], [0.0, 0.0, line[-1, 1]]])
        return cls(np.concatenate((vertices, poles)), np.concatenate((bands, *caps)))

    def merge_vertices(self) -> "Mesh":
        """Return the mesh with vertices of equal coordinates merged, without the triangles that collapse by that.

        Files of loose triangles hold each vertex several times, and others do if normals or colours differ.
        """
        # Adding zero turns -0.0 into 0.0: both are one coordinate, and some readers compare the bytes.
        points, corners = self.vertices + self.vertices.dtype.type(0), self.triangles
        if len(np.unique(np.ascontiguousarray(points).view(f"V{3 * points.itemsize}"))) < len(points):
            points, index = np.unique(points, axis=0, return_inverse=True)
            corners = index.reshape(-1)[corners].astype(np.int64)
        a, b, c = corners.T
        return replace(self, vertices=points, triangles=corners[(a != b) & (b != c) & (c != a)])

    @property
    def is_closed(self) -> bool:
        """True if each edge belongs to exactly two triangles, once in each direction: closed, and oriented consistently."""
        start, end = self.triangles.ravel(), np.roll(self.triangles, -1, axis=1).ravel()
        there, back = (np.sort(a * len(self.vertices) + b) for a, b in ((start, end), (end, start)))
        once = (there[1:] != there[:-1]).all() and (start != end).all()
        return bool(len(there) and once and (there == back).all())

    @property
    def area_vectors(self) -> FloatArray:
        """Outward normals of the triangles, each as long as the area (the square of the unit), (m, 3)."""
        return _area_vectors(self._corners(self.vertices)).T

    @property
    def area(self) -> float:
        """Of the surface, in the square of the unit."""
        return float(_lengths(_area_vectors(self._corners(self.vertices))).sum())

    @cached_property
    def volume(self) -> float:
        """Volume inside a closed mesh, in the cube of the unit; negative if its triangles face inward.

        The sum of the signed tetrahedra between each triangle and the mean of the vertices, where they are small and so
        is the rounding error.
        """
        points = np.asarray(self.vertices, dtype=np.float64)
        a, b, c = self._corners(points - points.mean(axis=0))
        return float((a * _cross(b, c)).sum() / 6)

    @property
    def bounds(self) -> FloatArray:
        """Lowest and highest coordinates, (2, 3)."""
        return np.array([self.vertices.min(axis=0), self.vertices.max(axis=0)])

    def translate(self, offset: npt.ArrayLike) -> Self:
        """Return the mesh moved by ``offset``, (3,)."""
        return replace(self, vertices=self.vertices + np.asarray(offset))

    def to_manifold(self) -> "Manifold":
        """Return the solid for manifold3d, whose ``status`` says whether the mesh is closed."""
        from manifold3d import Manifold, Mesh64

        return Manifold(Mesh64(vert_properties=self.vertices, tri_verts=self.triangles.astype(np.uint64)))

    def to_stl(self) -> bytes:
        """Return the mesh, in mm, as a little-endian binary STL file; normals follow from the triangles.

        Format: 3D Systems, "StereoLithography Interface Specification" (1989), in single precision.
        """
        corners = self._corners(np.asarray(self.vertices, dtype=np.float32))
        normals = _area_vectors(corners)
        area = _lengths(normals)
        facets = np.zeros(corners.shape[-1], dtype=_FACET)
        facets["normal"] = np.divide(normals, area, out=np.zeros_like(normals), where=area > 0).T
        facets["corners"] = corners.transpose(2, 0, 1)
        return _STL_HEADER + len(facets).to_bytes(4, "little") + facets.tobytes()

    def _corners(self, vertices: npt.NDArray[Any]) -> FloatArray:
        """The triangles' corners in double precision, (3 corners, 3 coordinates, m): numpy is quick along long rows."""
        rows = np.ascontiguousarray(vertices.T, dtype=np.float64)
        index = np.ascontiguousarray(self.triangles.T)
        return np.stack([row[index] for row in rows], axis=1)


def write_obj(meshes: Mapping[str, Mesh], unit: str) -> str:
    """Return the text of an OBJ file of meshes by their names, with a normal for each vertex: Gazebo's physics refuses others."""
    import trimesh
    from trimesh.exchange.obj import export_obj

    scene: Any = trimesh.Scene()
    for name, mesh in meshes.items():
        made = trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False)
        scene.add_geometry(made, geom_name=name.replace(" ", "_"))
    look = {"include_color": False, "include_texture": False}
    export: Any = export_obj
    text: str = export(scene, include_normals=True, digits=9, header=f"driftform, lengths in {unit}", **look)
    return text.replace("\n\n", "\n").strip() + "\n"


def area_factor(segments: int) -> float:
    """Return the factor on a radius that gives a regular polygon of ``segments`` corners the area of its circle."""
    return 1 / math.sqrt(segments / (2 * math.pi) * math.sin(2 * math.pi / segments))


def _area_vectors(corners: FloatArray) -> FloatArray:
    """Normals of triangles, as long as their areas, (3, m)."""
    a, b, c = corners
    return _cross(b - a, c - a) / 2


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.stack([a[i] * b[j] - a[j] * b[i] for i, j in ((1, 2), (2, 0), (0, 1))])


def _lengths(vectors: FloatArray) -> FloatArray:
    lengths: FloatArray = np.sqrt((vectors * vectors).sum(axis=0))
    return lengths
