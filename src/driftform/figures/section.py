"""One body to scale, as a half section: the outside above the axis, the section below it."""

from fractions import Fraction
from itertools import accumulate
from typing import Any

import numpy as np
import numpy.typing as npt

from driftform.agent import MassElement, hull_mass
from driftform.agent.distance import distance_from, radius_at
from driftform.figures import svg
from driftform.figures.bodies import Placement, closed_outline, draw_rims, draw_shading, inner_joints
from driftform.figures.layout import MARGIN, MINUS, draw_scale_bar, format_signed, text_width, write, write_title
from driftform.figures.rest import describe_rest
from driftform.figures.style import MUTED, PX_PER_MM, SCREEN, Page, tint
from driftform.types import Agent, Body, FloatArray
from driftform.water import Scenario

_STEEL = "#3d5a73"
_WIDEST, _TALLEST = 800.0, 580.0
_HEADER, _LABELS, _CALLOUTS, _DIMENSION, _FOOTER, _BLOCK = 62.0, 44.0, 34.0, 46.0, 40.0, 46.0
_LEFT, _RIGHT = 138.0, 62.0
_SCALE = 280.0
"""Width kept free for the scale and its bar, px."""

_THICKER = 1.05
"""Thickness of a wall, over its minimum, from which it is dimensioned as it is."""

_NARROW, _BESIDE = 230.0, 160.0
"""If the body is shorter than the first (px), the labels of wall and core are next to it and take the second (px)."""


# The scales that ISO 5455 recommends, paper over body.
_RATIOS = tuple(
    [Fraction(a * 10**n) for n in (2, 1, 0) for a in (5, 2, 1)]
    + [Fraction(1, a * 10**n) for n in range(6) for a in (2, 5, 10)]
)


def section_svg(agent: Agent, title: str = "", scenario: Scenario | None = None, page: Page = SCREEN) -> str:
    """Return the half section of one body as SVG: outside above the axis, cut below, fore end to the right.

    Args:
        agent: drawn with the body's x to the right and z upward. The centres of gravity (a quartered circle) and of
            buoyancy (a ring) are those of ``agent.mass``. Ticks below the length mark the joints between modules.
        title: a line above the picture.
        page: on paper, the body is as large as fits, title and table of masses are left out, and on a narrow page the
            labels of wall and core.
        scenario: its water gives the net buoyancy, and how the body rests in it, far from any wall.

    On a screen the natural size is in millimetres: printed at that size, the picture has the scale that it states.
    """
    body = agent.body
    ratio = _choose_ratio(body)
    written = f"{ratio.numerator} : {ratio.denominator}"
    px_per_m = 1000 * PX_PER_MM * ratio.numerator / ratio.denominator
    if page.is_paper:
        room = page.width - _LEFT - _RIGHT
        px_per_m = min(room / body.length, room / body.max_diameter)
    length, diameter = body.length * px_per_m, body.max_diameter * px_per_m
    facts, block = _describe_agent(agent), title_block(agent, scenario)
    rest = "" if scenario is None else describe_rest(agent, scenario)
    legend = text_width(rest, 11) + _SCALE if rest else 0.0
    least = max(text_width(facts, 12), _block_width(block), legend, 556.0) + 2 * MARGIN
    width = max(length + _LEFT + _RIGHT, least)
    if length < _NARROW:
        width = max(width, length + _LEFT + _RIGHT + 2 * _BESIDE)
    if page.is_paper:
        width = page.width
    above = _HEADER + _LABELS
    height = above + diameter + _CALLOUTS + _DIMENSION + _FOOTER
    left = _LEFT + (width - _LEFT - _RIGHT - length) / 2
    place = Placement(left - px_per_m * float(body.outer[0, 0]), above + diameter / 2, px_per_m)

    size = f"{_format_mm(body.length)} long, {_format_mm(body.max_diameter)} in diameter"
    values = "; ".join(f"{name} {value}" for name, value in block)
    scale = "" if page.is_paper else f", at a scale of {written}"
    root = svg.start_document(
        width,
        height + (0 if page.is_paper else _BLOCK),
        title or "Section of an agent",
        f"Half section of a body of revolution, {size}{scale}: outside above the "
        f"axis, cut open below; the fore end is on the right. {facts}; {values}.",
        unit="mm",
        page=page,
        header=_HEADER,
    )
    if not page.is_paper:
        write_title(root, MARGIN, 32, title or "Section", 17, width - 2 * MARGIN)
        write(root, MARGIN, 52, facts, 12, MUTED)
    draw_shading(root, body, place, _STEEL, below=0)
    draw_rims(root, body, place, tint(_STEEL, 0.62), 0.7, below=0)
    dimensions = {**_plot_cut(body, place), **_plot_callouts(body, place), **_plot_dimensions(body, place)}
    if page.is_paper and length < _NARROW:
        dimensions["labels"] = []
    centres = _plot_centres(agent, place, width)
    svg.draw_template(root, __package__, "section", marks=centres, **dimensions)
    base = height - 18
    bar = draw_scale_bar(root, width - MARGIN, base, px_per_m, 130)
    if page.is_paper:
        return svg.render(root)
    write(root, bar - 16, base, f"Scale {written}", 11, MUTED, anchor="end", class_="scale")
    if rest:
        write(root, MARGIN, base, rest, 11, MUTED, class_="rest")
    spare = (width - 2 * MARGIN - _block_width(block)) / len(block)
    widths = [_cell_width(name, value) + spare for name, value in block]
    cells = [(*cell, x) for cell, x in zip(block, accumulate(widths[:-1], initial=MARGIN), strict=True)]
    svg.draw_template(root, __package__, "title-block", cells=cells, left=MARGIN, right=width - MARGIN, top=height + 2)
    return svg.render(root)


