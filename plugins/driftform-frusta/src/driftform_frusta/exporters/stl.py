"""STL: the format of every slicer, for one solid."""

from driftform_frusta.exporters.base import PartFiles
from driftform_frusta.triangles import Mesh


class StlExporter(PartFiles):
    """The hull as a binary STL mesh, for slicers, in mm; several parts are several files, each upright."""

    name = "stl"
    suffix = ".stl"

    def encode(self, mesh: Mesh) -> bytes:
        """Return loose triangles with their normals."""
        return mesh.to_stl()
