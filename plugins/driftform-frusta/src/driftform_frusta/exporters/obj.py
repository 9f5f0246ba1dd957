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
        return obj_text(meshes)


def obj_text(meshes: Mapping[str, Mesh]) -> str:
    """Return meshes in mm, by the names of their groups, as the text of an OBJ file."""
    pieces = ["# driftform, lengths in mm\n"]
    first = 1
    for name, mesh in meshes.items():
        group = name.replace(" ", "_")
        pieces.append(f"o {group}\ng {group}\n")
        pieces.append(mesh.to_obj(first))
        first += len(mesh.vertices)
    return "".join(pieces)
