"""The assembly sheet as pictures: two A4 pages in SVG; the drawings of the first have the scales that it states."""

from collections.abc import Sequence
from dataclasses import dataclass
from xml.etree import ElementTree as ET

import numpy as np

from driftform.figures import layout, style, svg
from driftform.types import FloatArray
from driftform_frusta.colours import colour_of
from driftform_kit.cutting.meridian import Ring
from driftform_kit.sheet.contents import Sheet, SheetPart
from driftform_kit.sheet.scenes import BALLAST, CORE, draw_mark, draw_scene

_WIDTH, _HEIGHT = 210 * svg.PX_PER_MM, 297 * svg.PX_PER_MM
_LEFT, _RIGHT = 48.0, _WIDTH - 48.0
_BOTTOM = _HEIGHT - 48.0
_TEXT = 11.0
"""Font size, px: 8 pt."""

_LINE = 15.0
"""Distance of lines, px."""

_SCALES = (2.0, 1.0, 1 / 1.5, 1 / 2, 1 / 2.5, 1 / 3, 1 / 4, 1 / 5, 1 / 10, 1 / 20, 1 / 50, 1 / 100)
"""Paper to body: those of ISO 5455, and some between them."""

_TALLEST = 130.0
"""Room for the closed kit across its axis, px."""

_ACROSS = 7
"""Parts side by side."""

_LABEL = 62.0
"""Room for the lines below a part, px."""

_COLUMN = 275.0
"""Width of the table of weights, px."""

_SCENE = 150.0
"""Width of the drawing of a step, px."""

_SCENES = (92.0, 76.0, 64.0, 52.0, 40.0)
"""Heights of the drawing of a step with its margin, px: the first with which all steps have room."""

_GAP = 26.0


def draw_pages(sheet: Sheet) -> tuple[str, str]:
    """Return an assembly sheet: what to get, the closed kit, its parts as printed and their weights; and the steps."""
    count = len(sheet.parts)
    about = f"The {count} parts of a kit to scale, what to get for it, what its parts weigh, and how to print them."
    first = _start_page(sheet, "assembly sheet, page 1 of 2", f"{about} {sheet.remedy}")
    what = (
        f"{count} printed parts and a core ({sheet.core}). All positions are distances from the aft end, mm."
    )
    layout.write(first, _LEFT, 76, layout.shorten(what, _TEXT, _RIGHT - _LEFT), _TEXT, style.MUTED)
    bottom = _draw_closed(first, sheet, _draw_shopping(first, sheet, 96.0) + 24)
    # The tables are drawn twice: the first time on no page, to see how much room they leave.
    tables = _BOTTOM - max(draw(ET.Element("svg"), sheet, 0.0) for draw in (_draw_weights, _draw_settings))
    _draw_parts(first, _arrange_parts(sheet, tables - bottom - 60), bottom + 30)
    _draw_weights(first, sheet, tables)
    _draw_settings(first, sheet, tables)
    second = _start_page(sheet, "order of assembly, page 2 of 2", " ".join(sheet.steps))
    _draw_steps(second, sheet, 76.0)
    return svg.render(first), svg.render(second)


def _start_page(sheet: Sheet, what: str, about: str) -> ET.Element:
    title = f"{sheet.title}: {what}"
    root = svg.start_document(_WIDTH, _HEIGHT, title, about, unit="mm")
    layout.write(root, _LEFT, 56, layout.shorten(title, 20, _RIGHT - _LEFT, bold=True), 20, bold=True)
    return root


def _draw_shopping(root: ET.Element, sheet: Sheet, top: float) -> float:
    """Draw the box with what to get; return where it ends."""
    svg.add(root, "rect", "", x=_LEFT, y=top, width=_RIGHT - _LEFT, height=0, fill="none", class_="box")
    box = root[-1]
    _draw_heading(root, _LEFT + 10, top + 18, "To get")
    y = top + 36
    for name, text in sheet.shopping:
        layout.write(root, _LEFT + 10, y, name, _TEXT, bold=True)
        y = _write_paragraph(root, _LEFT + 80, y, text, _RIGHT - _LEFT - 90)
    box.set("height", svg.format_number(y - top - 6))
    box.set("stroke", style.MUTED)
    return y - 6


