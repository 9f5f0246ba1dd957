"""ExportJob -> the OpenSCAD source that goes with its parts."""

from collections.abc import Sequence

from driftform.interfaces import ExportJob
from driftform_frusta.parametric import hull_source
from driftform_frusta.parts import Part
from driftform_frusta.plate import GAP
from driftform_frusta.scad import write_definitions, write_module

_KIT = """\
// {title}: a kit of {count} parts.
// Written by driftform. Lengths in millimetres; the axis is z, the fore end is up.

/* [View] */
part = "all";        // [all, {names}]
assembled = false;   // as they are joined, not as they are printed
section = false;     // cut open along the axis (slow to render)

/* [Mesh] */
{definitions}
{modules}
module make(name) {{
{choices}
}}

// Name, how high its lower end lies in the assembled hull, its height, whether its fore end is printed on the bed,
// and where on the bed it stands.
parts = [
{table}
];

module on_bed(p) {{
    translate([part == "all" ? p[4] : 0, 0, p[3] ? p[1] + p[2] : -p[1]])
        rotate([p[3] ? 180 : 0, 0, 0])
            children();
}}

module shown(p) {{
    if (assembled) make(p[0]);
    else on_bed(p) make(p[0]);
}}

module opened() {{
    if (section) difference() {{
        children();
        translate([-5000, 0, -5000]) cube(10000);
    }}
    else children();
}}

for (p = parts)
    if (part == "all" || part == p[0]) opened() shown(p);
"""


def write_source(job: ExportJob, parts: Sequence[Part], segments: int) -> str:
    """Return source that renders to the sealed hull, or to the parts of a kit side by side as they are printed."""
    if len(parts) == 1:
        return hull_source(job.agent, segments, job.name)
    modules = {part.name: part.name.replace(" ", "_") for part in parts}
    rows = []
    x = 0.0
    for part in parts:
        low, high = part.solid.bounds
        radius = max(abs(low[0]), abs(high[0]))
        x += radius
        turned = str(part.fore_down).lower()
        rows.append(f'    ["{part.name}", {low[2]:.6f}, {high[2] - low[2]:.6f}, {turned}, {x:.3f}],')
        x += radius + GAP
    return _KIT.format(
        title=" ".join(job.name.split()),
        count=len(parts),
        names=", ".join(modules),
        definitions=write_definitions([part.tree for part in parts], segments),
        modules="\n".join(write_module(modules[part.name], part.tree) for part in parts),
        choices="\n".join(f'    if (name == "{name}") {module}();' for name, module in modules.items()),
        table="\n".join(rows),
    )
