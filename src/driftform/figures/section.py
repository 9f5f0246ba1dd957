"""One body to scale, as a half section: the outside above the axis, the cut below it."""

from typing import NamedTuple
from xml.etree import ElementTree as ET

import numpy as np

from driftform.figures import svg
from driftform.figures.bodies import Placement, closed_outline, draw_rims, draw_shading, radius_at
from driftform.figures.layout import nice_below, shorten, signed, text_width, write
from driftform.figures.style import BLUE, INK, MUTED, ORANGE, tint
from driftform.figures.svg import PX_PER_MM
from driftform.types import Agent, Body, FloatArray

_STEEL = "#3d5a73"
_WIDEST, _TALLEST = 800.0, 580.0
_HEADER, _LABELS, _DIMENSION, _FOOTER = 62.0, 44.0, 46.0, 50.0
_LEFT, _RIGHT, _MARGIN = 138.0, 62.0, 22.0


class Ratio(NamedTuple):
    """A drawing scale, paper to body: 1 : 2 is half size."""

    paper: int
    body: int

    @property
    def text(self) -> str:
        """How a drawing states it."""
        return f"{self.paper} : {self.body}"


# The scales that ISO 5455 recommends, and that a ruler can be read against.
_RATIOS = tuple(
    [Ratio(a * 10**n, 1) for n in (2, 1, 0) for a in (5, 2, 1)]
    + [Ratio(1, a * 10**n) for n in range(6) for a in (2, 5, 10)]
)


def section_svg(agent: Agent, title: str = "") -> str:
    """Return the half section of one body as SVG: outside above the axis, cut below, fore end to the right.

    Parameters
    ----------
    agent
        its body frame has x to the right and z upward on the page. The centres of gravity (a quartered
        circle) and of buoyancy (a ring) are those of ``agent.mass``.
    title
        a line above the picture.

    The natural size is stated in millimetres: printed at it, the picture is to the scale that it names.
    """
    body = agent.body
    ratio = _ratio(body)
    px_per_m = 1000 * PX_PER_MM * ratio.paper / ratio.body
    length, diameter = body.length * px_per_m, body.max_diameter * px_per_m
    facts = _facts(agent)
    width = max(length + _LEFT + _RIGHT, text_width(facts, 12) + 2 * _MARGIN, 600.0)
    above = _HEADER + _LABELS
    height = above + diameter + _DIMENSION + _FOOTER
    left = _LEFT + (width - _LEFT - _RIGHT - length) / 2
    place = Placement(left - px_per_m * float(body.outer[0, 0]), above + diameter / 2, px_per_m)

    size = f"{_mm(body.length)} long, {_mm(body.max_diameter)} in diameter"
    root = svg.document(
        width,
        height,
        title or "Section of an agent",
        f"Half section of a body of revolution, {size}, at a scale of {ratio.text}: outside above the "
        f"axis, cut open below; the fore end is on the right. {facts}.",
        unit="mm",
    )
    write(root, _MARGIN, 32, shorten(title or "Section", 17, width - 2 * _MARGIN, bold=True), 17, bold=True)
    write(root, _MARGIN, 52, facts, 12, MUTED)
    draw_shading(root, body, place, _STEEL, below=0)
    draw_rims(root, body, place, tint(_STEEL, 0.62), 0.7, below=0)
    _draw_cut(root, body, place)
    outline = svg.polyline(place.to_page(closed_outline(body.outer)), closed=True)
    svg.add(
        root,
        "path",
        class_="outline",
        d=outline,
        fill="none",
        stroke=INK,
        stroke_width=1.3,
        stroke_linejoin="round",
    )
    _draw_axis(root, body, place)
    _draw_dimensions(root, body, place)
    _draw_centres(root, agent, place, width)
    _draw_footer(root, body, ratio, px_per_m, width, height)
    return svg.render(root)


