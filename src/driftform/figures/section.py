"""One body to scale, as a half section: the outside above the axis, the section below it."""

from typing import NamedTuple
from xml.etree import ElementTree as ET

import numpy as np

from driftform.agent import hull_mass
from driftform.agent.distance import radius_at
from driftform.figures import svg
from driftform.figures.bodies import Placement, closed_outline, draw_rims, draw_shading, inner_joints
from driftform.figures.layout import MARGIN, MINUS, draw_scale_bar, format_signed, shorten, text_width, write
from driftform.figures.style import BLUE, INK, MUTED, ORANGE, tint
from driftform.figures.surface import Surface, find_rest, find_surface
from driftform.figures.svg import PX_PER_MM
from driftform.types import Agent, Body, FloatArray
from driftform.water import Scenario

_STEEL = "#3d5a73"
_WIDEST, _TALLEST = 800.0, 580.0
_HEADER, _LABELS, _CALLOUTS, _DIMENSION, _FOOTER, _BLOCK = 62.0, 44.0, 34.0, 46.0, 40.0, 46.0
_LEFT, _RIGHT = 138.0, 62.0
_SCALE = 280.0
"""Width kept free for the scale and its bar, px."""

_NARROW, _BESIDE = 230.0, 160.0
"""If the body is shorter than the first (px), the labels of wall and core are beside it and take the second (px)."""

_AROUND = 10.0
"""Width of the water that is drawn beside the body, px."""


class Ratio(NamedTuple):
    """A drawing scale, paper to body: 1 : 2 is half size."""

    paper: int
    body: int

    @property
    def text(self) -> str:
        """The ratio as drawings write it."""
        return f"{self.paper} : {self.body}"


# The scales that ISO 5455 recommends.
_RATIOS = tuple(
    [Ratio(a * 10**n, 1) for n in (2, 1, 0) for a in (5, 2, 1)]
    + [Ratio(1, a * 10**n) for n in range(6) for a in (2, 5, 10)]
)


def section_svg(agent: Agent, title: str = "", scenario: Scenario | None = None) -> str:
    """Return the half section of one body as SVG: outside above the axis, cut below, fore end to the right.

    Parameters
    ----------
    agent
        drawn with the body's x to the right and z upward. The centres of gravity (a quartered circle) and of
        buoyancy (a ring) are those of ``agent.mass``. Ticks below the length mark the joints between modules.
    title
        a line above the picture.
    scenario
        its water gives the net buoyancy, and the water line of a body that floats: the surface when the body is at
        rest, far from any wall. If the scenario has no surface, the line is where one would be.

    The natural size is in millimetres: printed at that size, the picture has the scale that it states.
    """
    body = agent.body
    ratio = _choose_ratio(body)
    px_per_m = 1000 * PX_PER_MM * ratio.paper / ratio.body
    length, diameter = body.length * px_per_m, body.max_diameter * px_per_m
    facts, block = _describe_agent(agent), title_block(agent, scenario)
    rest = None if scenario is None else find_rest(agent, scenario)
    legend = 0.0 if rest is None else 34 + text_width(rest.text, 11) + _SCALE
    least = max(text_width(facts, 12), _block_width(block), legend, 556.0) + 2 * MARGIN
    width = max(length + _LEFT + _RIGHT, least)
    if length < _NARROW:
        width = max(width, length + _LEFT + _RIGHT + 2 * _BESIDE)
    above = _HEADER + _LABELS
    height = above + diameter + _CALLOUTS + _DIMENSION + _FOOTER + _BLOCK
    left = _LEFT + (width - _LEFT - _RIGHT - length) / 2
    place = Placement(left - px_per_m * float(body.outer[0, 0]), above + diameter / 2, px_per_m)

    size = f"{_format_mm(body.length)} long, {_format_mm(body.max_diameter)} in diameter"
    values = "; ".join(f"{name} {value}" for name, value in block)
    root = svg.start_document(
        width,
        height,
        title or "Section of an agent",
        f"Half section of a body of revolution, {size}, at a scale of {ratio.text}: outside above the "
        f"axis, cut open below; the fore end is on the right. {facts}; {values}.",
        unit="mm",
    )
    write(root, MARGIN, 32, shorten(title or "Section", 17, width - 2 * MARGIN, bold=True), 17, bold=True)
    write(root, MARGIN, 52, facts, 12, MUTED)
    surface = (
        None
        if rest is None or rest.height is None
        else find_surface(rest.pitch, rest.height, body, place, _AROUND)
    )
    if surface is not None:
        svg.add(root, "path", class_="water", d=svg.path_data(surface.wet, closed=True), fill=tint(BLUE, 0.1))
    draw_shading(root, body, place, _STEEL, below=0)
    draw_rims(root, body, place, tint(_STEEL, 0.62), 0.7, below=0)
    _draw_cut(root, body, place)
    outline = svg.path_data(place.to_page(closed_outline(body.outer)), closed=True)
    svg.add_line(root, outline, INK, 1.3, "outline", stroke_linejoin="round")
    _draw_axis(root, body, place)
    if surface is not None:
        _draw_water_line(root, surface)
    _draw_callouts(root, body, place)
    _draw_dimensions(root, body, place)
    _draw_centres(root, agent, place, width)
    base = height - _BLOCK - 18
    _draw_scale(root, ratio, px_per_m, width, base)
    if rest is not None:
        _draw_legend(root, rest.text, surface is not None, base)
    _draw_block(root, block, width, height - _BLOCK + 2)
    return svg.render(root)


