"""The assembly sheet as pictures: two A4 pages in SVG; the drawings of the first have the scales that it states."""

from collections.abc import Sequence
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np

from driftform.figures import layout, style, svg
from driftform.types import FloatArray
from driftform_frusta.colours import colour_of
from driftform_kit.cutting.meridian import Ring
from driftform_kit.sheet.contents import Sheet, SheetPart
from driftform_kit.sheet.scenes import BALLAST, CORE, place_scene

_WIDTH, _HEIGHT = 210 * style.PX_PER_MM, 297 * style.PX_PER_MM
_LEFT, _RIGHT, _BOTTOM = 48.0, _WIDTH - 48.0, _HEIGHT - 48.0
_TEXT, _LINE = 11.0, 15.0
"""Font size and distance of lines, px: 8 pt."""

_SCALES = (2.0, 1.0, 1 / 1.5, 1 / 2, 1 / 2.5, 1 / 3, 1 / 4, 1 / 5, 1 / 10, 1 / 20, 1 / 50, 1 / 100)
"""Paper to body: those of ISO 5455, and some between them."""

_TALLEST = 130.0
"""Room for the closed kit across its axis, px."""

_ACROSS, _GAP, _LABEL = 7, 26.0, 62.0
"""Parts side by side, the least gap between them, and room for the lines below them, px."""

_COLUMN = 275.0
"""Width of the table of weights, px."""

_SCENE, _SCENES = 150.0, (92.0, 76.0, 64.0, 52.0, 40.0)
"""Width of the drawing of a step, and its heights with a margin, px: the first with which all steps have room is taken."""


def draw_pages(sheet: Sheet) -> tuple[str, str]:
    """Return an assembly sheet: what to get, the closed kit, its parts as printed and their weights; and the steps."""
    count = len(sheet.parts)
    about = f"The {count} parts of a kit to scale, what to get for it, what its parts weigh, and how to print them."
    what = f"{count} printed parts and a core ({sheet.core}). All positions are distances from the aft end, mm."
    shopping, y = list[tuple[str, float, list[str]]](), 132.0
    for name, text in sheet.shopping:
        shopping.append((name, y, layout.fold(text, _TEXT, _RIGHT - _LEFT - 90)))
        y += _LINE * len(shopping[-1][2])
    closed = _place_closed(sheet, y + 22)
    wide = _RIGHT - _LEFT - _COLUMN - 30
    remedy = [*layout.fold(sheet.remedy, _TEXT, wide), "Glue is not counted."]
    tables = max(20.0 * len(sheet.weights), _LINE * (len(sheet.settings) + len(remedy)) + 10)
    top, first = _BOTTOM - tables - 8, closed["level"] + 74
    parts, scale, name = _place_parts(sheet, first, top - first - 30)
    table = {"left": _LEFT, "right": _RIGHT, "column": _COLUMN, "top": top, "remedy": remedy}
    table |= _list_weights(sheet)
    kit = {"closed": closed, "parts": parts, "parts_scale": name, "settings": sheet.settings}
    head = {"what": layout.shorten(what, _TEXT, _RIGHT - _LEFT), "shopping": shopping, "box": y - 102}
    page = _start_page(sheet, "assembly sheet, page 1 of 2", f"{about} {sheet.remedy}")
    svg.draw_template(page, __package__, "page-1", **head, **kit, **table)
    layout.draw_scale_bar(page, _RIGHT, first + 6, 1000 * scale, 90)
    steps = _start_page(sheet, "order of assembly, page 2 of 2", " ".join(sheet.steps))
    svg.draw_template(steps, __package__, "page-2", **_place_steps(sheet, 76.0))
    return svg.render(page), svg.render(steps)


def _start_page(sheet: Sheet, what: str, about: str) -> ET.Element:
    title = f"{sheet.title}: {what}"
    root = svg.start_document(_WIDTH, _HEIGHT, title, about, unit="mm")
    layout.write(root, _LEFT, 56, layout.shorten(title, 20, _RIGHT - _LEFT, bold=True), 20, bold=True)
    return root


def _choose_scale(sizes: Sequence[tuple[float, float]], room: tuple[float, float]) -> tuple[float, str]:
    """The largest scale at which sizes (mm), side by side with gaps, fit into the room (px): px for each mm, and its name."""
    for ratio in _SCALES:
        scale = style.PX_PER_MM * ratio
        across = scale * sum(width for width, _ in sizes) + _GAP * (len(sizes) - 1)
        if across <= room[0] and scale * max(height for _, height in sizes) <= room[1]:
            break
    return scale, f"{max(ratio, 1):g} : {max(1 / ratio, 1):g}"


def _trace(rings: Sequence[FloatArray]) -> str:
    return "".join(svg.path_data(ring, closed=True) for ring in rings)


