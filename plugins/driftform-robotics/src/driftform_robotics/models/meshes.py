"""Meridian -> closed meshes in metres: the outside of the hull, and the convex pieces that it is made of.

Simulators take a mesh that bodies collide with for its convex hull (MuJoCo, Drake), or add up its volume from
tetrahedra without their sign, which is right only where every point is seen from the mesh's origin (gz-common
before its version of August 2026). Convex pieces, each about its own centroid, are read the same way by all.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from driftform.geometry import solid_of_revolution
from driftform.types import FloatArray

SEGMENTS = 64
"""Corners of every circle."""

_NEGLIGIBLE = 1e-9
"""Part of the whole volume below which a piece is left out."""

_SAME, _FLAT = 1e-9, 1e-12
"""Distance of points that are the same, over the size; cross product of edges that are in line, over its square."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """A closed mesh: ``vertices`` (n, 3) in m, ``triangles`` (m, 3), counterclockwise seen from outside."""

    vertices: FloatArray
    triangles: npt.NDArray[np.int64]

    def moved(self, offset: FloatArray) -> "Mesh":
        """The mesh, moved by ``offset`` (m)."""
        return Mesh(self.vertices + offset, self.triangles)


@dataclass(frozen=True, eq=False)
class Piece:
    """A convex part of a hull: its mesh about its centroid, x of that in the body frame (m), and its volume (m3)."""

    mesh: Mesh
    x: float
    volume: float


def area_factor(segments: int) -> float:
    """Return the factor on a radius that gives a regular polygon the area of its circle.

    With it, every cross-section of a revolved mesh has its circle's area, and the mesh the volume and the centroid of
    the closed forms.
    """
    return float(1 / np.sqrt(segments / (2 * np.pi) * np.sin(2 * np.pi / segments)))


def revolved(contour: FloatArray, segments: int = SEGMENTS) -> Mesh:
    """Return the solid of a meridian (n, 2), which begins and ends on the axis, about the x axis."""
    line = contour[1:-1]
    circle = _circle(segments) * area_factor(segments)
    rings = np.empty((len(line), segments, 3))
    rings[..., 0] = line[:, :1]
    rings[..., 1:] = line[:, 1, None, None] * circle
    poles = np.array([[contour[0, 0], 0.0, 0.0], [contour[-1, 0], 0.0, 0.0]])
    index = np.arange(rings[..., 0].size).reshape(rings.shape[:2])
    following = np.roll(index, -1, axis=1)
    aft, fore = np.full(segments, index.size), np.full(segments, index.size + 1)
    faces = [
        np.stack((aft, following[0], index[0]), axis=-1),
        *_bands(index, following),
        np.stack((fore, index[-1], following[-1]), axis=-1),
    ]
    return Mesh(np.concatenate((rings.reshape(-1, 3), poles)), np.concatenate(faces))


def tube(length: float, radius: float, wall: float, segments: int = SEGMENTS) -> Mesh:
    """Return a pipe about the x axis, its middle at the origin; ``radius`` is that of its bore, m."""
    corners = np.array([(-1, 0), (1, 0), (1, 1), (-1, 1), (-1, 0)]) * (length / 2, wall) + (0, radius)
    circle = _circle(segments) * area_factor(segments)
    rings = np.empty((4, segments, 3))
    rings[..., 0] = corners[:4, :1]
    rings[..., 1:] = corners[:4, 1, None, None] * circle
    index = np.arange(4 * segments).reshape(4, segments)[[0, 3, 2, 1, 0]]
    return Mesh(rings.reshape(-1, 3), np.concatenate(list(_bands(index, np.roll(index, -1, axis=1)))))


def _circle(segments: int) -> FloatArray:
    angle = np.arange(segments) * (2 * np.pi / segments)
    return np.column_stack((np.cos(angle), np.sin(angle)))


def _bands(index: npt.NDArray[np.int64], following: npt.NDArray[np.int64]) -> Iterator[npt.NDArray[np.int64]]:
    """Triangles between each ring and the next, seen from outside where the rings go towards +x."""
    yield np.stack((index[:-1], following[:-1], following[1:]), axis=-1).reshape(-1, 3)
    yield np.stack((index[:-1], following[1:], index[1:]), axis=-1).reshape(-1, 3)


def convex_pieces(contour: FloatArray, segments: int = SEGMENTS) -> list[Piece]:
    """Return a hull cut across its axis wherever its meridian is hollow.

    A contour that folds back along the axis cannot be cut that way, and stays one piece, which is not convex.
    """
    whole = solid_of_revolution(contour)
    pieces = []
    for part in _convex_parts(contour):
        moments = solid_of_revolution(part)
        if moments.volume > _NEGLIGIBLE * whole.volume:
            x = moments.centroid
            pieces.append(Piece(revolved(part - (x, 0.0), segments), x, moments.volume))
    return pieces


def folds_back(contour: FloatArray) -> bool:
    """Tell whether a meridian (n, 2) goes back along the axis anywhere."""
    return bool(np.diff(contour[:, 0]).min() < -_SAME * np.abs(contour).max())


def _convex_parts(contour: FloatArray) -> list[FloatArray]:
    """Cut a meridian (n, 2) where it turns away from the axis; each part begins and ends on the axis."""
    if folds_back(contour):
        return [contour]
    scale = float(np.abs(contour).max())
    # Of points at the same x only the first and the last bound the solid, and of two that are the same one.
    steps = np.abs(np.diff(contour[:, 0])) > _SAME * scale
    contour = contour[np.append(True, steps) | np.append(steps, True)]
    contour = contour[np.append(True, (np.abs(np.diff(contour, axis=0)) > _SAME * scale).any(axis=1))]
    edges = np.diff(contour, axis=0)
    turn = edges[:-1, 0] * edges[1:, 1] - edges[:-1, 1] * edges[1:, 0]
    cuts = [0, *(1 + np.flatnonzero(turn > _FLAT * scale**2)), len(contour) - 1]
    parts = []
    for first, last in pairwise(cuts):
        part = contour[first : last + 1]
        ends = [np.array([[x, 0.0]]) for x in (part[0, 0], part[-1, 0])]
        start = part if part[0, 1] == 0 else np.concatenate((ends[0], part))
        parts.append(start if part[-1, 1] == 0 else np.concatenate((start, ends[1])))
    return parts


def obj_text(mesh: Mesh) -> str:
    """Return a mesh as the text of an OBJ file: the one format that all these simulators read."""
    pieces = ["# driftform, lengths in m\n"]
    pieces.append("v %.9g %.9g %.9g\n" * len(mesh.vertices) % tuple((mesh.vertices + 0.0).ravel().tolist()))
    pieces.append("f %d %d %d\n" * len(mesh.triangles) % tuple((mesh.triangles + 1).ravel().tolist()))
    return "".join(pieces)
