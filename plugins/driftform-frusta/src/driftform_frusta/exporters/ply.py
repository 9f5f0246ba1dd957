"""PLY: a mesh with its vertices shared, for programs that measure and repair, for one solid.

Format: G. Turk, "The PLY Polygon File Format" (1994); binary, little-endian.
"""

from driftform_frusta.exporters.base import PartFiles
from driftform_frusta.triangles import Mesh


class PlyExporter(PartFiles):
    """The hull as a binary PLY mesh, in mm, oriented as in STL; several parts are several files."""

    name = "ply"
    suffix = ".ply"

    def encode(self, mesh: Mesh) -> bytes:
        """Return the mesh with its vertices shared."""
        import trimesh
        from trimesh.exchange.ply import export_ply

        made = trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False)
        return bytes(export_ply(made, vertex_normal=False))