def _choose_ratio(body: Body) -> Fraction:
    largest = min(_WIDEST / body.length, _TALLEST / body.max_diameter) / (1000 * PX_PER_MM)
    return next((ratio for ratio in _RATIOS if ratio <= largest), _RATIOS[-1])


def _describe_agent(agent: Agent) -> str:
    mass = agent.mass
    modules = max(len(agent.body.joints) - 1, 0) if agent.morphology is None else len(agent.morphology.modules)
    bare = "Bare core" if agent.body.core.radius > 0 else "No modules"
    count = {0: bare, 1: "1 module"}.get(modules, f"{modules} modules")
    density = f", mean density {mass.mass / mass.volume:.0f} kg/m³" if mass.volume > 0 else ""
    return f"{count}, {1000 * mass.mass:.1f} g, displaces {1e6 * mass.volume:.1f} cm³{density}"


def title_block(agent: Agent, scenario: Scenario | None) -> list[tuple[str, str]]:
    """Return names and values of the title block: masses and volume, and with a scenario the net buoyancy."""
    body, mass = agent.body, agent.mass
    putty = [MassElement.of_putty(pocket).mass for pocket in body.pockets]
    block = [
        ("mass", f"{1000 * mass.mass:.1f} g"),
        ("hull", f"{1000 * hull_mass(body):.1f} g of {body.hull_density:.0f} kg/m³"),
        *([("core", f"{1000 * body.core.mass:.1f} g")] if body.core.radius > 0 else []),
        *([("ballast", f"{1000 * body.ballast.volume * body.ballast_density:.2f} g")] if body.ballast.volume else []),
        *([("putty", f"{1000 * sum(putty):.2f} g")] if putty else []),
        ("volume", f"{1e6 * mass.volume:.1f} cm³"),
    ]
    if scenario is not None:
        fluid = scenario.fluid
        block.append(("net buoyancy", f"{mass.net_buoyancy(fluid):+.3g} N".replace("-", MINUS)))
        block.append(("water", f"{fluid.density:.0f} kg/m³"))
    return block


def _format_mm(metres: float) -> str:
    return f"{1000 * metres:.1f} mm"


