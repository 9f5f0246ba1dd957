"""Best fitness against the number of flights, a panel for each target."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil
from xml.etree import ElementTree as ET

import numpy as np

from driftform.figures import svg
from driftform.figures.layout import (
    MARGIN,
    WIDTH,
    Box,
    floor_to_nice_number,
    format_signed,
    shorten,
    start_page,
    tick_values,
    write,
)
from driftform.figures.style import BLUE, GRID, INK, MUTED, tint
from driftform.types import FloatArray

_COLUMNS = 5
HEIGHT, GUTTER, LEFT, TOP = 132.0, 40.0, 52.0, 108.0

_ROW_GAP = 70.0

_BASELINE = "#7f8b96"


@dataclass(frozen=True, eq=False)
class Trend:
    """Growth of the best fitness for one target.

    Attributes
    ----------
    name
        of the target.
    flights
        number of flights up to each value, (g,).
    fitness
        the best so far, %, a row for each repeat, (repeats, g).
    baseline
        the same for a search without selection, (repeats, g), or (0, g) if there was no such search.
    """

    name: str
    flights: FloatArray
    fitness: FloatArray
    baseline: FloatArray


def trend_svg(trends: Sequence[Trend], title: str, strategy: str, baseline: str = "random search") -> str:
    """Return the trends as SVG: mean and standard deviation over repeats, and those of the baseline as a band.

    All panels share their axes. With one repeat, no deviation is drawn.
    """
    rows = ceil(len(trends) / _COLUMNS)
    repeats = max((len(trend.fitness) for trend in trends), default=0)
    over = f"mean and standard deviation over {repeats} repeats" if repeats > 1 else "one run"
    has_baseline = any(len(trend.baseline) for trend in trends)
    root = start_page(
        TOP + rows * (HEIGHT + _ROW_GAP) - 20,
        title,
        f"Best fitness so far (%) against flights for the target: {over}",
        f"For each target, the best fitness so far of {strategy} against flights"
        + (f"; {baseline} as a band." if has_baseline else "."),
    )
    _draw_legend(root, strategy, baseline if has_baseline else "")
    low = _find_lowest(trends)
    width = (WIDTH - LEFT - MARGIN - (_COLUMNS - 1) * GUTTER) / _COLUMNS
    for number, trend in enumerate(trends):
        row, column = divmod(number, _COLUMNS)
        left, top = LEFT + column * (width + GUTTER), TOP + row * (HEIGHT + _ROW_GAP)
        _draw_panel(root, trend, Box(left, top, left + width, top + HEIGHT), low)
    return svg.render(root)


def _find_lowest(trends: Sequence[Trend]) -> float:
    """Return the lower limit of all panels, %: a round number below all values."""
    lowest = 99.9
    for trend in trends:
        for values in (trend.fitness, trend.baseline):
            if len(values):
                lowest = min(lowest, float((values.mean(axis=0) - values.std(axis=0)).min()))
    step = floor_to_nice_number((100.0 - lowest) / 2)
    return max(0.0, float(np.floor(lowest / step) * step))


def _draw_panel(root: ET.Element, trend: Trend, box: Box, low: float) -> None:
    last = float(trend.flights[-1])

    def place(flights: FloatArray, fitness: FloatArray) -> FloatArray:
        x = box.left + (box.right - box.left) * np.asarray(flights) / last
        y = box.bottom - (box.bottom - box.top) * (np.clip(fitness, low, 100) - low) / (100 - low)
        return np.column_stack([x, y])

    for value in tick_values(low, 100.0, floor_to_nice_number((100 - low) / 3)):
        y = place(np.zeros(1), np.array([value]))[0, 1]
        svg.add_segment(root, box.left - 4, y, box.right, y, GRID)
        write(root, box.left - 7, y + 4, f"{value:g}", 11, MUTED, "end")
    for value in tick_values(0.0, last, floor_to_nice_number(last / 2)):
        x = place(np.array([value]), np.array([low]))[0, 0]
        svg.add_segment(root, x, box.bottom, x, box.bottom + 4, MUTED)
        write(root, x, box.bottom + 17, format_signed(value, 0), 11, MUTED, "middle")
    write(root, box.right, box.bottom + 31, "flights", 11, MUTED, "end")
    write(root, box.left - 7, box.top - 8, "%", 11, MUTED, "end")
    write(
        root, box.left, box.top - 8, shorten(trend.name, 12, box.right - box.left, bold=True), 12, bold=True
    )

    if len(trend.baseline):
        mean, spread = trend.baseline.mean(axis=0), trend.baseline.std(axis=0)
        band = np.vstack([place(trend.flights, mean + spread), place(trend.flights, mean - spread)[::-1]])
        svg.add(root, "path", class_="band", d=svg.path_data(band, closed=True), fill=tint(_BASELINE, 0.3))
        line = svg.path_data(place(trend.flights, mean))
        svg.add_line(root, line, _BASELINE, 1.4, stroke_dasharray="4 3")
    mean, spread = trend.fitness.mean(axis=0), trend.fitness.std(axis=0)
    if len(trend.fitness) > 1:
        tops, feet = place(trend.flights, mean + spread), place(trend.flights, mean - spread)
        bars = "".join(svg.path_data([t, f]) for t, f in zip(tops, feet, strict=True))
        svg.add(root, "path", class_="deviation", d=bars, stroke=BLUE, stroke_width=1.2)
    points = place(trend.flights, mean)
    svg.add_line(root, svg.path_data(points), BLUE, 2.2, "mean")
    # Many dots would hide the line.
    if len(points) <= 12:
        for x, y in points:
            svg.add_circle(root, x, y, 2.6, BLUE)


def _draw_legend(root: ET.Element, strategy: str, baseline: str) -> None:
    x, y = MARGIN, 78.0
    svg.add_segment(root, x, y - 4, x + 22, y - 4, BLUE, 2.2)
    write(root, x + 28, y, strategy, 12, INK)
    if baseline:
        x += 250
        svg.add(root, "rect", x=x, y=y - 10, width=22, height=12, fill=tint(_BASELINE, 0.3))
        svg.add_segment(root, x, y - 4, x + 22, y - 4, _BASELINE, 1.4, stroke_dasharray="4 3")
        write(root, x + 28, y, baseline, 12, INK)
