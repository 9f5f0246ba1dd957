"""OpenSCAD source, to edit: of the sealed hull, or of the parts of a kit side by side as they are printed."""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

from driftform.figures import style
from driftform.interfaces import ExportJob
from driftform_frusta.colours import colour_of
from driftform_frusta.csg import MM
from driftform_frusta.exporters.base import File, PartExporter, list_facts
from driftform_frusta.parametric import draw_core, hull_source
from driftform_frusta.parts import Part
from driftform_frusta.plate import GAP
from driftform_frusta.scad import fill_source, write_definitions, write_module


class ScadExporter(PartExporter):
    """The hull as OpenSCAD source to edit: a table of modules, a wall, a core; or the parts of a kit."""

    name = "scad"
    suffix = ".scad"

    def make_files(self, job: ExportJob, parts: Sequence[Part], path: Path) -> Iterator[File]:
        """Yield the source; its facts are those of what it renders to."""
        source = write_source(job, parts, self.options.segments)
        yield path, source, list_facts(parts, job.agent.body)


def write_source(job: ExportJob, parts: Sequence[Part], segments: int) -> str:
    """Return source that renders to the sealed hull, or to the parts of a kit side by side as they are printed."""
    body = job.agent.body
    whole = [part.name for part in parts] == ["hull"]
    if whole and not body.fittings.details and (edited := hull_source(job.agent, segments, job.name)):
        return edited
    modules = {part.name: part.name.replace(" ", "_") for part in parts}
    rows = []
    x = 0.0
    for index, part in enumerate(parts):
        low, high = part.solid.bounds
        radius = max(abs(low[0]), abs(high[0]))
        x += radius
        turned = str(part.fore_down).lower()
        rows.append(
            f'    ["{part.name}", {low[2]:.6f}, {high[2] - low[2]:.6f}, {turned}, {x:.3f}, "{colour_of(index)}"],'
        )
        x += radius + GAP
    source = "\n".join(write_module(modules[part.name], part.tree) for part in parts)
    return fill_source(
        "kit",
        title=" ".join(job.name.split()),
        summary="its section, revolved" if whole else f"a kit of {len(parts)} parts",
        names=", ".join(modules),
        definitions=write_definitions(source, segments),
        modules=source,
        choices="\n".join(f'    if (name == "{name}") {module}();' for name, module in modules.items()),
        table="\n".join(rows),
        core=f"{MM * body.core.radius:.6g}",
        shape=draw_core(body),
        height=f"{-MM * float(body.outer[0, 0]):.6f}",
        core_colour=style.ORANGE,
        gap=f"{GAP:g}",
        reach=math.ceil(500 * body.max_diameter) + 1,
        wide=math.ceil(x) + 1,
        tall=math.ceil(MM * body.length) + 2,
    )