def _plot_cut(body: Body, place: Placement) -> dict[str, Any]:
    """Return what the template draws of the cut: polygons, hatching, ballast and core, px."""
    pockets = [(pocket.contour(), pocket.contour(pocket.filled)) for pocket in body.pockets]
    wall, cavity = (place.to_page(contour * (1.0, -1.0)) for contour in (body.outer, body.cavity))
    holes, putty = ([place.to_page(pair[k] * (1.0, -1.0)) for pair in pockets] for k in (0, 1))
    # A wall of a few px needs close lines to look hatched.
    lines = hatch([wall, cavity, *holes], 4.0 if body.wall * place.px_per_m < 8 else 6.0)
    ballast = None
    if ball := body.ballast.volume:
        at = place.x + place.px_per_m * body.ballast.centroid
        ballast = at, place.px_per_m * (0.75 * ball / np.pi) ** (1 / 3)
    return {
        "x": place.x,
        "y": place.y,
        "steel": _STEEL,
        "wall": wall,
        "cavity": cavity,
        "pockets": holes,
        "putty": putty,
        "hatching": svg.lines_data(lines) if len(lines) else "",
        "ballast": ballast,
        "core": body.core.radius * place.px_per_m,
        "capsule": [
            place.to_page(np.array(body.core.contour or np.zeros((0, 2))) * (1.0, side)) for side in (1.0, -1.0)
        ],
        "outline": place.to_page(closed_outline(body.outer)),
    }


def hatch(polygons: list[FloatArray], spacing: float) -> FloatArray:
    """Return the pieces of 45 degree lines ``spacing`` apart that lie inside ``polygons``, (pieces, 2, 2).

    The even-odd rule decides what is inside. An SVG pattern would do the same, but needs an id.
    """
    root = np.sqrt(0.5)
    turned = [np.column_stack([(p[:, 0] + p[:, 1]) * root, (p[:, 1] - p[:, 0]) * root]) for p in polygons if len(p)]
    starts = np.vstack(turned)
    ends = np.vstack([np.roll(p, -1, axis=0) for p in turned])
    lines = np.arange(np.ceil(starts[:, 0].min() / spacing), np.floor(starts[:, 0].max() / spacing) + 1) * spacing
    # Half-open intervals, so that a line through a corner meets only one of its two edges.
    line, edge = np.nonzero((starts[:, 0] <= lines[:, None]) != (ends[:, 0] <= lines[:, None]))
    a, b, u = starts[edge], ends[edge], lines[line]
    v = a[:, 1] + (u - a[:, 0]) / (b[:, 0] - a[:, 0]) * (b[:, 1] - a[:, 1])
    # A line enters and leaves in turn, so it has an even number of crossings.
    low, high = v[np.lexsort((v, line))].reshape(-1, 2).T
    pieces = np.array([[u[::2] - low, u[::2] + low], [u[::2] - high, u[::2] + high]]) * root
    return np.asarray(pieces.transpose(2, 0, 1)[high - low > 0.3])


def _plot_dimensions(body: Body, place: Placement) -> dict[str, Any]:
    """Return what the template draws of length and diameter, px."""
    outline = place.to_page(body.outer)
    left, right = outline[0, 0], outline[-1, 0]
    level = place.y + body.max_diameter / 2 * place.px_per_m + _CALLOUTS + 24
    edges = [place.y + radius_at(body.outer, float(x)) * place.px_per_m for x in body.outer[[0, -1], 0]]
    joints = place.x + place.px_per_m * inner_joints(body)
    length = _format_mm(body.length)
    return {
        "left": left,
        "right": right,
        "level": level,
        "ends": [(left, edges[0]), (right, edges[1])],
        "ticks": svg.lines_data(np.array([[(x, level), (x, level + 5)] for x in joints]).reshape(-1, 2, 2)),
        "length": length,
        "length_fits": right - left > text_width(length, 12) + 20,
        "diameter": _format_mm(body.max_diameter),
        "widest": outline[int(np.argmax(body.outer[:, 1]))],
        "top": place.y - body.max_diameter / 2 * place.px_per_m,
        "find_head": _find_head,
    }


