"""OBJ: the text format of modelling programs; parts are groups.

Format: Wavefront Technologies, "Object Files (.obj)", Advanced Visualizer manual, appendix B1.
"""

from collections.abc import Mapping

from driftform_frusta.exporters.base import JoinedFile
from driftform_frusta.triangles import Mesh


class ObjExporter(JoinedFile):
    """The hull as an OBJ mesh in mm, a group for each part at its place in the assembled hull; without colours."""

    name = "obj"
    suffix = ".obj"

    def encode(self, title: str, meshes: Mapping[str, Mesh]) -> str:
        """Return the groups; OBJ has no place for a title."""
        pieces = ["# driftform, lengths in mm\n"]
        first = 1
        for name, mesh in meshes.items():
            group = name.replace(" ", "_")
            pieces += [f"o {group}\ng {group}\n", mesh.to_obj(first)]
            first += len(mesh.vertices)
        return "".join(pieces)
