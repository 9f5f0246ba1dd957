"""PLY: a mesh with its vertices shared, for programs that measure and repair, for one solid.

Format: G. Turk, "The PLY Polygon File Format" (1994); binary, little-endian.
"""

from pathlib import Path
from typing import ClassVar

import numpy as np

from driftform.interfaces import Exporter, Specimen
from driftform.options import Table
from driftform.types import WrittenFile
from driftform_frusta.exporters.common import facts_of_part, path_of_part, save
from driftform_frusta.kit.accounting import kit_facts
from driftform_frusta.mesh import Mesh, mesh_of
from driftform_frusta.parts import PartOptions, parts_of

_FACE = np.dtype([("count", "u1"), ("corners", "<i4", (3,))])


class PlyExporter(Exporter[PartOptions]):
    """The hull as a binary PLY mesh, in mm, standing as STL does; of several parts each has a file."""

    name = "ply"
    suffix = ".ply"
    Options: ClassVar[type[Table]] = PartOptions

    def write(self, specimen: Specimen, path: Path) -> tuple[WrittenFile, ...]:
        """Write the meshes; facts as those of ``stl``.

        Raises
        ------
        WorkFailedError
            where the body has no closed printable solid, or a file cannot be written.
        """
        body = specimen.agent.body
        parts = parts_of(body, self.options)
        meshes = [mesh_of(part.on_bed(), part.name) for part in parts]
        written = []
        for part, mesh in zip(parts, meshes, strict=True):
            target = path_of_part(path, part, parts)
            save(target, ply_bytes(mesh))
            facts = facts_of_part(part, body) | {"triangles": len(mesh.triangles), "watertight": True}
            facts |= kit_facts(specimen, self.options)
            written.append(WrittenFile(self.name, str(target), facts))
        return tuple(written)


def ply_bytes(mesh: Mesh) -> bytes:
    """Return a mesh in mm as a binary PLY file."""
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
    faces["count"] = 3
    faces["corners"] = mesh.triangles
    return header.encode("ascii") + mesh.vertices.astype("<f4").tobytes() + faces.tobytes()