def _plot_callouts(body: Body, place: Placement) -> dict[str, Any]:
    """Return what the template draws of the dimensions of wall and core: labels below the body, and tips of leaders."""
    bottom = place.y + body.max_diameter / 2 * place.px_per_m
    left, right = (place.x + place.px_per_m * float(x) for x in body.outer[[0, -1], 0])
    wall = _find_wall_spot(body, place)
    long = f" x {_format_number(1000 * float(np.ptp(body.core.ends)))}" if body.core.contour else ""
    core = f"core Ø {_format_number(2000 * body.core.radius)}{long} mm"
    labels = [("core", place.x, core)] if body.core.radius > 0 else []
    if wall is not None:
        thickness = float(np.hypot(*(wall[0] - wall[1]))) / place.px_per_m
        labels.append(("wall", float(wall[0][0]), f"wall {_format_number(1000 * thickness)} mm"))
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

    def find_tip(start: tuple[float, float]) -> FloatArray:
        straight_down = np.array([0.0, 1.0])
        towards = straight_down if body.core.contour else np.array(start) - (place.x, place.y)
        tip = (place.x, place.y) + body.core.radius * place.px_per_m * towards / np.hypot(*towards)
        return np.asarray(tip)

    tips: list[tuple[FloatArray, FloatArray]] = []
    if wall is not None:
        normal = (wall[0] - wall[1]) / np.hypot(*(wall[0] - wall[1]))
        tips = [(tip, tip + length * normal) for tip, length in zip(wall, (12, -12), strict=True)]
    named = [(name, centre, text) for (name, _, text), centre in zip(labels, centres, strict=True)]
    return {"bottom": bottom, "labels": named, "find_tip": find_tip, "tips": tips}


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
    # The wall is thicker than its minimum where the cavity is narrow.
    thickness = float(distance_from(middle[best : best + 1], body.outer)[0])
    if thickness < _THICKER * body.wall:
        thickness = body.wall
    outside, inside = place.to_page(np.array([middle[best] + thickness * normal, middle[best]]) * (1.0, -1.0))
    return outside, inside


def _format_number(value: float) -> str:
    return f"{value:.3f}".rstrip("0").rstrip(".")


def _find_head(tip: npt.ArrayLike, tail: npt.ArrayLike, size: float) -> FloatArray:
    """Return the corners of a slim arrowhead at ``tip`` of an arrow from ``tail``, px."""
    tip, tail = np.asarray(tip), np.asarray(tail)
    back = size * (tail - tip) / np.hypot(*(tail - tip))
    aside = 0.22 * np.array([-back[1], back[0]])
    return np.array([tip, tip + back + aside, tip + back - aside])


def _plot_centres(agent: Agent, place: Placement, width: float) -> list[dict[str, Any]]:
    """Return what the template draws of the centres of gravity and buoyancy, from left to right, px."""
    marks: list[dict[str, Any]] = []
    for name, centre, radius in (("COG", agent.mass.cog, 6.0), ("COB", agent.mass.cob, 9.0)):
        label = f"{name} x = {format_signed(1000 * centre[0], 1)} mm"
        at = place.to_page(centre[None, [0, 2]])[0]
        marks.append({"name": name, "at": at, "radius": radius, "label": label})
    marks.sort(key=lambda mark: float(mark["at"][0]))
    sizes = [text_width(mark["label"], 12, bold=True) + 20 for mark in marks]
    centres = _space_labels([float(mark["at"][0]) for mark in marks], sizes, 16, width - 16)
    return [
        {**mark, "centre": centre, "left": centre - size / 2}
        for mark, centre, size in zip(marks, centres, sizes, strict=True)
    ]


def _space_labels(wanted: list[float], widths: list[float], low: float, high: float) -> list[float]:
    """Return the centres of two labels in a row, as near to ``wanted`` (ascending) as possible without overlap."""
    apart = (widths[0] + widths[1]) / 2 + 10
    lack = max(0.0, apart - (wanted[1] - wanted[0])) / 2
    first, second = wanted[0] - lack, wanted[1] + lack
    first = max(first, low + widths[0] / 2)
    second = min(max(second, first + apart), high - widths[1] / 2)
    return [min(first, second - apart), second]


def _cell_width(name: str, value: str) -> float:
    return max(text_width(name, 10), text_width(value, 12)) + 16


def _block_width(block: list[tuple[str, str]]) -> float:
    return sum(_cell_width(name, value) for name, value in block)