def _choose_scale(sizes: Sequence[tuple[float, float]], room: tuple[float, float]) -> tuple[float, str]:
    """The largest scale at which sizes (mm), side by side with gaps, fit into the room (px): px for each mm, and its name."""
    for ratio in _SCALES:
        scale = svg.PX_PER_MM * ratio
        across = scale * sum(width for width, _ in sizes) + _GAP * (len(sizes) - 1)
        if across <= room[0] and scale * max(height for _, height in sizes) <= room[1]:
            break
    return scale, f"{max(ratio, 1):g} : {max(1 / ratio, 1):g}"


def _draw_closed(root: ET.Element, sheet: Sheet, top: float) -> float:
    """Draw the section of the closed kit with the marks of parts and ballast; return where the drawing ends."""
    skin = sheet.kit.hull.skin
    length, radius = float(np.ptp(skin[:, 0])), float(skin[:, 1].max())
    scale, name = _choose_scale([(length, 2 * radius)], (_RIGHT - _LEFT - 40, _TALLEST))
    start = (_LEFT + _RIGHT - scale * length) / 2
    axis = top + 44 + scale * radius
    x_of = start - scale * sheet.aft

    def place(ring: Ring, side: float) -> FloatArray:
        return np.column_stack((x_of + scale * ring[:, 1], axis - side * scale * ring[:, 0]))

    heading = f"Closed kit, cut along the axis, scale {name}; fore on the right"
    _draw_heading(root, _LEFT, top + 4, heading)
    for part in sheet.parts:
        for side in (1.0, -1.0):
            _draw_section(root, [place(ring, side) for ring in part.piece.rings], part.place)
    balls = [("core", 0.0, sheet.kit.hull.core, CORE)]
    balls += [("ballast", ball.held.ball.z, ball.held.ball.radius, BALLAST) for ball in sheet.balls]
    for kind, z, radius_mm, fill in balls:
        svg.add_circle(root, x_of + scale * z, axis, scale * radius_mm, fill, style.INK, 0.8, class_=kind)
    line = svg.path_data([(start - 12, axis), (start + scale * length + 12, axis)])
    svg.add_line(root, line, style.INK, 0.6, "axis", stroke_dasharray="12 3 2 3")
    bounds = sheet.bounds
    marks = [
        (x_of + scale * ball.held.ball.z, axis - scale * ball.held.ball.radius, ball.mark, style.INK)
        for ball in sheet.balls
    ]
    for part in sheet.parts:
        middle = (bounds[part.place] + bounds[part.place + 1]) / 2
        on_skin = axis - scale * sheet.kit.hull.skin_radius(middle)
        marks.append((x_of + scale * middle, on_skin, str(part.number), colour_of(part.place)))
    last = -np.inf
    for x, y, mark, colour in sorted(marks):
        last = max(x, last + 22)
        svg.add_line(root, svg.path_data([(last, top + 32), (x, y)]), style.MUTED, 0.7)
        draw_mark(root, last, top + 24, mark, colour)
    level = axis + scale * radius + 16
    _draw_stations(root, [z - sheet.aft for z in bounds], start, scale, level)
    balance = start + scale * (1e3 * float(sheet.target.cog[0]) - sheet.aft)
    triangle = [(balance, level + 28), (balance - 5, level + 37), (balance + 5, level + 37)]
    svg.add(root, "path", class_="balance", d=svg.path_data(triangle, closed=True), fill=style.INK)
    text = f"balances at {1e3 * float(sheet.target.cog[0]) - sheet.aft:.1f} mm, as simulated"
    room = layout.text_width(text, _TEXT) + 10
    anchor, at = ("start", balance + 9) if balance + room < _RIGHT else ("end", balance - 9)
    layout.write(root, at, level + 37, text, _TEXT, anchor=anchor)
    return level + 44


