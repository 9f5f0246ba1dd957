"""ExportJob -> the OpenSCAD source that goes with its parts."""

import math
from collections.abc import Iterator, Sequence

from driftform.figures import style
from driftform.interfaces import ExportJob
from driftform.types import Body
from driftform_frusta.colours import colour_of
from driftform_frusta.csg import MM
from driftform_frusta.parametric import hull_source
from driftform_frusta.parts import Part
from driftform_frusta.plate import GAP
from driftform_frusta.scad import write_definitions, write_module

_KIT = """\
// {title}: a kit of {count} parts.
// Written by driftform. Lengths in millimetres; the axis is z, the fore end is up.
// Colours, the cut, core and ballast are shown by the preview (F5); a rendering (F6, --render) is of one colour, and whole.

/* [View] */
part = "all";        // [all, {names}]
assembled = false;   // as they are joined, not as they are printed
section = true;      // cut open on the side of the default view, in the preview only
show_core = true;    // and the ballast, in the preview only

/* [Mesh] */
{definitions}
{modules}
module make(name) {{
{choices}
}}

// Name, how high its lower end lies in the assembled hull, its height, whether its fore end is printed on the bed,
// where on the bed it stands, and its colour.
parts = [
{table}
];

core_radius = {core};
core_height = {height};  // of its centre in the assembled hull

module on_bed(p) {{
    translate([part == "all" ? p[4] : 0, 0, p[3] ? p[1] + p[2] : -p[1]])
        rotate([p[3] ? 180 : 0, 0, 0])
            children();
}}

module shown(p) {{
    if (assembled) make(p[0]);
    else on_bed(p) make(p[0]);
}}

// The default view is from the side of negative y. The preview shows a cut correctly only from outside what is cut away,
// so that is no larger than it must be.
module opened(colour) {{
    if (section && $preview) difference() {{
        children();
        color(colour) translate([-{reach:g}, -{reach:g}, -1]) cube([{reach:g} + {wide:g}, {reach:g}, {tall:g}]);
    }}
    else children();
}}

for (p = parts)
    if (part == "all" || part == p[0]) opened(p[5]) color(p[5]) shown(p);

if (show_core && $preview && part == "all")
    color("{core_colour}")
        translate(assembled ? [0, 0, core_height] : [-core_radius - {gap:g}, 0, core_radius])
            sphere(core_radius);

// Of each ball of ballast its height in the assembled hull, its radius, and where on the bed it lies.
ballast = [{balls}];

if (show_core && $preview && part == "all")
    for (ball = ballast)
        color("{ballast_colour}") translate(assembled ? [0, 0, ball[0]] : [ball[2], 0, ball[1]]) sphere(ball[1]);
"""


def write_source(
    job: ExportJob, parts: Sequence[Part], segments: int, ballast: Sequence[tuple[float, float]] = ()
) -> str:
    """Return source that renders to the sealed hull, or to the parts of a kit side by side as they are printed.

    ``ballast`` has x and diameter of each ball of ballast of the kit, m.
    """
    if len(parts) == 1:
        return hull_source(job.agent, segments, job.name)
    body = job.agent.body
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
    return _KIT.format(
        title=" ".join(job.name.split()),
        count=len(parts),
        names=", ".join(modules),
        definitions=write_definitions([part.tree for part in parts], segments),
        modules="\n".join(write_module(modules[part.name], part.tree) for part in parts),
        choices="\n".join(f'    if (name == "{name}") {module}();' for name, module in modules.items()),
        table="\n".join(rows),
        core=f"{MM * body.core.radius:.6g}",
        height=f"{-MM * float(body.outer[0, 0]):.6f}",
        core_colour=style.ORANGE,
        balls=", ".join(_list_balls(body, ballast)),
        ballast_colour=style.INK,
        gap=GAP,
        reach=math.ceil(500 * body.max_diameter) + 1,
        wide=math.ceil(x) + 1,
        tall=math.ceil(MM * body.length) + 2,
    )


def _list_balls(body: Body, ballast: Sequence[tuple[float, float]]) -> Iterator[str]:
    """Height, radius and place on the bed of each ball of ballast, mm: beside the core, which lies left of the parts."""
    place = -2 * MM * body.core.radius - GAP
    for x, diameter in ballast:
        radius = MM * diameter / 2
        place -= GAP + radius
        yield f"[{MM * (x - float(body.outer[0, 0])):.6f}, {radius:.6g}, {place:.3f}]"
        place -= radius
