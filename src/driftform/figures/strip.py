"""Misses under disturbed conditions, a strip for each target: the robustness of a result."""

from collections.abc import Sequence
from dataclasses import dataclass
from xml.etree import ElementTree as ET

import numpy as np

from driftform.figures import svg
from driftform.figures.layout import MARGIN, WIDTH, shorten, start_page, write
from driftform.figures.style import BLUE, GRID, INK, MUTED, VERMILLION, tint
from driftform.types import FloatArray

LEFT, RIGHT, TOP, ROW = 110.0, 110.0, 112.0, 30.0
SMALLEST = 1e-4
"""Smallest miss (m) that is drawn: a logarithmic axis has no zero."""


@dataclass(frozen=True, eq=False)
class Strip:
    """Misses (m) of the best agent for one target.

    Attributes
    ----------
    name
        of the target.
    nominal
        of the undisturbed flight.
    misses
        of the disturbed flights, (n,); infinite for failed ones, which are not drawn.
    promised
        that 9 of 10 disturbed flights stay within.
    """

    name: str
    nominal: float
    misses: FloatArray
    promised: float


def strip_svg(strips: Sequence[Strip], title: str, subtitle: str) -> str:
    """Return the misses as SVG: a dot for each disturbed flight, a line at the 90 % miss, a diamond for the nominal one."""
    height = TOP + ROW * len(strips) + 52
    root = start_page(height, title, subtitle, f"{subtitle} A row of dots for each target, misses in mm.")
    values = np.concatenate([np.zeros(0), *(np.append(s.misses, s.nominal) for s in strips)])
    values = values[np.isfinite(values)]
    shown = np.maximum(values, SMALLEST)
    low = np.floor(np.log10(shown.min(initial=0.1)))
    high = max(np.ceil(np.log10(shown.max(initial=0.1))), low + 1)
    bottom = TOP + ROW * len(strips)

    def x_of(miss: float) -> float:
        share = (np.log10(max(miss, SMALLEST)) - low) / (high - low)
        return float(LEFT + share * (WIDTH - LEFT - RIGHT))

    for power in np.arange(low, high + 1):
        x = x_of(10.0**power)
        svg.add_segment(root, x, TOP - 10, x, bottom, GRID)
        write(root, x, bottom + 16, f"{1000 * 10.0**power:g}", 11, MUTED, "middle")
    write(root, WIDTH - RIGHT, bottom + 34, "miss (mm)", 11, MUTED, "end")
    write(root, WIDTH - MARGIN, TOP - 18, "90 %", 11, MUTED, "end")
    for number, strip in enumerate(strips):
        y = TOP + ROW * (number + 0.5)
        write(
            root, LEFT - 14, y + 4, shorten(strip.name, 12, LEFT - 30, bold=True), 12, INK, "end", bold=True
        )
        svg.add_segment(root, LEFT, y, WIDTH - RIGHT, y, GRID)
        for miss in strip.misses[np.isfinite(strip.misses)].tolist():
            _draw_dot(root, x_of(miss), y, class_="disturbed")
        if np.isfinite(strip.promised):
            x = x_of(strip.promised)
            svg.add_segment(root, x, y - 9, x, y + 9, INK, 2, class_="promised")
        _draw_diamond(root, x_of(strip.nominal), y, class_="nominal")
        text = f"{1000 * strip.promised:.0f} mm" if np.isfinite(strip.promised) else "unknown"
        write(root, WIDTH - MARGIN, y + 4, text, 12, INK, "end")
    _draw_legend(root, 80.0)
    return svg.render(root)


def _draw_legend(root: ET.Element, y: float) -> None:
    x = MARGIN + 6
    _draw_diamond(root, x, y - 4)
    write(root, x + 14, y, "nominal", 12, INK)
    x = MARGIN + 150
    _draw_dot(root, x, y - 4)
    write(root, x + 14, y, "disturbed", 12, INK)
    x = MARGIN + 300
    svg.add_segment(root, x, y - 13, x, y + 5, INK, 2)
    write(root, x + 14, y, "9 of 10 stay within", 12, INK)


def _draw_dot(root: ET.Element, x: float, y: float, **class_: str) -> None:
    svg.add_circle(root, x, y, 4, tint(BLUE, 0.6), BLUE, 0.6, **class_)


def _draw_diamond(root: ET.Element, x: float, y: float, **class_: str) -> None:
    data = svg.path_data([(x, y - 6), (x + 6, y), (x, y + 6), (x - 6, y)], closed=True)
    svg.add(root, "path", **class_, d=data, fill="#ffffff", stroke=VERMILLION, stroke_width=2)
