"""CSG tree -> readable OpenSCAD source.

The source renders to the same volume as :func:`driftform_frusta.solid.to_manifold` gives: it scales radii by
the same factors, which are written as formulas of ``$fn``, so that a reader may change that number.
"""

import re
from collections.abc import Iterable, Sequence
from importlib.resources import files
from typing import assert_never

from driftform_frusta import csg
from driftform_frusta.csg import Node
from driftform_frusta.solid import half_section

_INDENT = "    "
_POINTS_PER_LINE = 3

_CONVEXITY = 10
"""How many walls of a body of revolution a ray passes at most, as OpenSCAD's preview needs to know."""


def fill_source(name: str, **values: object) -> str:
    """Return OpenSCAD source from the package's files, with a value in place of each name in angle brackets."""
    text = files("driftform_frusta").joinpath("openscad", f"{name}.scad.in").read_text(encoding="utf-8")
    return re.sub(r"<(\w+)>", lambda found: str(values[found[1]]), text)


def write_module(name: str, node: Node) -> str:
    """Return a module of OpenSCAD that makes the solid of a tree."""
    return "\n".join(_block(f"module {name}()", [_lines(node)])) + "\n"


def _lines(node: Node) -> list[str]:
    match node:
        case csg.Revolve():
            lines = _revolve(node)
        case csg.Extrude():
            lines = _put_above(f"linear_extrude({format_number(node.height)})", _section(node))
        case csg.Union():
            lines = _block("union()", [_lines(c) for c in node.children])
        case csg.Difference():
            lines = _block("difference()", [_lines(c) for c in (node.base, *node.tools)])
        case csg.Intersection():
            lines = _block("intersection()", [_lines(c) for c in node.children])
        case csg.Translate():
            lines = _put_above(f"translate({_vector(node.offset)})", _lines(node.child))
        case csg.Rotate():
            lines = _put_above(f"rotate({_vector(node.angles_deg)})", _lines(node.child))
        case _:
            assert_never(node)
    return lines


def _section(node: csg.Revolve | csg.Extrude) -> list[str]:
    lines = (write_points(points).splitlines() for points in (node.outline, *node.holes))
    outline, *holes = (["polygon([", *points, "]);"] for points in lines)
    return _block("difference()", [outline, *holes]) if holes else outline


def _revolve(node: csg.Revolve) -> list[str]:
    section = _section(node)
    if min(r for r, _ in node.outline) < 0:
        # OpenSCAD refuses to revolve a section that lies on both sides of the axis.
        r_max = max(r for r, _ in node.outline)
        z_min, z_max = min(z for _, z in node.outline), max(z for _, z in node.outline)
        half_plane = _put_above(
            f"translate([0, {format_number(z_min - 1)}])",
            [f"square([{format_number(r_max + 1)}, {format_number(z_max - z_min + 2)}]);"],
        )
        section = _block("intersection()", [section, half_plane])
    # Without convexity the preview draws what a concave section hides in front of it.
    if node.angle_deg == 360:
        return _put_above(f"rotate_extrude(convexity = {_CONVEXITY})", _put_above("scale([area_factor, 1])", section))
    angle = format_number(node.angle_deg)
    if node.rise:
        points = write_points(half_section(node)[0].tolist()).splitlines()
        return ["screw([", *points, f"], {angle}, {format_number(node.rise)});"]
    head = f"rotate_extrude(angle = {angle}, convexity = {_CONVEXITY}, $fn = sector_steps({angle}))"
    return _put_above(head, _put_above(f"scale([sector_factor({angle}), 1])", section))


def write_points(points: Iterable[Sequence[float]]) -> str:
    """Return points as lines of a list, some on each."""
    texts = list(map(_vector, points))
    rows = (texts[i : i + _POINTS_PER_LINE] for i in range(0, len(texts), _POINTS_PER_LINE))
    return "\n".join(f"{_INDENT}{', '.join(row)}," for row in rows)


def _block(head: str, children: Sequence[Sequence[str]]) -> list[str]:
    return [f"{head} {{", *(_INDENT + line for child in children for line in child), "}"]


def _put_above(head: str, child: Sequence[str]) -> list[str]:
    return [head, *(_INDENT + line for line in child)]


def _vector(values: Sequence[float]) -> str:
    return f"[{', '.join(format_number(v) for v in values)}]"


def format_number(value: float) -> str:
    """Return a number with six decimals at most, without trailing zeros or a negative zero."""
    text = f"{value:.6f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text
