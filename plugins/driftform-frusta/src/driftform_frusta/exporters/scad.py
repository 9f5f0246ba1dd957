"""OpenSCAD source, to edit."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from driftform.interfaces import ExportJob
from driftform_frusta.exporters.base import File, PartExporter, list_facts

if TYPE_CHECKING:
    from driftform_frusta.parts import Part


class ScadExporter(PartExporter):
    """The hull as OpenSCAD source to edit: a table of modules, a wall, a core; or the parts of a kit."""

    name = "scad"
    suffix = ".scad"

    def make_files(self, job: ExportJob, parts: "Sequence[Part]", path: Path) -> Iterator[File]:
        """Yield the source; its facts are those of what it renders to."""
        from driftform_frusta.source import write_source

        source = write_source(job, parts, self.options.segments, self.options.ballast)
        yield path, source, list_facts(parts, job.agent.body)
