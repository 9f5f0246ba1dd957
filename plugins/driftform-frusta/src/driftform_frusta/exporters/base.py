"""Shared by the exporters of parts: a format adds only its files."""

from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar, TypeAlias

import numpy as np

from driftform.errors import WorkFailedError
from driftform.figures import files as picture_files
from driftform.interfaces import Exporter, ExportJob, Table
from driftform.types import Body, FloatArray, WrittenFile
from driftform.util import files
from driftform_frusta.hull import MM3_PER_M3
from driftform_frusta.kit_options import PartOptions
from driftform_frusta.parts import Part, find_maker, make_parts, settle_ballast
from driftform_frusta.solid import make_mesh
from driftform_frusta.triangles import Mesh

File: TypeAlias = tuple[Path, bytes | str, dict[str, Any]]
"""A file to be written: its path, its content, and facts about it."""


class PartExporter(Exporter[PartOptions]):
    """A format that holds the sealed hull, or the parts of a kit."""

    Options: ClassVar[type[Table]] = PartOptions

    @abstractmethod
    def make_files(self, job: ExportJob, parts: Sequence[Part], path: Path) -> Iterator[File]:
        """Yield the files of the parts; ``path`` is that of the first."""

    def write(self, job: ExportJob, path: Path) -> tuple[WrittenFile, ...]:
        """Write the files of the format, and each page of a kit's assembly sheet: as SVG, and as PDF with the extra ``pdf``.

        Facts of a solid: ``volume_mm3``, ``mass_kg``, ``size_mm`` and ``shells``; of several in one file, the sums and the
        ``parts``. Of a mesh also its ``triangles``, and ``watertight``: it is checked after rounding to the single precision
        that files have.

        Raises WorkFailedError if the body has no closed printable solid, or a file cannot be written.
        """
        settled = self.options if self.options.coupon else settle_ballast(job.agent.body, self.options)
        if settled != self.options:
            return type(self)(settled).write(job, path)
        # All are made before the first is written: a kit that cannot be printed leaves no files.
        made = list(self.make_files(job, make_parts(job.agent.body, self.options), path))
        for target, content, _ in made:
            save(target, content)
        kit = self.options.kit and not self.options.coupon
        facts = find_maker().list_facts(job, self.options) if kit or self.options.coupon else {}
        written = [WrittenFile(self.name, str(target), own | facts) for target, _, own in made]
        if kit:
            for number, drawn in enumerate(find_maker().draw_sheet(job, self.options, self.name), 1):
                sheet = path.with_name(f"{path.stem}-assembly-{number}.svg")
                for target, page in ((sheet, drawn), (sheet.with_suffix(".pdf"), picture_files.make_pdf(drawn))):
                    if page is not None:
                        save(target, page)
                        written.append(WrittenFile(self.name, str(target)))
        return tuple(written)


class PartFiles(PartExporter):
    """A format that holds one solid: several parts are several files, each oriented as it is printed."""

    @abstractmethod
    def encode(self, mesh: Mesh) -> bytes:
        """Return a mesh in mm as a file."""

    def make_files(self, job: ExportJob, parts: Sequence[Part], path: Path) -> Iterator[File]:
        """Yield a file of each part: ``agent-fore-shell.stl`` for ``agent.stl``."""
        for part in parts:
            mesh = make_mesh(part.on_bed(), part.name)
            facts = list_facts([part], job.agent.body)
            target = path.with_name(f"{path.stem}-{part.name.replace(' ', '-')}{path.suffix}")
            yield (
                target if len(parts) > 1 else path,
                self.encode(mesh),
                facts | {"triangles": len(mesh.triangles), "watertight": True},
            )


class JoinedFile(PartExporter):
    """A format that holds all parts at their places in the hull; ``frame`` is the matrix from mm to its own frame."""

    frame: ClassVar[FloatArray | None] = None

    @abstractmethod
    def encode(self, title: str, meshes: Mapping[str, Mesh]) -> bytes | str:
        """Return meshes by the names of their parts as a file."""

    def make_files(self, job: ExportJob, parts: Sequence[Part], path: Path) -> Iterator[File]:
        """Yield the file."""
        meshes = {part.name: make_mesh(part.solid, part.name, self.frame) for part in parts}
        triangles = sum(len(mesh.triangles) for mesh in meshes.values())
        facts = {"triangles": triangles, "watertight": True} | list_facts(parts, job.agent.body)
        yield path, self.encode(job.name, meshes), facts


def save(path: Path, content: bytes | str) -> None:
    """Write a whole file; text in UTF-8. Raises WorkFailedError if it cannot be written."""
    raw = content.encode() if isinstance(content, str) else content
    try:
        files.write_whole(path, lambda part: part.write_bytes(raw))
    except OSError as error:
        raise WorkFailedError(f"cannot write {path}: {error.strerror or error}") from error


def list_facts(parts: Sequence[Part], body: Body) -> dict[str, Any]:
    """Return the facts of parts in one file: of the only one, or the sums and the ``parts`` by name."""
    volume = sum(part.solid.volume for part in parts)
    facts = {"volume_mm3": volume, "mass_kg": volume / MM3_PER_M3 * body.hull_density}
    shells = {"shells": sum(len(part.solid.shells) for part in parts)}
    if len(parts) == 1:
        return {**facts, "size_mm": np.ptp(parts[0].solid.bounds, axis=0).tolist(), **shells}
    return {"parts": [part.name for part in parts], **facts, **shells}