def _ratio(body: Body) -> Ratio:
    fits = (
        ratio
        for ratio in _RATIOS
        if 1000 * PX_PER_MM * body.length * ratio.paper / ratio.body <= _WIDEST
        and 1000 * PX_PER_MM * body.max_diameter * ratio.paper / ratio.body <= _TALLEST
    )
    return next(fits, _RATIOS[-1])


def _facts(agent: Agent) -> str:
    mass = agent.mass
    modules = (
        max(len(agent.body.joints) - 1, 0) if agent.morphology is None else len(agent.morphology.modules)
    )
    count = {0: "Bare core", 1: "1 module"}.get(modules, f"{modules} modules")
    density = f", mean density {mass.mass / mass.volume:.0f} kg/m³" if mass.volume > 0 else ""
    return f"{count}, {1000 * mass.mass:.1f} g, displaces {1e6 * mass.volume:.1f} cm³{density}"


def _mm(metres: float) -> str:
    return f"{1000 * metres:.1f} mm"


def _draw_cut(root: ET.Element, body: Body, place: Placement) -> None:
    flip = (1.0, -1.0)
    wall = place.to_page(body.outer * flip)
    cavity = place.to_page(body.cavity * flip)
    data = svg.polyline(wall, closed=True) + svg.polyline(cavity, closed=True)
    svg.add(root, "path", class_="wall", d=data, fill=tint(_STEEL, 0.16), fill_rule="evenodd")
    # A wall of a few px needs close lines to look hatched at all.
    spacing = 4.0 if body.wall * place.px_per_m < 8 else 6.0
    lines = "".join(svg.polyline(pair) for pair in hatch([wall, cavity], spacing))
    if lines:
        svg.add(root, "path", class_="hatch", d=lines, fill="none", stroke=_STEEL, stroke_width=0.8)
    if len(cavity):
        svg.add(
            root,
            "path",
            class_="cavity",
            d=svg.polyline(cavity),
            fill="none",
            stroke=INK,
            stroke_width=0.9,
            stroke_linejoin="round",
        )
    radius = body.core.radius * place.px_per_m
    svg.add(root, "circle", class_="core", cx=place.x, cy=place.y, r=radius, fill=ORANGE)
    # Above the axis the core is behind the wall: lighter, with the dashes of a hidden edge.
    r, y = svg.number(radius), svg.number(place.y)
    upper = f"M{svg.number(place.x - radius)} {y}A{r} {r} 0 0 1 {svg.number(place.x + radius)} {y}"
    svg.add(root, "path", d=upper + "Z", fill=tint(ORANGE, 0.5))
    svg.add(root, "path", d=upper, fill="none", stroke="#7a5300", stroke_width=0.9, stroke_dasharray="4 3")
    svg.add(root, "path", d=upper.replace("0 0 1", "0 0 0"), fill="none", stroke="#7a5300", stroke_width=1.1)


def hatch(polygons: list[FloatArray], spacing: float) -> list[FloatArray]:
    """Return the pieces, (2, 2) each, of 45 degree lines ``spacing`` apart that lie inside ``polygons``.

    Inside is by the even-odd rule. A pattern fill would do the same, but needs an id.
    """
    root = np.sqrt(0.5)
    turned = [
        np.column_stack([(p[:, 0] + p[:, 1]) * root, (p[:, 1] - p[:, 0]) * root]) for p in polygons if len(p)
    ]
    starts = np.vstack(turned)
    ends = np.vstack([np.roll(p, -1, axis=0) for p in turned])
    pieces: list[FloatArray] = []
    lines = (
        np.arange(np.ceil(starts[:, 0].min() / spacing), np.floor(starts[:, 0].max() / spacing) + 1) * spacing
    )
    for u in lines:
        # Half-open, so that a line through a corner meets one of its two edges.
        meets = (starts[:, 0] <= u) != (ends[:, 0] <= u)
        a, b = starts[meets], ends[meets]
        v = np.sort(a[:, 1] + (u - a[:, 0]) / (b[:, 0] - a[:, 0]) * (b[:, 1] - a[:, 1]))
        for low, high in v.reshape(-1, 2):
            if high - low > 0.3:
                pieces.append(
                    np.array([[(u - low) * root, (u + low) * root], [(u - high) * root, (u + high) * root]])
                )
    return pieces


