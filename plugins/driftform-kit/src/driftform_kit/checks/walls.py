"""Wall thickness of a part: rays from its surface through its material to the other side."""

import numpy as np
from manifold3d import Error

from driftform_frusta.triangles import Mesh

REACH = 5.0
"""mm: thicker walls are not searched for."""

_OPPOSITE = np.cos(np.radians(30))
"""Surfaces at less than this to one another, back to back, are two sides of a wall; others meet in an edge."""

# A wall between straight sides is thinnest at a corner of a triangle: so next to each of them, and in the middle.
_NEAR = 0.02
_STATIONS = np.array(
    [[1 / 3, 1 / 3, 1 / 3]] + (np.eye(3) * (1 - 3 * _NEAR) + _NEAR).tolist()  # noqa: RUF005
)


def find_thinnest_wall(mesh: Mesh) -> tuple[float, list[float]] | None:
    """Return the thickness of the thinnest wall of a solid, and a point of its surface there, mm; ``None`` if it is thicker than :data:`REACH` or has no inside.

    From four points of each triangle a ray goes into the material, normal to the surface, until it comes out. Only
    where it comes out through a surface that faces the other way within 30 degrees is there a wall between the two:
    edges are sharp, but they are not thin.

    The mesh is in mm and closed; it faces outward, and into its hollows.
    """
    vertices, normals = mesh.vertices, mesh.area_vectors
    solid = mesh.to_manifold()
    if solid.status() != Error.NoError:
        return None
    corners = vertices[mesh.triangles]
    size = np.linalg.norm(normals, axis=1)
    sound = size > 1e-9 * size.max()
    corners, normals = corners[sound], normals[sound] / size[sound, None]
    # Off the surface by more than rounding, and by less than any wall: a ray must not meet where it starts.
    gap = 1e-9 * float(np.abs(vertices).max()) + 1e-9
    starts = np.einsum("sk,mkc->smc", _STATIONS, corners) - gap * normals
    rays = np.stack(np.broadcast_arrays(starts, starts - REACH * normals, normals), axis=2)
    walls = [
        (hits[0].distance * REACH + gap, start)
        for start, end, normal in np.swapaxes(rays, 0, 1).reshape(-1, 3, 3).tolist()
        if (hits := solid.ray_cast(start, end)) and np.dot(hits[0].normal, normal) <= -_OPPOSITE
    ]
    return min(walls, default=None)