def _draw_stations(root: ET.Element, stations: list[float], start: float, scale: float, level: float) -> None:
    """Draw the distances of joints and ends from the aft end, mm, below a line."""
    ends = [(start, level), (start + scale * stations[-1], level)]
    ticks = "".join(
        svg.path_data([(start + scale * s, level - 4), (start + scale * s, level + 4)]) for s in stations
    )
    svg.add_line(root, svg.path_data(ends) + ticks, style.MUTED, 0.8, "stations")
    last = -np.inf
    for station in stations:
        text = f"{station:.1f}"
        x = max(start + scale * station, last + layout.text_width(text, 10) + 2)
        layout.write(root, x, level + 16, text, 10, style.MUTED, "middle", class_="station")
        last = x


@dataclass(frozen=True, eq=False)
class _Rows:
    """Parts in rows of some height, px, at a scale, px for each mm, of some name."""

    parts: Sequence[Sequence[SheetPart]]
    height: float
    scale: float
    name: str


def _arrange_parts(sheet: Sheet, room: float) -> _Rows:
    """Arrange the parts in the order of assembly, at the largest scale that fits into a height of ``room`` px."""
    rows = [sheet.parts[i : i + _ACROSS] for i in range(0, len(sheet.parts), _ACROSS)]
    height = (room - 18) / len(rows)
    choices = [
        _choose_scale(
            [(max(part.size[0], 1e-3), part.size[1]) for part in row], (_RIGHT - _LEFT, height - _LABEL - 8)
        )
        for row in rows
    ]
    return _Rows(rows, height, *min(choices))


def _draw_parts(root: ET.Element, rows: _Rows, top: float) -> None:
    """Draw the sections of the parts as they are printed."""
    _draw_heading(root, _LEFT, top + 4, f"Parts as printed, cut along the axis, scale {rows.name}")
    layout.draw_scale_bar(root, _RIGHT, top + 6, 1000 * rows.scale, 90)
    for index, row in enumerate(rows.parts):
        bed = top + 18 + rows.height * (index + 1) - _LABEL
        width = (_RIGHT - _LEFT) / max(len(row), 2)
        for column, part in enumerate(row):
            _draw_part(root, part, _LEFT + width * (column + 0.5), bed, rows.scale, width)


def _draw_part(
    root: ET.Element, part: SheetPart, middle: float, bed: float, scale: float, width: float
) -> None:
    for side in (1.0, -1.0):
        rings = [
            np.column_stack((middle + side * scale * ring[:, 0], bed - scale * ring[:, 1]))
            for ring in part.printed
        ]
        _draw_section(root, rings, part.place)
    diameter, height = part.size
    half = max(scale * diameter / 2 + 8, 30.0)
    svg.add_line(root, svg.path_data([(middle - half, bed), (middle + half, bed)]), style.INK, 1.4, "bed")
    lines = [
        f"Ø {diameter:.1f} x {height:.1f} mm",
        f"{part.piece.bed_end} end down{', engraved' if part.piece.engraved is not None else ''}",
    ]
    name = layout.shorten(part.piece.name, _TEXT, width - 20, bold=True)
    left = middle - layout.text_width(name, _TEXT, bold=True) / 2
    draw_mark(root, left - 2, bed + 15, str(part.number), colour_of(part.place))
    layout.write(root, left + 11, bed + 19, name, _TEXT, bold=True)
    for row, line in enumerate(lines):
        layout.write(root, middle, bed + 34 + 13 * row, line, 10, style.MUTED, "middle")


def _draw_section(root: ET.Element, rings: Sequence[FloatArray], place: int) -> None:
    data = "".join(svg.path_data(ring, closed=True) for ring in rings)
    svg.add(
        root, "path", class_="part", d=data, fill=style.tint(colour_of(place), 0.45), fill_rule="evenodd", stroke=style.INK,
        stroke_width=0.6, stroke_linejoin="round",
    )  # fmt: skip


def _draw_heading(root: ET.Element, x: float, y: float, text: str) -> None:
    layout.write(root, x, y, text, 13, bold=True, class_="heading")