def _choose_ratio(body: Body) -> Ratio:
    fits = (
        ratio
        for ratio in _RATIOS
        if 1000 * PX_PER_MM * body.length * ratio.paper / ratio.body <= _WIDEST
        and 1000 * PX_PER_MM * body.max_diameter * ratio.paper / ratio.body <= _TALLEST
    )
    return next(fits, _RATIOS[-1])


def _describe_agent(agent: Agent) -> str:
    mass = agent.mass
    modules = (
        max(len(agent.body.joints) - 1, 0) if agent.morphology is None else len(agent.morphology.modules)
    )
    count = {0: "Bare core", 1: "1 module"}.get(modules, f"{modules} modules")
    density = f", mean density {mass.mass / mass.volume:.0f} kg/m³" if mass.volume > 0 else ""
    return f"{count}, {1000 * mass.mass:.1f} g, displaces {1e6 * mass.volume:.1f} cm³{density}"


def title_block(agent: Agent, scenario: Scenario | None) -> list[tuple[str, str]]:
    """Return names and values of the title block: masses and volume, and with a scenario the net buoyancy."""
    body, mass = agent.body, agent.mass
    block = [
        ("mass", f"{1000 * mass.mass:.1f} g"),
        ("hull", f"{1000 * hull_mass(body):.1f} g of {body.hull_density:.0f} kg/m³"),
        ("core", f"{1000 * body.core.mass:.1f} g"),
        *(
            [("ballast", f"{1000 * body.ballast.volume * body.ballast_density:.2f} g")]
            if body.ballast.volume
            else []
        ),
        ("volume", f"{1e6 * mass.volume:.1f} cm³"),
    ]
    if scenario is not None:
        fluid = scenario.fluid
        block.append(("net buoyancy", f"{mass.net_buoyancy(fluid):+.3g} N".replace("-", MINUS)))
        block.append(("water", f"{fluid.density:.0f} kg/m³"))
    return block


def _format_mm(metres: float) -> str:
    return f"{1000 * metres:.1f} mm"


def _draw_cut(root: ET.Element, body: Body, place: Placement) -> None:
    flip = (1.0, -1.0)
    wall = place.to_page(body.outer * flip)
    cavity = place.to_page(body.cavity * flip)
    data = svg.path_data(wall, closed=True) + svg.path_data(cavity, closed=True)
    svg.add(root, "path", class_="wall", d=data, fill=tint(_STEEL, 0.16), fill_rule="evenodd")
    # A wall of a few px needs close lines to look hatched.
    spacing = 4.0 if body.wall * place.px_per_m < 8 else 6.0
    lines = hatch([wall, cavity], spacing)
    if len(lines):
        svg.add_line(root, svg.lines_data(lines), _STEEL, 0.8, "hatch")
    if len(cavity):
        svg.add_line(root, svg.path_data(cavity), INK, 0.9, "cavity", stroke_linejoin="round")
    if ball := body.ballast.volume:
        at = place.x + place.px_per_m * body.ballast.centroid
        radius = place.px_per_m * (0.75 * ball / np.pi) ** (1 / 3)
        svg.add_circle(root, at, place.y, radius, tint(INK, 0.55), class_="ballast")
    radius = body.core.radius * place.px_per_m
    svg.add_circle(root, place.x, place.y, radius, ORANGE, class_="core")
    # Above the axis the core is behind the wall: lighter, with a dashed (hidden) edge.
    r, y = svg.format_number(radius), svg.format_number(place.y)
    upper = (
        f"M{svg.format_number(place.x - radius)} {y}A{r} {r} 0 0 1 {svg.format_number(place.x + radius)} {y}"
    )
    svg.add(root, "path", d=upper + "Z", fill=tint(ORANGE, 0.5))
    svg.add_line(root, upper, "#7a5300", 0.9, stroke_dasharray="4 3")
    svg.add_line(root, upper.replace("0 0 1", "0 0 0"), "#7a5300", 1.1)


