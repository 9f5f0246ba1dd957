"""A solid as the closed surfaces that bound it: triangles in double precision, mm."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from manifold3d import Error, Manifold

from driftform.errors import WorkFailedError
from driftform.types import FloatArray
from driftform_frusta.triangles import Mesh


@dataclass(frozen=True, eq=False)
class Solid:
    """A solid of positive volume.

    Attributes:
        vertices: mm, (n, 3).
        triangles: indices of their corners, counterclockwise seen from outside, (m, 3).
        shells: volume inside each closed surface, mm3, (k,): negative for that of a hollow, which faces inward.

    Raises WorkFailedError if it is empty or inside out.
    """

    vertices: FloatArray
    triangles: npt.NDArray[np.int64]
    shells: FloatArray

    def __post_init__(self) -> None:
        if not self.volume > 0:
            raise WorkFailedError(f"the solid is empty or inside out: its volume is {self.volume:g} mm3")

    @classmethod
    def from_manifold(cls, solid: Manifold) -> "Solid":
        """Return the boundary of a solid of manifold3d."""
        mesh = solid.to_mesh64()
        return cls(
            np.asarray(mesh.vert_properties)[:, :3],
            np.asarray(mesh.tri_verts, dtype=np.int64),
            np.array([shell.volume() for shell in solid.decompose()]),
        )

    @property
    def volume(self) -> float:
        """Volume of the material, mm3."""
        return float(self.shells.sum())

    @property
    def pieces(self) -> int:
        """Number of disconnected solids: each has an outside, and any number of hollows."""
        return int((self.shells > 0).sum())

    @property
    def bounds(self) -> FloatArray:
        """Lowest and highest coordinates, (2, 3)."""
        return np.stack((self.vertices.min(axis=0), self.vertices.max(axis=0)))

    def translate(self, offset: npt.ArrayLike) -> "Solid":
        """Return the solid moved by ``offset``, mm."""
        return Solid(self.vertices + np.asarray(offset), self.triangles, self.shells)

    def turn_over(self) -> "Solid":
        """Return the solid turned by half a turn about the x axis."""
        return Solid(self.vertices * np.array([1.0, -1.0, -1.0]), self.triangles, self.shells)

    def to_manifold(self) -> Manifold:
        """Return the solid for manifold3d, which unites, cuts and measures solids.

        Raises WorkFailedError if its surfaces are not closed.
        """
        solid = Mesh(self.vertices, self.triangles).to_manifold()
        if solid.status() != Error.NoError:
            raise WorkFailedError(f"the solid is not manifold: {solid.status().name}")
        return solid