def _draw_weights(root: ET.Element, sheet: Sheet, top: float) -> float:
    """Draw the table of weights with room to write; return where it ends."""
    right = _LEFT + _COLUMN
    columns = {right - 136: "full flow", right - 66: f"{100 * sheet.flow:.1f} % flow"}
    if sheet.flow == 1:
        columns = {right - 66: "full flow"}
    _draw_heading(root, _LEFT, top, "Weights, g")
    for x, heading in {**columns, right - 8: "weighed"}.items():
        layout.write(root, x, top, heading, 10, style.MUTED, "end")
    y = top + 8
    lines = []
    for name, *masses in sheet.weights:
        lines.append(svg.path_data([(_LEFT, y), (right, y)]))
        bold = name in ("closed kit", "as simulated")
        room = min(columns) - _LEFT - layout.text_width("000.00 ", _TEXT, bold=True)
        layout.write(root, _LEFT + 2, y + 14, layout.shorten(name, _TEXT, room, bold=bold), _TEXT, bold=bold)
        for x, mass in zip(reversed(columns), reversed(masses), strict=False):
            layout.write(root, x, y + 14, f"{1000 * mass:.2f}", _TEXT, anchor="end", bold=bold, class_="mass")
        y += 20
    lines += [
        svg.path_data([(_LEFT, y), (right, y)]),
        svg.path_data([(right - 56, top + 8), (right - 56, y)]),
    ]
    svg.add_line(root, "".join(lines), style.MUTED, 0.6, "table")
    return y


def _draw_settings(root: ET.Element, sheet: Sheet, top: float) -> float:
    """Draw the print settings, and what makes the kit weigh what was simulated; return where they end."""
    left = _LEFT + _COLUMN + 30
    _draw_heading(root, left, top, "Print settings")
    y = top + 20
    for name, value in sheet.settings:
        layout.write(root, left, y, name, _TEXT)
        layout.write(root, _RIGHT, y, value, _TEXT, anchor="end", class_="setting")
        y += _LINE
    for text in (sheet.remedy, "Glue, O-rings and plugs are not counted."):
        y = _write_paragraph(root, left, y + 5, text, _RIGHT - left)
    return y - _LINE


def _draw_steps(root: ET.Element, sheet: Sheet, top: float) -> None:
    """Draw the order of assembly: each step with its picture."""
    left, room = _LEFT + _SCENE + 24, _BOTTOM - top
    texts = [wrap(text, _TEXT, _RIGHT - left - 24) for text in sheet.steps]
    for height in _SCENES:
        heights = [max(height, _LINE * len(lines) + 12) for lines in texts]
        if sum(heights) <= room:
            break
    y = top
    for number, (scene, lines, height) in enumerate(zip(sheet.scenes, texts, heights, strict=True), 1):
        corners = np.array([[_LEFT + 8, y + 8], [_LEFT + 8 + _SCENE, y + height - 8]])
        draw_scene(root, sheet, scene, corners)
        base = y + (height - _LINE * (len(lines) - 1)) / 2 + 4
        layout.write(root, left, base, f"{number}.", _TEXT, bold=True)
        for line in lines:
            layout.write(root, left + 24, base, line, _TEXT)
            base += _LINE
        y += height
        svg.add_line(root, svg.path_data([(_LEFT, y), (_RIGHT, y)]), style.GRID, 1, "rule")


def _write_paragraph(root: ET.Element, x: float, y: float, text: str, width: float) -> float:
    """Write a text in lines of at most ``width`` px; return where the next line begins."""
    for line in wrap(text, _TEXT, width):
        layout.write(root, x, y, line, _TEXT)
        y += _LINE
    return y


def wrap(text: str, size: float, width: float) -> list[str]:
    """Return a text as lines that are no wider than ``width`` px, broken between words."""
    lines = [""]
    for word in text.split(" "):
        longer = f"{lines[-1]} {word}".strip()
        if layout.text_width(longer, size) <= width or not lines[-1]:
            lines[-1] = longer
        else:
            lines.append(word)
    return lines