def hatch(polygons: list[FloatArray], spacing: float) -> FloatArray:
    """Return the pieces of 45 degree lines ``spacing`` apart that lie inside ``polygons``, (pieces, 2, 2).

    The even-odd rule decides what is inside. An SVG pattern would do the same, but needs an id.
    """
    root = np.sqrt(0.5)
    turned = [
        np.column_stack([(p[:, 0] + p[:, 1]) * root, (p[:, 1] - p[:, 0]) * root]) for p in polygons if len(p)
    ]
    starts = np.vstack(turned)
    ends = np.vstack([np.roll(p, -1, axis=0) for p in turned])
    lines = (
        np.arange(np.ceil(starts[:, 0].min() / spacing), np.floor(starts[:, 0].max() / spacing) + 1) * spacing
    )
    # Half-open intervals, so that a line through a corner meets only one of its two edges.
    line, edge = np.nonzero((starts[:, 0] <= lines[:, None]) != (ends[:, 0] <= lines[:, None]))
    a, b, u = starts[edge], ends[edge], lines[line]
    v = a[:, 1] + (u - a[:, 0]) / (b[:, 0] - a[:, 0]) * (b[:, 1] - a[:, 1])
    # A line enters and leaves in turn, so it has an even number of crossings.
    low, high = v[np.lexsort((v, line))].reshape(-1, 2).T
    pieces = np.array([[u[::2] - low, u[::2] + low], [u[::2] - high, u[::2] + high]]) * root
    return np.asarray(pieces.transpose(2, 0, 1)[high - low > 0.3])


def _draw_axis(root: ET.Element, body: Body, place: Placement) -> None:
    left, right = (place.x + place.px_per_m * float(x) for x in body.outer[[0, -1], 0])
    svg.add_segment(
        root, left - 14, place.y, right + 14, place.y, INK, 0.8, class_="axis", stroke_dasharray="12 3 2 3"
    )
    write(root, right + 20, place.y + 4, "fore", 11, MUTED)


def _draw_water_line(root: ET.Element, surface: Surface) -> None:
    """Draw the water's surface with its symbol, a triangle."""
    line = svg.path_data(surface.line)
    svg.add_line(root, line, "#ffffff", 3.2)
    svg.add_line(root, line, BLUE, 1.4, "water-line", stroke_dasharray="9 3")
    (start, end), up = surface.line, surface.up
    # Keep off the labels: those of the centres are above the body, that of the axis is on the right.
    tip = max(start, end, key=lambda point: float(point[1] - point[0]))
    inward = (start + end) / 2 - tip
    tip = tip + 9 * inward / max(float(np.hypot(*inward)), 1e-9)
    along = np.array([-up[1], up[0]])
    corners = np.array([tip, tip + 8 * up + 5 * along, tip + 8 * up - 5 * along])
    svg.add(
        root, "path", d=svg.path_data(corners, closed=True), fill="#ffffff", stroke=BLUE, stroke_width=1.2
    )


def _draw_legend(root: ET.Element, text: str, floats: bool, base: float) -> None:
    x = MARGIN
    if floats:
        line = svg.path_data([(x, base - 4), (x + 26, base - 4)])
        svg.add_line(root, line, BLUE, 1.4, stroke_dasharray="9 3")
        x += 34
    write(root, x, base, text, 11, MUTED, class_="rest")


