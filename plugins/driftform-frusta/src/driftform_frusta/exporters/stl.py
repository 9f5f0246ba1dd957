"""STL: the format of every slicer, for one solid."""

from pathlib import Path
from typing import ClassVar

from driftform.errors import WorkFailedError
from driftform.interfaces import Exporter, Specimen
from driftform.options import Table
from driftform.types import WrittenFile
from driftform_frusta.exporters.common import facts_of_part, path_of_part
from driftform_frusta.kit.accounting import kit_facts
from driftform_frusta.mesh import mesh_of
from driftform_frusta.parts import PartOptions, parts_of
from driftform_frusta.stl import write_binary_stl


class StlExporter(Exporter[PartOptions]):
    """The hull as a binary STL mesh, for slicers, in mm; of several parts each has a file and stands upright."""

    name = "stl"
    suffix = ".stl"
    Options: ClassVar[type[Table]] = PartOptions

    def write(self, specimen: Specimen, path: Path) -> tuple[WrittenFile, ...]:
        """Write the meshes, checked after rounding to the single precision that STL has.

        Facts: those of every solid (``volume_mm3`` and ``mass_kg``, ``size_mm``, ``shells``), its ``triangles``,
        and ``watertight``.

        Raises
        ------
        WorkFailedError
            where the body has no closed printable solid, or a file cannot be written.
        """
        body = specimen.agent.body
        parts = parts_of(body, self.options)
        # All are made before the first is written: what cannot be printed leaves no files.
        meshes = [mesh_of(part.on_bed(), part.name) for part in parts]
        written = []
        for part, mesh in zip(parts, meshes, strict=True):
            target = path_of_part(path, part, parts)
            try:
                write_binary_stl(target, mesh.vertices, mesh.triangles)
            except OSError as error:
                raise WorkFailedError(f"cannot write {target}: {error.strerror or error}") from error
            facts = facts_of_part(part, body) | {"triangles": len(mesh.triangles), "watertight": True}
            facts |= kit_facts(specimen, self.options)
            written.append(WrittenFile(self.name, str(target), facts))
        return tuple(written)
