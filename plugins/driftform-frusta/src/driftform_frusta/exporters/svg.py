"""SVG: the agent as a dimensioned drawing."""

from pathlib import Path

from driftform.interfaces import Exporter, ExportJob, Table
from driftform.types import WrittenFile
from driftform_frusta.exporters.base import save


class SvgExporter(Exporter[Table]):
    """A dimensioned drawing of the agent to scale: half outside view, half section, and its water line."""

    name = "svg"
    suffix = ".svg"

    def write(self, job: ExportJob, path: Path) -> tuple[WrittenFile, ...]:
        """Write the drawing; it has no facts beside those it shows.

        Raises WorkFailedError if the file cannot be written.
        """
        from driftform.figures import section_svg

        save(path, section_svg(job.agent, job.name, job.scenario))
        return (WrittenFile(self.name, str(path)),)
