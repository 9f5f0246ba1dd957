"""Errors under disturbed conditions, a strip for each target: the robustness of a result."""

from collections.abc import Sequence
from dataclasses import dataclass
from xml.etree import ElementTree as ET

import numpy as np

from driftform.figures import svg
from driftform.figures.layout import MARGIN, WIDTH, shorten, start_page, write
from driftform.figures.style import BLUE, GRID, INK, MUTED, VERMILLION, tint
from driftform.types import FloatArray

LEFT, RIGHT, TOP, ROW = 110.0, 110.0, 112.0, 30.0
SMALLEST = 1e-3
"""Smallest error (%) that is drawn: a logarithmic axis has no zero."""


@dataclass(frozen=True, eq=False)
class Strip:
    """Errors (%) of the best agent for one target: of the undisturbed flight, and of the disturbed ones, (n,)."""

    name: str
    planned: float
    errors: FloatArray


def strip_svg(strips: Sequence[Strip], title: str, subtitle: str, label: str = "error %") -> str:
    """Return the errors as SVG: a dot for each disturbed flight, a line at their mean, a diamond for the undisturbed one."""
    height = TOP + ROW * len(strips) + 52
    root = start_page(
        height, title, subtitle, f"{subtitle} A row of dots for each target, errors in percent."
    )
    values = np.concatenate([np.zeros(0), *(np.append(s.errors, s.planned) for s in strips)])
    shown = np.maximum(values, SMALLEST)
    low = np.floor(np.log10(shown.min(initial=1.0)))
    high = max(np.ceil(np.log10(shown.max(initial=1.0))), low + 1)
    bottom = TOP + ROW * len(strips)

    def x_of(error: float) -> float:
        share = (np.log10(max(error, SMALLEST)) - low) / (high - low)
        return float(LEFT + share * (WIDTH - LEFT - RIGHT))

    for power in np.arange(low, high + 1):
        x = x_of(10.0**power)
        svg.add(root, "line", x1=x, y1=TOP - 10, x2=x, y2=bottom, stroke=GRID)
        write(root, x, bottom + 16, f"{10.0**power:g}", 11, MUTED, "middle")
    write(root, WIDTH - RIGHT, bottom + 34, label, 11, MUTED, "end")
    write(root, WIDTH - MARGIN, TOP - 18, "mean", 11, MUTED, "end")
    for number, strip in enumerate(strips):
        y = TOP + ROW * (number + 0.5)
        write(
            root, LEFT - 14, y + 4, shorten(strip.name, 12, LEFT - 30, bold=True), 12, INK, "end", bold=True
        )
        svg.add(root, "line", x1=LEFT, y1=y, x2=WIDTH - RIGHT, y2=y, stroke=GRID)
        for error in strip.errors:
            _draw_dot(root, x_of(float(error)), y, class_="disturbed")
        mean = float(strip.errors.mean()) if len(strip.errors) else strip.planned
        x = x_of(mean)
        svg.add(root, "line", class_="mean", x1=x, y1=y - 9, x2=x, y2=y + 9, stroke=INK, stroke_width=2)
        _draw_diamond(root, x_of(strip.planned), y, class_="planned")
        write(root, WIDTH - MARGIN, y + 4, f"{mean:.2f} %", 12, INK, "end")
    _draw_legend(root, 80.0)
    return svg.render(root)


def _draw_legend(root: ET.Element, y: float) -> None:
    x = MARGIN + 6
    _draw_diamond(root, x, y - 4)
    write(root, x + 14, y, "planned", 12, INK)
    x = MARGIN + 150
    _draw_dot(root, x, y - 4)
    write(root, x + 14, y, "disturbed", 12, INK)
    x = MARGIN + 300
    svg.add(root, "line", x1=x, y1=y - 13, x2=x, y2=y + 5, stroke=INK, stroke_width=2)
    write(root, x + 14, y, "mean of the disturbed", 12, INK)


def _draw_dot(root: ET.Element, x: float, y: float, **class_: str) -> None:
    svg.add(root, "circle", **class_, cx=x, cy=y, r=4, fill=tint(BLUE, 0.6), stroke=BLUE, stroke_width=0.6)


def _draw_diamond(root: ET.Element, x: float, y: float, **class_: str) -> None:
    data = svg.path_data([(x, y - 6), (x + 6, y), (x, y + 6), (x - 6, y)], closed=True)
    svg.add(root, "path", **class_, d=data, fill="#ffffff", stroke=VERMILLION, stroke_width=2)
