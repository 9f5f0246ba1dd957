"""Meridian -> closed meshes in metres: the outside of the hull, and the convex pieces that it is made of.

Simulators take a mesh that bodies collide with for its convex hull (MuJoCo, Drake), or add up its volume from
tetrahedra without their sign, which is right only where every point is seen from the mesh's origin (gz-common
before its version of August 2026). Convex pieces, each about its own centroid, are read the same way by all.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from driftform.agent import solid_of_revolution
from driftform.types import FloatArray
from driftform_frusta.triangles import Mesh, write_obj

SEGMENTS = 64
"""Corners of every circle."""

_NEGLIGIBLE = 1e-9
"""Part of the whole volume below which a piece is left out."""

_SAME, _FLAT = 1e-9, 1e-12
"""Distance of points that are the same, over the size; cross product of edges that are in line, over its square."""


@dataclass(frozen=True, eq=False)
class Piece:
    """A convex part of a hull: its mesh about its centroid, x of that in the body frame (m), and its volume (m3)."""

    mesh: Mesh
    x: float
    volume: float


def revolve_contour(contour: FloatArray, segments: int = SEGMENTS) -> Mesh:
    """Return the solid of a meridian (n, 2), which begins and ends on the axis, about the x axis."""
    mesh = Mesh.revolve(contour[:, ::-1], segments)
    bands, aft, fore = np.split(mesh.triangles, [-2 * segments, -segments])
    return Mesh(np.roll(mesh.vertices, 1, axis=1), np.concatenate((aft, bands[::2], bands[1::2], fore)))


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
            pieces.append(Piece(revolve_contour(part - (x, 0.0), segments), x, moments.volume))
    return pieces


def folds_back(contour: FloatArray) -> bool:
    """Return whether a meridian (n, 2) goes back along the axis anywhere."""
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
    return write_obj({"hull": mesh}, "m")
