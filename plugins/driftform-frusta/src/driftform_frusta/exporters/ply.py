"""PLY: a mesh with its vertices shared, for programs that measure and repair, for one solid.

Format: G. Turk, "The PLY Polygon File Format" (1994); binary, little-endian.
"""

import numpy as np

from driftform_frusta.exporters.base import PartFiles
from driftform_frusta.triangles import Mesh

_FACE = np.dtype([("count", "u1"), ("corners", "<i4", (3,))])


class PlyExporter(PartFiles):
    """The hull as a binary PLY mesh, in mm, oriented as in STL; several parts are several files."""

    name = "ply"
    suffix = ".ply"

    def encode(self, mesh: Mesh) -> bytes:
        """Return the mesh with its vertices shared."""
        header = (
            "ply\n"
            "format binary_little_endian 1.0\n"
            "comment driftform, lengths in mm\n"
            f"element vertex {len(mesh.vertices)}\n"
            "property float x\n"
            "property float y\n"
            "property float z\n"
            f"element face {len(mesh.triangles)}\n"
            "property list uchar int vertex_indices\n"
            "end_header\n"
        )
        faces = np.empty(len(mesh.triangles), dtype=_FACE)
        faces["count"], faces["corners"] = 3, mesh.triangles
        return header.encode("ascii") + mesh.vertices.astype("<f4").tobytes() + faces.tobytes()
