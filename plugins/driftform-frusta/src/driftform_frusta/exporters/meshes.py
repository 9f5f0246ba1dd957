"""Shared by exporters of meshes: a format adds only the encoding of a mesh."""

from abc import abstractmethod
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar

from driftform.agent import Mesh
from driftform.interfaces import Exporter, ExportJob, Table
from driftform.types import FloatArray, WrittenFile
from driftform_frusta.exporters.common import facts_of_all, facts_of_part, path_of_part, save, write_sheet
from driftform_frusta.kit_options import PartOptions
from driftform_frusta.mesh import make_mesh


class PartFiles(Exporter[PartOptions]):
    """A format that holds one solid: several parts are several files, each oriented as it is printed."""

    Options: ClassVar[type[Table]] = PartOptions

    @abstractmethod
    def encode(self, mesh: Mesh) -> bytes:
        """Return a mesh in mm as a file."""

    def write(self, job: ExportJob, path: Path) -> tuple[WrittenFile, ...]:
        """Write the meshes, checked after rounding to the single precision that files have, and a kit's assembly sheet.

        Facts: those of every solid (``volume_mm3`` and ``mass_kg``, ``size_mm``, ``shells``), its ``triangles``,
        and ``watertight``.

        Raises
        ------
        WorkFailedError
            if the body has no closed printable solid, or a file cannot be written.
        """
        from driftform_frusta.kits import list_kit_facts, make_parts

        body = job.agent.body
        parts = make_parts(body, self.options)
        # All are made before the first is written: a kit that cannot be printed leaves no files.
        meshes = [make_mesh(part.on_bed(), part.name) for part in parts]
        written = []
        for part, mesh in zip(parts, meshes, strict=True):
            target = path_of_part(path, part, parts)
            save(target, self.encode(mesh))
            facts = facts_of_part(part, body) | {"triangles": len(mesh.triangles), "watertight": True}
            facts |= list_kit_facts(job, self.options)
            written.append(WrittenFile(self.name, str(target), facts))
        return (*written, *write_sheet(self.name, job, self.options, path))


class JoinedFile(Exporter[PartOptions]):
    """A format that holds all parts at their places in the hull; ``frame`` is the matrix from mm to its own frame."""

    Options: ClassVar[type[Table]] = PartOptions
    frame: ClassVar[FloatArray | None] = None

    @abstractmethod
    def encode(self, title: str, meshes: Mapping[str, Mesh]) -> bytes | str:
        """Return meshes by the names of their parts as a file."""

    def write(self, job: ExportJob, path: Path) -> tuple[WrittenFile, ...]:
        """Write the file, and a kit's assembly sheet; facts as those of ``stl``, or their sums and the ``parts``.

        Raises
        ------
        WorkFailedError
            if the body has no closed printable solid, or the file cannot be written.
        """
        from driftform_frusta.kits import list_kit_facts, make_parts

        body = job.agent.body
        parts = make_parts(body, self.options)
        meshes = {part.name: make_mesh(part.solid, part.name, self.frame) for part in parts}
        save(path, self.encode(job.name, meshes))
        triangles = sum(len(mesh.triangles) for mesh in meshes.values())
        facts: dict[str, Any] = {"triangles": triangles, "watertight": True}
        facts |= facts_of_all(parts, body) | list_kit_facts(job, self.options)
        return (
            WrittenFile(self.name, str(path), facts),
            *write_sheet(self.name, job, self.options, path),
        )