def _draw_dimensions(root: ET.Element, body: Body, place: Placement) -> None:
    outline = place.to_page(body.outer)
    left, right = outline[0, 0], outline[-1, 0]
    bottom = place.y + body.max_diameter / 2 * place.px_per_m
    level = bottom + _CALLOUTS + 24
    for x, end in ((left, body.outer[0, 0]), (right, body.outer[-1, 0])):
        edge = place.y + radius_at(body.outer, float(end)) * place.px_per_m
        _draw_thin(root, x, edge + 4, x, level + 5)
    _draw_arrow(root, left, level, right, level)
    joints = place.x + place.px_per_m * inner_joints(body)
    if len(joints):
        ticks = np.array([[(x, level), (x, level + 5)] for x in joints])
        svg.add_line(root, svg.lines_data(ticks), MUTED, 0.8, "ticks")
    text = _format_mm(body.length)
    fits = right - left > text_width(text, 12) + 20
    write(
        root,
        (left + right) / 2,
        level - 5 if fits else level + 18,
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
    write(
        root,
        column - 9,
        place.y + 4,
        f"Ø {_format_mm(body.max_diameter)}",
        12,
        anchor="end",
        class_="diameter",
    )


def _draw_callouts(root: ET.Element, body: Body, place: Placement) -> None:
    """Draw the dimensions of wall and core, each with a leader from a label below the body."""
    bottom = place.y + body.max_diameter / 2 * place.px_per_m
    left, right = (place.x + place.px_per_m * float(x) for x in body.outer[[0, -1], 0])
    base = bottom + 26
    wall = _find_wall_spot(body, place)
    labels = [("core", place.x, f"core Ø {_format_number(2000 * body.core.radius)} mm")]
    if wall is not None:
        labels.append(("wall", float(wall[0][0]), f"wall {_format_number(1000 * body.wall)} mm"))
    labels.sort(key=lambda label: label[1])
    widths = [text_width(text, 12) + 8 for _, _, text in labels]
    if right - left >= _NARROW and sum(widths) + 20 < right - left:
        wanted = [at for _, at, _ in labels]
        centres = _space_labels(wanted, widths, left + 4, right - 4) if len(labels) == 2 else wanted
    else:
        # Beside the extension lines of the length, on the side that the wall faces, so that no leader crosses it.
        faces_aft = wall is None or wall[0][0] < wall[1][0]
        first = left - 10 - sum(widths) if faces_aft else right + 10
        centres = [first + sum(widths[:i]) + widths[i] / 2 for i in range(len(widths))]
    for (name, _, text), centre in zip(labels, centres, strict=True):
        write(root, centre, base, text, 12, anchor="middle", class_=f"{name}-label")
        start = np.array([centre, base - 13])
        if name == "core":
            towards = start - (place.x, place.y)
            tip = (place.x, place.y) + body.core.radius * place.px_per_m * towards / np.hypot(*towards)
            _draw_thin(root, *start, *tip)
            _draw_head(root, tip, start)
        elif wall is not None:
            outside, inside = wall
            normal = (outside - inside) / np.hypot(*(outside - inside))
            _draw_thin(root, *start, *(outside + 12 * normal))
            for tip, away in ((outside, 12 * normal), (inside, -12 * normal)):
                _draw_thin(root, *tip, *(tip + away))
                _draw_head(root, tip, tip + away, 6.0)


def _find_wall_spot(body: Body, place: Placement) -> tuple[FloatArray, FloatArray] | None:
    """Return the outer and inner point where the wall is dimensioned: the middle of an edge of the cavity.

    The edge chosen is long, runs along the axis rather than across it, and lies far from the axis and the core's label.
    """
    if not len(body.cavity):
        return None
    start, edge = body.cavity[:-1], np.diff(body.cavity, axis=0)
    middle = start + edge / 2
    worth = np.abs(edge[:, 0]) * (0.3 + middle[:, 1] / body.cavity[:, 1].max())
    worth *= np.where(np.abs(middle[:, 0]) > 0.6 * body.core.radius, 1.0, 0.2)
    best = int(np.argmax(worth))
    normal = np.array([-edge[best, 1], edge[best, 0]]) / np.hypot(*edge[best])
    outside, inside = place.to_page(np.array([middle[best] + body.wall * normal, middle[best]]) * (1.0, -1.0))
    return outside, inside


def _format_number(value: float) -> str:
    return f"{value:.3f}".rstrip("0").rstrip(".")


def _draw_thin(root: ET.Element, x1: float, y1: float, x2: float, y2: float) -> None:
    svg.add_segment(root, x1, y1, x2, y2, MUTED, 0.8)


def _draw_arrow(root: ET.Element, x1: float, y1: float, x2: float, y2: float) -> None:
    """Draw a dimension line with a slim arrowhead at each end."""
    _draw_thin(root, x1, y1, x2, y2)
    span = float(np.hypot(x2 - x1, y2 - y1))
    if span == 0:
        return
    head = min(9.0, span / 3)
    _draw_head(root, np.array([x1, y1]), np.array([x2, y2]), head)
    _draw_head(root, np.array([x2, y2]), np.array([x1, y1]), head)


def _draw_head(root: ET.Element, tip: FloatArray, tail: FloatArray, size: float = 8.0) -> None:
    """Draw a slim arrowhead at ``tip`` of an arrow from ``tail``."""
    back = size * (tail - tip) / np.hypot(*(tail - tip))
    aside = 0.22 * np.array([-back[1], back[0]])
    corners = np.array([tip, tip + back + aside, tip + back - aside])
    svg.add(root, "path", d=svg.path_data(corners, closed=True), fill=MUTED)


def _draw_centres(root: ET.Element, agent: Agent, place: Placement, width: float) -> None:
    cob, cog = (place.to_page(c[None, [0, 2]])[0] for c in (agent.mass.cob, agent.mass.cog))
    marks = [
        ("COG", cog, f"COG x = {format_signed(1000 * agent.mass.cog[0], 1)} mm", 6.0),
        ("COB", cob, f"COB x = {format_signed(1000 * agent.mass.cob[0], 1)} mm", 9.0),
    ]
    marks.sort(key=lambda mark: float(mark[1][0]))
    sizes = [text_width(label, 12, bold=True) + 20 for _, _, label, _ in marks]
    centres = _space_labels([float(mark[1][0]) for mark in marks], sizes, 16, width - 16)
    top = place.y - agent.body.max_diameter / 2 * place.px_per_m
    for (_, at, _, radius), centre in zip(marks, centres, strict=True):
        leader = [(at[0], at[1] - radius), (at[0], top - 8), (centre, top - 18)]
        svg.add_line(root, svg.path_data(leader), INK, 0.8)
    _draw_buoyancy(root, float(cob[0]), float(cob[1]), 9)
    _draw_gravity(root, float(cog[0]), float(cog[1]), 6)
    for (name, _, label, _), centre, size in zip(marks, centres, sizes, strict=True):
        x = centre - size / 2
        if name == "COG":
            _draw_gravity(root, x + 7, top - 28, 5)
        else:
            _draw_buoyancy(root, x + 7, top - 28, 5)
        write(root, x + 18, top - 24, label, 12, class_=name.lower())


def _space_labels(wanted: list[float], widths: list[float], low: float, high: float) -> list[float]:
    """Return the centres of two labels in a row, as near to ``wanted`` (ascending) as possible without overlap."""
    apart = (widths[0] + widths[1]) / 2 + 10
    lack = max(0.0, apart - (wanted[1] - wanted[0])) / 2
    first, second = wanted[0] - lack, wanted[1] + lack
    first = max(first, low + widths[0] / 2)
    second = min(max(second, first + apart), high - widths[1] / 2)
    return [min(first, second - apart), second]


def _draw_gravity(root: ET.Element, x: float, y: float, r: float) -> None:
    svg.add_circle(root, x, y, r, "#ffffff", INK, 1.2, class_="cog")
    n = svg.format_number
    quarters = "".join(
        f"M{n(x)} {n(y)}L{n(x + a * r)} {n(y)}A{n(r)} {n(r)} 0 0 0 {n(x)} {n(y - a * r)}Z" for a in (1, -1)
    )
    svg.add(root, "path", d=quarters, fill=INK)


def _draw_buoyancy(root: ET.Element, x: float, y: float, r: float) -> None:
    svg.add_circle(root, x, y, r, "none", "#ffffff", 4.5)
    svg.add_circle(root, x, y, r, "none", BLUE, 2.2, class_="cob")


def _draw_scale(root: ET.Element, ratio: Ratio, px_per_m: float, width: float, base: float) -> None:
    left = draw_scale_bar(root, width - MARGIN, base, px_per_m, 130)
    write(root, left - 16, base, f"Scale {ratio.text}", 11, MUTED, anchor="end", class_="scale")


def _draw_block(root: ET.Element, block: list[tuple[str, str]], width: float, top: float) -> None:
    """Draw the title block: cells side by side, each with a name above its value."""
    x, bottom = MARGIN, top + 34
    spare = (width - 2 * MARGIN - _block_width(block)) / len(block)
    lines = svg.path_data(
        [(x, top), (width - MARGIN, top), (width - MARGIN, bottom), (x, bottom)], closed=True
    )
    for index, (name, value) in enumerate(block):
        if index:
            lines += svg.path_data([(x, top), (x, bottom)])
        write(root, x + 8, top + 13, name, 10, MUTED)
        write(root, x + 8, top + 28, value, 12, class_="cell")
        x += _cell_width(name, value) + spare
    svg.add_line(root, lines, MUTED, 0.8, "block")


def _cell_width(name: str, value: str) -> float:
    return max(text_width(name, 10), text_width(value, 12)) + 16


def _block_width(block: list[tuple[str, str]]) -> float:
    return sum(_cell_width(name, value) for name, value in block)
