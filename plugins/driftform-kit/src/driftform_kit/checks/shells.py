"""The closed surfaces of a part: copies, open edges and neighbours of opposite orientation, and which surface lies within which.

A solid's outside faces outward and its volume is positive; a hollow within faces into the hollow and its volume is
negative; a loose piece within a hollow is positive again. A mesh whose hollow is inside out is closed and manifold
all the same, so the nesting must be checked.
"""

from dataclasses import dataclass

import numpy as np
from manifold3d import Manifold

from driftform.types import FloatArray
from driftform_frusta.triangles import IntArray, Mesh

_PROBES = 32
"""Vertices of a surface that are tested for lying within another."""

_ASIDE = np.array([1.7, 1.3, 1.1])
"""Direction of a ray that leaves a box of size 1, in no plane of symmetry of a part."""


@dataclass(frozen=True, eq=False)
class Topology:
    """Properties of a mesh that do not depend on the coordinates of its vertices.

    ``triangles`` (m, 3) are those on other vertices than all before: the rest are ``copies``, whichever way they face. Open
    edges have one triangle, and are the rims of holes; crowded ones have three or more. Flipped triangles face opposite to
    most of their surface; ``surface`` is the number of the connected one of each triangle, (m,).
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
    # Neighbours that agree run along their common edge in opposite directions.
    agree = start[pairs[:, 0]] == end[pairs[:, 1]]
    surface = _label_connected(face[pairs], len(kept))
    patch = _label_connected(face[pairs[agree]], len(kept))

    rim = edges[count == 1]
    vertices, index = np.unique(rim, return_inverse=True)
    holes = _label_connected(index.reshape(-1, 2), len(vertices)) if len(rim) else rim
    return Topology(
        triangles=kept,
        copies=len(triangles) - len(kept),
        open_edges=len(rim),
        holes=len(np.unique(holes)),
        crowded_edges=int((count > 2).sum()),
        flipped=_count_minority(surface, patch),
        surface=surface,
    )


def _label_connected(pairs: IntArray, count: int) -> IntArray:
    """The number of the group of each of ``count`` things, of which pairs (k, 2) are connected."""
    from trimesh.graph import connected_component_labels

    labels = connected_component_labels(pairs, node_count=count)  # type: ignore[no-untyped-call]
    return np.asarray(labels, dtype=np.int64)


def _count_minority(surface: IntArray, patch: IntArray) -> int:
    """Return the number of triangles outside the largest patch of their surface; in a patch, neighbours agree."""
    if not len(patch):
        return 0
    size = np.bincount(patch)
    largest = np.zeros(int(surface.max()) + 1, dtype=np.int64)
    np.maximum.at(largest, surface, size[patch])
    return len(patch) - int(largest.sum())


@dataclass(frozen=True, eq=False)
class Shell:
    """One closed surface: its triangles, signed volume (mm3), and the number of shells that it lies within.

    ``cut`` is true if it lies partly within another: they intersect.
    """

    triangles: IntArray
    volume: float
    depth: int
    cut: bool

    @property
    def hollow(self) -> bool:
        """True for the wall of a hollow, False for an outside."""
        return self.depth % 2 == 1

    @property
    def inside_out(self) -> bool:
        """True if it faces the wrong way for its depth."""
        return (self.volume < 0) != self.hollow


def find_shells(part: Mesh, topology: Topology) -> tuple[Shell, ...]:
    """Return the shells of a closed, oriented part, the outermost first."""
    surfaces = [Mesh(part.vertices, topology.triangles[topology.surface == n]) for n in np.unique(topology.surface)]
    solids = [surface.to_manifold() for surface in surfaces]
    boxes = [np.reshape(solid.bounding_box(), (2, 3)) for solid in solids]
    shells = []
    for i, surface in enumerate(surfaces):
        inside = [
            _share_within(part.vertices[np.unique(surface.triangles)], solids[j])
            for j in range(len(surfaces))
            if j != i and (boxes[i][1] >= boxes[j][0]).all() and (boxes[i][0] <= boxes[j][1]).all()
        ]
        shells.append(
            Shell(
                triangles=surface.triangles,
                volume=surface.volume,
                depth=sum(share > 0.5 for share in inside),
                cut=any(0 < share < 1 for share in inside),
            )
        )
    return tuple(sorted(shells, key=lambda shell: (shell.depth, -abs(shell.volume))))


def _share_within(points: FloatArray, solid: Manifold) -> float:
    chosen = np.unique(points, axis=0)
    chosen = chosen[np.linspace(0, len(chosen) - 1, min(_PROBES, len(chosen))).astype(int)]
    # A ray that leaves a closed surface passes it an odd number of times, whichever way that faces.
    ends = chosen + np.ptp(solid.bounding_box()) * _ASIDE
    return float(np.mean([len(solid.ray_cast(*ray)) % 2 for ray in zip(chosen.tolist(), ends.tolist(), strict=True)]))
