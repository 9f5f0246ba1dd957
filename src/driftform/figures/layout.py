"""Text on a page: its width, shortening it, and placing labels so that they do not overlap.

All lengths are in px of the page, y downward.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from xml.etree import ElementTree as ET

import numpy as np

from driftform.figures import svg
from driftform.figures.style import INK, MUTED, SCREEN, Page
from driftform.types import FloatArray

MARGIN = 22.0
"""Width of the margins of a page, px."""

MINUS = "\u2013"
"""An en dash: as wide as a minus sign, which several common fonts lack."""

_NARROW = frozenset(" iljItfr.,:;'|!()[]-")
_BROAD = frozenset("mwMW%@")


def text_width(text: str, size: float, bold: bool = False) -> float:
    """Return an upper bound of the width of ``text`` at font size ``size``, both in px.

    The reader's font is unknown; the widths are those of DejaVu Sans, the widest of the common ones.
    """
    em = 0.0
    for letter in text:
        if letter in _NARROW:
            em += 0.41
        elif letter in _BROAD or ord(letter) >= 0x1100:
            em += 1.0
        else:
            em += 0.7 if letter.isupper() else 0.64
    return em * size * (1.1 if bold else 1.0)


def shorten(text: str, size: float, width: float, bold: bool = False) -> str:
    """Return ``text``; if it is wider than ``width`` (px), cut it and end it with an ellipsis."""
    text = " ".join(text.split())
    if text_width(text, size, bold) <= width:
        return text
    while text and text_width(text + "…", size, bold) > width:
        text = text[:-1]
    return text.rstrip() + "…"


def write(
    parent: ET.Element,
    x: float,
    y: float,
    content: str,
    size: float = 12,
    fill: str = INK,
    anchor: str = "start",
    bold: bool = False,
    halo: bool = False,
    class_: str = "",
) -> None:
    """Write ``content`` with its baseline at ``y``; a ``halo`` keeps it legible on top of lines.

    The halo is a text of its own below the other: many readers of SVG do not know ``paint-order``.
    """
    attributes: dict[str, str | float] = {
        "x": x,
        "y": y,
        "font_size": size,
        "font_weight": "600" if bold else "",
        "text_anchor": "" if anchor == "start" else anchor,
    }
    if halo:
        outline: dict[str, str | float] = {"stroke": "#ffffff", "stroke_width": 3, "stroke_linejoin": "round"}
        svg.add(parent, "text", content, class_="halo", aria_hidden="true", fill="#ffffff", **attributes, **outline)
    svg.add(parent, "text", content, class_=class_, fill=fill, **attributes)


def write_title(parent: ET.Element, x: float, base: float, title: str, size: float, width: float) -> None:
    """Write a title, bold, on the line at ``base``: smaller, then on two lines, if it is wider than ``width`` (px).

    Of a title that is longer than two small lines, the words that find no room are left out.
    """
    size, lines = fit_title(title, size, width)
    for number, line in enumerate(lines):
        write(parent, x, base - 1.2 * size * (len(lines) - 1 - number), line, size, bold=True)


def fit_title(title: str, size: float, width: float) -> tuple[float, list[str]]:
    """Return the font size of a title, at most ``size`` px, and its lines, one or two, at most ``width`` px wide."""
    lines: list[str] = []
    # Two lines need the room above the base of one.
    for count, largest, smallest in ((1, size, 0.75 * size), (2, 0.8 * size, 0.6 * size)):
        for smaller in np.arange(largest, smallest - 0.5, -1.0).tolist():
            lines = fold(" ".join(title.split()), smaller, width, bold=True)
            if len(lines) <= count:
                return smaller, lines
    return smaller, lines[:2]


def fold(text: str, size: float, width: float, bold: bool = False) -> list[str]:
    """Return the lines of a text, broken at spaces; a word that is wider than a line is divided."""
    lines = [""]
    for word in text.split(" "):
        longer = f"{lines[-1]} {word}".lstrip()
        if text_width(longer, size, bold) <= width:
            lines[-1] = longer
            continue
        lines += [""] if lines[-1] else []
        for letter in word:
            if text_width(lines[-1] + letter, size, bold) > width:
                lines.append("")
            lines[-1] += letter
    return lines


def start_page(
    height: float, title: str, subtitle: str, description: str, page: Page = SCREEN, header: float = 64.0
) -> ET.Element:
    """Return a picture as wide as its page, with a title and a subtitle; without them and the ``header``, px, on paper."""
    root = svg.start_document(page.width, height, title, description, page=page, header=header)
    if not page.is_paper:
        write_title(root, MARGIN, 36, title, 20, page.width - 2 * MARGIN)
        write(root, MARGIN, 58, subtitle, 12, MUTED)
    return root


def draw_scale_bar(
    root: ET.Element, right: float, base: float, px_per_m: float, longest: float, fill: str = INK
) -> float:
    """Draw a scale bar of a round length, at most ``longest`` px, that ends at ``right``; return its left end (px).

    Its length is written above it in the colour ``fill``.
    """
    bar = floor_to_nice_number(longest / px_per_m)
    left = right - bar * px_per_m
    ends = [(left, base - 4), (left, base), (right, base), (right, base - 4)]
    svg.add_line(root, svg.path_data(ends), INK, 1.2, "scale-bar")
    text = f"{1000 * bar:g} mm"
    write(root, (left + right) / 2, base - 6, text, 11, fill, "middle", class_="scale-bar-label")
    return left


@dataclass(frozen=True)
class Box:
    """A rectangle on the page: ``left`` and ``right``, ``top`` and ``bottom``, px."""

    left: float
    top: float
    right: float
    bottom: float


def place_labels(
    anchors: FloatArray, widths: Sequence[float], height: float, ink: FloatArray, page: Box, keep: float = 9
) -> list[Box]:
    """Return a box for each label: near its anchor, off other labels and anchors, and off ``ink`` if possible.

    Args:
        anchors: the points to label, (n, 2).
        widths: of each label.
        height: of all labels.
        ink: points on the lines that are drawn already, (m, 2), about 3 px apart.
        page: the rectangle that labels should stay in.
        keep: half the side of the square around each anchor that labels must leave free.
    """
    count = len(anchors)
    ink = ink[np.argsort(ink[:, 0], kind="stable")]
    # Left, top, right and bottom of what labels must leave free: first the labels, which begin without a place.
    taken = np.full((2 * count, 4), np.nan)
    taken[count:] = np.column_stack([anchors - keep, anchors + keep])
    # Greedy, in three rounds: the later ones let early labels make room for late ones.
    for _, index in product(range(3), range(count)):
        boxes = _list_places(anchors[index], widths[index], height, keep)
        free = taken.copy()
        free[index] = np.nan
        area = widths[index] * height
        costs = _overlap_areas(boxes, free).sum(axis=1)
        costs += 10 * (area - _overlap_areas(boxes, np.array([[page.left, page.top, page.right, page.bottom]]))[:, 0])
        best = np.inf
        for box, cost, gap in zip(boxes, costs.tolist(), np.repeat(_GAPS, len(_DIRECTIONS)), strict=True):
            # To count the ink takes most of the time, and only adds: skip a box that is too dear without it.
            if 100 * cost + gap >= best - 1e-9:
                continue
            total = 100 * cost + 12 * _count_inside(box, ink) + gap
            if total < best - 1e-9:
                best, taken[index] = total, box
    return [Box(*box) for box in taken[:count].tolist()]


def _list_places(anchor: FloatArray, width: float, height: float, keep: float) -> FloatArray:
    """Return the boxes that a label may take: left, top, right, bottom, in the order of preference, (n, 4)."""
    gaps, directions = np.repeat(_GAPS, len(_DIRECTIONS)), np.tile(_DIRECTIONS, (len(_GAPS), 1))
    half = np.array([width, height]) / 2
    centre = anchor + directions * (keep + gaps[:, None] + half)
    return np.column_stack([centre - half, centre + half])


def _overlap_areas(boxes: FloatArray, others: FloatArray) -> FloatArray:
    """Return the areas that boxes (n, 4) share with others (m, 4), px2, (n, m); 0 with one that is NaN."""
    low = np.maximum(boxes[:, None, :2], others[None, :, :2])
    high = np.minimum(boxes[:, None, 2:], others[None, :, 2:])
    return np.asarray(np.nan_to_num(np.maximum(high - low, 0.0).prod(axis=2)), dtype=np.float64)


def _count_inside(box: FloatArray, points: FloatArray) -> int:
    """Return the number of ``points``, (n, 2) in the order of x, that lie inside a box (4,)."""
    first, last = (np.searchsorted(points[:, 0], box[0], "right"), np.searchsorted(points[:, 0], box[2], "left"))
    y = points[first:last, 1]
    return int(np.count_nonzero((y > box[1]) & (y < box[3])))


_GAPS = (1, 7, 14, 24)
"""Distances of a label from the square around its anchor, px."""

# To the right and above first, where readers look for a name.
_DIRECTIONS = ((1, 0), (0, -1), (0, 1), (-1, 0), (0.8, -0.9), (0.8, 0.9), (-0.8, -0.9), (-0.8, 0.9))


def resample_polyline(points: FloatArray, spacing: float) -> FloatArray:
    """Return points along a polyline, (n, d), about ``spacing`` apart, both ends included."""
    if len(points) < 2:
        return points
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    at = np.linspace(0, s[-1], max(2, int(s[-1] / spacing) + 1))
    return np.column_stack([np.interp(at, s, column) for column in points.T])


def floor_to_nice_number(value: float) -> float:
    """Return the greatest number at most ``value`` (positive) that is 1, 2 or 5 times a power of ten."""
    power = 10.0 ** np.floor(np.log10(value) + 1e-9)
    return float(max(step * power for step in (1, 2, 5) if step * power <= value * (1 + 1e-9)))


def tick_values(low: float, high: float, step: float) -> FloatArray:
    """Return the multiples of ``step`` from ``low`` to ``high``."""
    first, last = np.ceil(low / step - 1e-6), np.floor(high / step + 1e-6)
    # The sum makes -0 a 0.
    return np.asarray(np.arange(first, last + 1) * step + 0.0, dtype=np.float64)


def label_ticks(values: FloatArray, step: float) -> list[str]:
    """Return the texts of values that are multiples of a step, all with the digits that this has."""
    return [format_signed(value, max(0, -int(np.floor(np.log10(step) + 1e-9)))) for value in values]


def format_signed(value: float, digits: int) -> str:
    """Return a number with ``digits`` decimals and :data:`MINUS`, and zero without a sign."""
    text = f"{value:.{digits}f}"
    return (text.lstrip("-") if float(text) == 0 else text).replace("-", MINUS)
