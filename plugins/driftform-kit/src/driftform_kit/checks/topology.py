"""Topology of a mesh: copies, open edges, neighbours of opposite orientation, connected surfaces."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from driftform.types import FloatArray

IntArray = npt.NDArray[np.int64]
"""Indices of vertices."""


@dataclass(frozen=True, eq=False)
class Topology:
    """Properties of a mesh that do not depend on the coordinates of its vertices.

    Attributes
    ----------
    triangles
        without those that are copies, (m, 3).
    copies
        triangles on the same three vertices as an earlier one, whichever way they face.
    open_edges
        edges of one triangle only: the rims of holes.
    holes
        connected rims.
    crowded_edges
        edges of three triangles or more.
    flipped
        triangles that face opposite to most of their surface.
    surface
        number of the connected surface of each triangle, (m,).
    """

    triangles: IntArray
    copies: int
    open_edges: int
    holes: int
    crowded_edges: int
    flipped: int
    surface: IntArray

    @property
    def closed(self) -> bool:
        """True if every edge has two triangles."""
        return len(self.triangles) > 0 and not self.open_edges and not self.crowded_edges

    @property
    def oriented(self) -> bool:
        """True if no two neighbours face opposite ways."""
        return not self.flipped


def analyse_topology(triangles: IntArray) -> Topology:
    """Return the topology of triangles (m, 3) that share vertices."""
    _, first = np.unique(np.sort(triangles, axis=1), axis=0, return_index=True)
    kept = triangles[np.sort(first)]
    start = kept.reshape(-1)
    end = np.roll(kept, -1, axis=1).reshape(-1)
    face = np.repeat(np.arange(len(kept)), 3)
    ends = np.sort(np.column_stack((start, end)), axis=1)
    edges, edge, count = np.unique(ends, axis=0, return_inverse=True, return_counts=True)
    edge = edge.reshape(-1)

    order = np.argsort(edge, kind="stable")
    place = np.concatenate(([0], np.cumsum(count)))[:-1]
    pairs = order[place[count == 2, None] + [0, 1]]
    a, b = face[pairs[:, 0]], face[pairs[:, 1]]
    # Neighbours that agree run along their common edge in opposite directions.
    agree = start[pairs[:, 0]] == end[pairs[:, 1]]
    surface = _label_connected(a, b, len(kept))
    patch = _label_connected(a[agree], b[agree], len(kept))

    rim = edges[count == 1]
    return Topology(
        triangles=kept,
        copies=len(triangles) - len(kept),
        open_edges=len(rim),
        holes=_count_groups(rim),
        crowded_edges=int((count > 2).sum()),
        flipped=_count_minority(surface, patch),
        surface=surface,
    )


def _label_connected(a: IntArray, b: IntArray, count: int) -> IntArray:
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(a), dtype=np.int8), (a, b)), shape=(count, count))
    _, labels = connected_components(graph, directed=False)
    return np.asarray(labels, dtype=np.int64)


def _count_groups(rim: IntArray) -> int:
    if not len(rim):
        return 0
    vertices, index = np.unique(rim, return_inverse=True)
    ends = index.reshape(-1, 2)
    return int(_label_connected(ends[:, 0], ends[:, 1], len(vertices)).max()) + 1


def _count_minority(surface: IntArray, patch: IntArray) -> int:
    """Return the number of triangles outside the largest patch of their surface; in a patch, neighbours agree."""
    if not len(patch):
        return 0
    size = np.bincount(patch)
    largest = np.zeros(int(surface.max()) + 1, dtype=np.int64)
    np.maximum.at(largest, surface, size[patch])
    return len(patch) - int(largest.sum())


def winding_numbers(points: FloatArray, corners: FloatArray) -> FloatArray:
    """Return how often a closed surface winds round each point: 0 outside, 1 inside, -1 inside if it is inside out.

    The sum of the solid angles of its triangles over 4 pi (van Oosterom and Strackee, "The solid angle of a plane
    triangle", IEEE Trans. Biomed. Eng. 30, 1983, eq. 8).

    Parameters
    ----------
    points
        (k, 3).
    corners
        of the triangles, (m, 3, 3).
    """
    found = np.empty(len(points))
    for index, point in enumerate(points):
        a, b, c = np.moveaxis(corners - point, 1, 0)
        la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
        triple = np.einsum("ij,ij->i", a, np.cross(b, c))
        rest = (
            la * lb * lc
            + np.einsum("ij,ij->i", a, b) * lc
            + np.einsum("ij,ij->i", b, c) * la
            + np.einsum("ij,ij->i", c, a) * lb
        )
        found[index] = np.arctan2(triple, rest).sum() / (2 * np.pi)
    return found
