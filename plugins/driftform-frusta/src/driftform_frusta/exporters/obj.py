"""OBJ: the text format of modelling programs; parts are groups.

Format: Wavefront Technologies, "Object Files (.obj)", Advanced Visualizer manual, appendix B1.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import ClassVar

from driftform.interfaces import Exporter, Specimen
from driftform.options import Table
from driftform.types import WrittenFile
from driftform_frusta.exporters.common import facts_of_all, save
from driftform_frusta.kit.accounting import kit_facts
from driftform_frusta.mesh import Mesh, mesh_of
from driftform_frusta.parts import PartOptions, parts_of


class ObjExporter(Exporter[PartOptions]):
    """The hull as an OBJ mesh in mm, a group for each part, where it is in the assembled hull; without colours."""

    name = "obj"
    suffix = ".obj"
    Options: ClassVar[type[Table]] = PartOptions

    def write(self, specimen: Specimen, path: Path) -> tuple[WrittenFile, ...]:
        """Write the mesh; facts as those of ``stl``, or their sums and the ``parts``.

        Raises
        ------
        WorkFailedError
            where the body has no closed printable solid, or the file cannot be written.
        """
        body = specimen.agent.body
        parts = parts_of(body, self.options)
        meshes = {part.name: mesh_of(part.solid, part.name) for part in parts}
        save(path, obj_text(meshes))
        triangles = sum(len(mesh.triangles) for mesh in meshes.values())
        facts = facts_of_all(parts, body) | {"triangles": triangles, "watertight": True}
        facts |= kit_facts(specimen, self.options)
        return (WrittenFile(self.name, str(path), facts),)


def obj_text(meshes: Mapping[str, Mesh]) -> str:
    """Return meshes in mm, by the names of their groups, as the text of an OBJ file."""
    pieces = ["# driftform, lengths in mm\n"]
    first = 1
    for name, mesh in meshes.items():
        group = name.replace(" ", "_")
        pieces.append(f"o {group}\ng {group}\n")
        # Nine digits bring back the same number in single precision.
        pieces.append("v %.9g %.9g %.9g\n" * len(mesh.vertices) % tuple(mesh.vertices.ravel().tolist()))
        corners = (mesh.triangles + first).ravel()
        pieces.append("f %d %d %d\n" * len(mesh.triangles) % tuple(corners.tolist()))
        first += len(mesh.vertices)
    return "".join(pieces)
