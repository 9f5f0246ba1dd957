"""OpenSCAD source, to edit: of the sealed hull, or of the parts of a kit side by side as they are printed."""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

from driftform.figures import style
from driftform.interfaces import ExportJob
from driftform_frusta.colours import colour_of
from driftform_frusta.csg import MM
from driftform_frusta.exporters.base import File, PartExporter, list_facts
from driftform_frusta.kit_options import PartOptions
from driftform_frusta.parametric import hull_source
from driftform_frusta.parts import Part, find_maker
from driftform_frusta.plate import GAP
from driftform_frusta.scad import fill_source, write_module, write_points


class ScadExporter(PartExporter):
    """The hull as OpenSCAD source to edit: a table of modules, a wall, a core; or the parts of a kit."""

    name = "scad"
    suffix = ".scad"

    def make_files(self, job: ExportJob, parts: Sequence[Part], path: Path) -> Iterator[File]:
        """Yield the source; its facts are those of what it renders to."""
        source = write_source(job, parts, self.options)
        yield path, source, list_facts(parts, job.agent.body)


def write_source(job: ExportJob, parts: Sequence[Part], options: PartOptions) -> str:
    """Return source that renders to the sealed hull, or to the parts of a kit side by side as they are printed."""
    body = job.agent.body
    whole, kit = [part.name for part in parts] == ["hull"], options.kit and not options.coupon
    if whole and not body.fittings.details and (edited := hull_source(job.agent, options.segments, job.name)):
        return edited
    modules = {part.name: part.name.replace(" ", "_") for part in parts}
    parameters = source = ""
    if kit:
        ends = parts[0].solid.bounds[0, 2], parts[-1].solid.bounds[1, 2]
        parameters, source = find_maker().write_kit(body, options, *map(float, ends))
        source += "\n".join(f"module {module}() made({index});" for index, module in enumerate(modules.values())) + "\n"
    else:
        source = "\n".join(write_module(modules[part.name], part.tree) for part in parts)
    rows = []
    x = 0.0
    for index, part in enumerate(parts):
        low, high = part.solid.bounds
        radius = max(abs(low[0]), abs(high[0]))
        x += radius
        lies = [f"{low[2]:.6f}", f"{high[2] - low[2]:.6f}"]
        if kit:
            lies = [f"lower_end({index})", f"upper_end({index}) - lower_end({index})"]
        turned = str(part.fore_down).lower()
        rows.append(f'    ["{part.name}", {", ".join(lies)}, {turned}, {x:.3f}, "{colour_of(index)}"],')
        x += radius + GAP
    return fill_source(
        "kit",
        title=" ".join(job.name.split()),
        summary="its section, revolved" if whole else f"a kit of {len(parts)} parts",
        names=", ".join(modules),
        parameters=parameters,
        definitions=fill_source("definitions", segments=options.segments),
        modules=source,
        choices="\n".join(f'    if (name == "{name}") {module}();' for name, module in modules.items()),
        table="\n".join(rows),
        core=f"{MM * body.core.radius:.6g}",
        core_outline=write_points([(MM * r, MM * z) for z, r in body.core.contour]).strip(),
        height=f"{-MM * float(body.outer[0, 0]):.6f}",
        core_colour=style.ORANGE,
        gap=f"{GAP:g}",
        reach=math.ceil(500 * body.max_diameter) + 1,
        wide=math.ceil(x) + 1,
        tall=math.ceil(MM * body.length) + 2,
    )