def _place_closed(sheet: Sheet, top: float) -> dict[str, Any]:
    """Place the section of the closed kit, with the marks of parts and ballast, below a heading; its ``level`` ends it."""
    skin, hull = sheet.kit.hull.skin, sheet.kit.hull
    length = float(np.ptp(skin[:, 0]))
    scale, name = _choose_scale([(length, 2 * hull.widest)], (_RIGHT - _LEFT - 40, _TALLEST))
    start = (_LEFT + _RIGHT - scale * length) / 2
    axis, x_of = top + 40 + scale * hull.widest, start - scale * sheet.aft

    def place(rings: Sequence[Ring]) -> list[FloatArray]:
        return [
            np.column_stack((x_of + scale * ring[:, 1], axis - side * scale * ring[:, 0]))
            for side in (1.0, -1.0)
            for ring in rings
        ]

    bounds, balance = sheet.bounds, start + scale * (1e3 * float(sheet.target.cog[0]) - sheet.aft)
    anchors = [
        (x_of + scale * b.held.ball.z, axis - scale * b.held.ball.radius, b.mark, style.INK) for b in sheet.balls
    ]
    for part in sheet.parts:
        middle = (bounds[part.place] + bounds[part.place + 1]) / 2
        at = x_of + scale * middle, axis - scale * hull.skin_radius(middle)
        anchors.append((*at, str(part.number), colour_of(part.place)))
    marks, last = [], -np.inf
    for x, *rest in sorted(anchors):
        last = max(x, last + 22)
        marks.append((last, x, *rest))
    stations, last = [], -np.inf
    for z in bounds:
        x, label = x_of + scale * z, f"{z - sheet.aft:.1f}"
        last = max(x, last + layout.text_width(label, 10) + 2)
        stations.append((x, last, label))
    balances = f"balances at {1e3 * float(sheet.target.cog[0]) - sheet.aft:.1f} mm, as simulated"
    return {
        "top": top,
        "scale": name,
        "start": start,
        "end": start + scale * length,
        "axis": axis,
        "parts": [{"data": _trace(place(p.piece.rings)), "colour": colour_of(p.place)} for p in sheet.parts],
        "core": None if hull.capsule is None else _trace(place([hull.capsule[:, ::-1]])),
        "core_fill": CORE,
        "putty": _trace(place(sheet.putty)),
        "putty_fill": BALLAST,
        "balls": [
            *([("core", x_of, scale * hull.core, CORE)] if hull.capsule is None else []),
            *(("ballast", x_of + scale * b.held.ball.z, scale * b.held.ball.radius, BALLAST) for b in sheet.balls),
        ],
        "marks": marks,
        "stations": stations,
        "level": axis + scale * hull.widest + 16,
        "balance": balance,
        "balances": balances,
        "room": balance + layout.text_width(balances, _TEXT) + 10 < _RIGHT,
    }


def _place_parts(sheet: Sheet, top: float, room: float) -> tuple[list[dict[str, Any]], float, str]:
    """Place the sections of the parts as they are printed, at the largest scale that fits into a height, and return that."""
    rows = [sheet.parts[i : i + _ACROSS] for i in range(0, len(sheet.parts), _ACROSS)]
    height = (room - 18) / len(rows)
    space = _RIGHT - _LEFT, height - _LABEL - 8
    scale, name = min(_choose_scale([(max(p.size[0], 1e-3), p.size[1]) for p in row], space) for row in rows)
    placed = []
    for index, row in enumerate(rows):
        width = (_RIGHT - _LEFT) / max(len(row), 2)
        bed = top + 18 + height * (index + 1) - _LABEL
        for column, part in enumerate(row):
            placed.append(_place_part(part, _LEFT + width * (column + 0.5), bed, scale, width))
    return placed, scale, name


def _place_part(part: SheetPart, x: float, bed: float, scale: float, width: float) -> dict[str, Any]:
    rings = [(x, bed) + scale * ring * (side, -1.0) for ring in part.printed for side in (1.0, -1.0)]
    name = layout.shorten(part.piece.name, _TEXT, width - 20, bold=True)
    return {
        "data": _trace(rings),
        "colour": colour_of(part.place),
        "x": x,
        "bed": bed,
        "half": max(scale * part.size[0] / 2 + 8, 30.0),
        "number": str(part.number),
        "name": name,
        "wide": layout.text_width(name, _TEXT, bold=True),
        "size": f"Ø {part.size[0]:.1f} x {part.size[1]:.1f} mm",
        "placed": f"{part.piece.bed_end} end down",
    }


def _list_weights(sheet: Sheet) -> dict[str, Any]:
    right = _LEFT + _COLUMN
    columns = {right - 136: "full flow", right - 66: f"{100 * sheet.flow:.1f} % flow"}
    if sheet.flow == 1:
        columns = {right - 66: "full flow"}
    room, rows = min(columns) - _LEFT - layout.text_width("000.00 ", _TEXT, bold=True), []
    for name, *masses in sheet.weights:
        bold = name in ("closed kit", "as simulated")
        cells = [(x, f"{1000 * m:.2f}") for x, m in zip(reversed(columns), reversed(masses), strict=False)]
        rows.append((layout.shorten(name, _TEXT, room, bold=bold), bold, cells))
    return {"columns": [*columns.items(), (right - 8, "weighed")], "weights": rows}


def _place_steps(sheet: Sheet, top: float) -> dict[str, Any]:
    left = _LEFT + _SCENE + 24
    texts = [layout.fold(text, _TEXT, _RIGHT - left - 24) for text in sheet.steps]
    for height in _SCENES:
        heights = [max(height, _LINE * len(rows) + 12) for rows in texts]
        if sum(heights) <= _BOTTOM - top:
            break
    ends = top + np.cumsum(heights)
    steps = [
        {
            "shapes": place_scene(
                sheet, scene, np.array([[_LEFT + 8, end - height + 8], [_LEFT + 8 + _SCENE, end - 8]])
            ),
            "base": end - (height + _LINE * (len(rows) - 1)) / 2 + 4,
            "rows": rows,
            "end": end,
        }
        for scene, rows, height, end in zip(sheet.scenes, texts, heights, ends.tolist(), strict=True)
    ]
    return {"steps": steps, "left": left, "right": _RIGHT, "edge": _LEFT}
