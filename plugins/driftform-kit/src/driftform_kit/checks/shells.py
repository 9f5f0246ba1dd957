"""The closed surfaces of a part: which lies within which, and whether each faces the right way.

A solid's outside faces outward and its volume is positive; a hollow within faces into the hollow and its volume is
negative; a loose piece within a hollow is positive again. A mesh whose hollow is inside out is closed and manifold
all the same, so the nesting must be checked.
"""

from dataclasses import dataclass

import numpy as np

from driftform.types import FloatArray
from driftform_frusta.triangles import Mesh
from driftform_kit.checks.topology import IntArray, Topology, winding_numbers

_PROBES = 32
"""Vertices of a surface that are tested for lying within another."""


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
    groups = [topology.triangles[topology.surface == n] for n in np.unique(topology.surface)]
    corners = [part.vertices[group] for group in groups]
    boxes = [(c.reshape(-1, 3).min(axis=0), c.reshape(-1, 3).max(axis=0)) for c in corners]
    shells = []
    for i, group in enumerate(groups):
        inside = [
            _share_within(corners[i].reshape(-1, 3), corners[j])
            for j in range(len(groups))
            if j != i and (boxes[i][1] >= boxes[j][0]).all() and (boxes[i][0] <= boxes[j][1]).all()
        ]
        shells.append(
            Shell(
                triangles=group,
                volume=Mesh(part.vertices, group).volume,
                depth=sum(share > 0.5 for share in inside),
                cut=any(0 < share < 1 for share in inside),
            )
        )
    return tuple(sorted(shells, key=lambda shell: (shell.depth, -abs(shell.volume))))


def _share_within(points: FloatArray, corners: FloatArray) -> float:
    chosen = np.unique(points, axis=0)
    chosen = chosen[np.linspace(0, len(chosen) - 1, min(_PROBES, len(chosen))).astype(int)]
    return float((np.abs(winding_numbers(chosen, corners)) > 0.5).mean())


def orient_outward(shells: tuple[Shell, ...]) -> IntArray:
    """Return the triangles of all shells, each turned to face as its depth demands, (m, 3)."""
    return np.concatenate([s.triangles[:, ::-1] if s.inside_out else s.triangles for s in shells])