def _draw_axis(root: ET.Element, body: Body, place: Placement) -> None:
    left, right = (place.x + place.px_per_m * float(x) for x in body.outer[[0, -1], 0])
    svg.add(
        root,
        "line",
        class_="axis",
        x1=left - 14,
        y1=place.y,
        x2=right + 14,
        y2=place.y,
        stroke=INK,
        stroke_width=0.8,
        stroke_dasharray="12 3 2 3",
    )
    write(root, right + 20, place.y + 4, "fore", 11, MUTED)


def _draw_dimensions(root: ET.Element, body: Body, place: Placement) -> None:
    outline = place.to_page(body.outer)
    left, right = outline[0, 0], outline[-1, 0]
    bottom = place.y + body.max_diameter / 2 * place.px_per_m
    level = bottom + 28
    for x, end in ((left, body.outer[0, 0]), (right, body.outer[-1, 0])):
        edge = place.y + radius_at(body.outer, float(end)) * place.px_per_m
        _draw_thin(root, x, edge + 4, x, level + 5)
    _draw_arrow(root, left, level, right, level)
    text = _mm(body.length)
    fits = right - left > text_width(text, 12) + 20
    write(
        root,
        (left + right) / 2,
        level - 5 if fits else level + 16,
        text,
        12,
        anchor="middle",
        class_="length",
    )

    column = left - 30
    widest = int(np.argmax(body.outer[:, 1]))
    top = outline[widest]
    for y in (top[1], 2 * place.y - top[1]):
        _draw_thin(root, top[0] - 4, y, column - 5, y)
    _draw_arrow(root, column, top[1], column, 2 * place.y - top[1])
    write(root, column - 9, place.y + 4, f"Ø {_mm(body.max_diameter)}", 12, anchor="end", class_="diameter")


def _draw_thin(root: ET.Element, x1: float, y1: float, x2: float, y2: float) -> None:
    svg.add(root, "line", x1=x1, y1=y1, x2=x2, y2=y2, stroke=MUTED, stroke_width=0.8)


def _draw_arrow(root: ET.Element, x1: float, y1: float, x2: float, y2: float) -> None:
    """Draw a dimension line with a slim arrowhead at each end."""
    _draw_thin(root, x1, y1, x2, y2)
    span = float(np.hypot(x2 - x1, y2 - y1))
    if span == 0:
        return
    along = np.array([x2 - x1, y2 - y1]) / span
    head = min(9.0, span / 3)
    aside = np.array([-along[1], along[0]]) * head * 0.22
    for tip, back in (((x1, y1), head * along), ((x2, y2), -head * along)):
        corners = np.array([tip, tip + back + aside, tip + back - aside])
        svg.add(root, "path", d=svg.polyline(corners, closed=True), fill=MUTED)


def _draw_centres(root: ET.Element, agent: Agent, place: Placement, width: float) -> None:
    cob, cog = (place.to_page(c[None, [0, 2]])[0] for c in (agent.mass.cob, agent.mass.cog))
    marks = [
        ("COG", cog, f"COG x = {signed(1000 * agent.mass.cog[0], 1)} mm", 6.0),
        ("COB", cob, f"COB x = {signed(1000 * agent.mass.cob[0], 1)} mm", 9.0),
    ]
    marks.sort(key=lambda mark: float(mark[1][0]))
    sizes = [text_width(label, 12, bold=True) + 20 for _, _, label, _ in marks]
    centres = _spread([float(mark[1][0]) for mark in marks], sizes, 16, width - 16)
    top = place.y - agent.body.max_diameter / 2 * place.px_per_m
    for (_, at, _, radius), centre in zip(marks, centres, strict=True):
        leader = [(at[0], at[1] - radius), (at[0], top - 8), (centre, top - 18)]
        svg.add(root, "path", d=svg.polyline(leader), fill="none", stroke=INK, stroke_width=0.8)
    _draw_buoyancy(root, float(cob[0]), float(cob[1]), 9)
    _draw_gravity(root, float(cog[0]), float(cog[1]), 6)
    for (name, _, label, _), centre, size in zip(marks, centres, sizes, strict=True):
        x = centre - size / 2
        if name == "COG":
            _draw_gravity(root, x + 7, top - 28, 5)
        else:
            _draw_buoyancy(root, x + 7, top - 28, 5)
        write(root, x + 18, top - 24, label, 12, class_=name.lower())


