"""OpenSCAD source, to edit."""

from pathlib import Path
from typing import ClassVar

from driftform.interfaces import Exporter, ExportJob, Table
from driftform.types import WrittenFile
from driftform_frusta.exporters.common import facts_of_all, save, write_sheet
from driftform_frusta.kit_options import PartOptions


class ScadExporter(Exporter[PartOptions]):
    """The hull as OpenSCAD source to edit: a table of modules, a wall, a core; or the parts of a kit."""

    name = "scad"
    suffix = ".scad"
    Options: ClassVar[type[Table]] = PartOptions

    def write(self, job: ExportJob, path: Path) -> tuple[WrittenFile, ...]:
        """Write the source, and a kit's assembly sheet.

        Facts of what it renders to: ``volume_mm3``, ``mass_kg``, ``size_mm``, ``shells``; or their sums and the
        ``parts``.

        Raises
        ------
        WorkFailedError
            if the body has no closed printable solid, or the file cannot be written.
        """
        from driftform_frusta.kits import list_kit_facts, make_parts
        from driftform_frusta.source import write_source

        parts = make_parts(job.agent.body, self.options)
        save(path, write_source(job, parts, self.options.segments, self.options.ballast))
        facts = facts_of_all(parts, job.agent.body) | list_kit_facts(job, self.options)
        return (WrittenFile(self.name, str(path), facts), *write_sheet(self.name, job, self.options, path))
