"""SVG: the agent as a dimensioned drawing."""

from pathlib import Path

from driftform.interfaces import Exporter, ExportJob, Table, option
from driftform.types import WrittenFile
from driftform_frusta.exporters.base import save


class SvgOptions(Table):
    """Options of the drawing."""

    width_mm: float | None = option(
        None, "width as a figure of a paper, without title and table of masses", "mm", ge=60, le=300
    )


class SvgExporter(Exporter[SvgOptions]):
    """A dimensioned drawing of the agent to scale: half outside view, and half section."""

    name = "svg"
    suffix = ".svg"
    Options = SvgOptions

    def write(self, job: ExportJob, path: Path) -> tuple[WrittenFile, ...]:
        """Write the drawing, for a paper as PDF too if the extra ``pdf`` is installed.

        Raises WorkFailedError if the file cannot be written.
        """
        from driftform.figures import files, section_svg, style

        page = style.Page.find(self.options.width_mm)
        drawn = section_svg(job.agent, job.name, job.scenario, page)
        save(path, drawn)
        paths = files.write_picture(path, drawn, page) if page.is_paper else (path,)
        return tuple(WrittenFile(self.name, str(each)) for each in paths)