def _spread(wanted: list[float], widths: list[float], low: float, high: float) -> list[float]:
    """Return the centres of two labels in a row, as near to ``wanted`` (ascending) as they fit."""
    apart = (widths[0] + widths[1]) / 2 + 10
    lack = max(0.0, apart - (wanted[1] - wanted[0])) / 2
    first, second = wanted[0] - lack, wanted[1] + lack
    first = max(first, low + widths[0] / 2)
    second = min(max(second, first + apart), high - widths[1] / 2)
    return [min(first, second - apart), second]


def _draw_gravity(root: ET.Element, x: float, y: float, r: float) -> None:
    svg.add(root, "circle", class_="cog", cx=x, cy=y, r=r, fill="#ffffff", stroke=INK, stroke_width=1.2)
    n = svg.number
    quarters = "".join(
        f"M{n(x)} {n(y)}L{n(x + a * r)} {n(y)}A{n(r)} {n(r)} 0 0 0 {n(x)} {n(y - a * r)}Z" for a in (1, -1)
    )
    svg.add(root, "path", d=quarters, fill=INK)


def _draw_buoyancy(root: ET.Element, x: float, y: float, r: float) -> None:
    svg.add(root, "circle", cx=x, cy=y, r=r, fill="none", stroke="#ffffff", stroke_width=4.5)
    svg.add(root, "circle", class_="cob", cx=x, cy=y, r=r, fill="none", stroke=BLUE, stroke_width=2.2)


def _draw_footer(
    root: ET.Element, body: Body, ratio: Ratio, px_per_m: float, width: float, height: float
) -> None:
    base = height - 18
    bar = nice_below(130 / px_per_m)
    span = bar * px_per_m
    end = width - _MARGIN
    svg.add(
        root,
        "path",
        class_="scale-bar",
        d=svg.polyline([(end - span, base - 4), (end - span, base), (end, base), (end, base - 4)]),
        fill="none",
        stroke=INK,
        stroke_width=1.2,
    )
    write(root, end - span / 2, base - 6, f"{1000 * bar:g} mm", 11, anchor="middle", class_="scale-bar-label")
    write(root, end - span - 16, base, f"Scale {ratio.text}", 11, MUTED, anchor="end", class_="scale")

    svg.add(root, "circle", cx=_MARGIN + 6, cy=base - 4, r=6, fill=ORANGE, stroke="#7a5300", stroke_width=1)
    core = f"core Ø {2000 * body.core.radius:g} mm, {1000 * body.core.mass:g} g"
    write(root, _MARGIN + 18, base, core, 11, MUTED)
    x = _MARGIN + 18 + text_width(core, 11) + 12
    swatch = np.array([[x, base - 10], [x + 18, base - 10], [x + 18, base + 2], [x, base + 2]])
    svg.add(
        root,
        "path",
        d=svg.polyline(swatch, closed=True),
        fill=tint(_STEEL, 0.16),
        stroke=INK,
        stroke_width=0.9,
    )
    lines = "".join(svg.polyline(pair) for pair in hatch([swatch], 4))
    svg.add(root, "path", d=lines, fill="none", stroke=_STEEL, stroke_width=0.8)
    write(root, x + 25, base, f"wall {1000 * body.wall:g} mm", 11, MUTED)
