"""Fitness against the number of flights: curves in a panel per target."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil
from typing import Any

import numpy as np
import numpy.typing as npt

from driftform.figures import svg
from driftform.figures.layout import (
    MARGIN,
    Box,
    floor_to_nice_number,
    format_signed,
    shorten,
    start_page,
    text_width,
    tick_values,
)
from driftform.figures.style import SCREEN, SERIES, Page
from driftform.types import FloatArray

_COLUMNS, _NARROWEST = 5, 120.0
HEIGHT, GUTTER, LEFT, TOP = 132.0, 40.0, 52.0, 108.0

_ROW_GAP, _LINE = 70.0, 18.0

POINTS = 60
"""Greatest number of points of a curve."""


@dataclass(frozen=True, eq=False)
class Curve:
    """Fitness against flights.

    Attributes:
        name: of the search.
        flights: number of flights up to each value, (g,).
        fitness: %, (g,).
        band: the lower and the upper edge of its spread over repeats, %, (2, g); ``None`` for one run.
    """

    name: str
    flights: npt.NDArray[Any]
    fitness: FloatArray
    band: FloatArray | None = None

    @classmethod
    def of_mean(cls, name: str, flights: npt.NDArray[Any], fitness: FloatArray) -> "Curve":
        """Return the mean of repeats, (repeats, g), with one standard deviation as its band."""
        mean, spread = fitness.mean(axis=0), fitness.std(axis=0)
        return cls(name, flights, mean, np.stack([mean - spread, mean + spread]) if len(fitness) > 1 else None)


def choose_points(flights: int) -> npt.NDArray[np.int64]:
    """Return the numbers of flights at which a curve is drawn: all of a few, or :data:`POINTS` of many."""
    # Here, in the reach map and in the viewer numpy.unique would import numpy.ma, for a hundredth of the time of a report.
    return np.array(sorted(set(np.linspace(1, flights, min(POINTS, flights)).astype(int).tolist())))


def trend_svg(panels: Mapping[str, Sequence[Curve]], title: str, subtitle: str, page: Page = SCREEN) -> str:
    """Return curves as SVG, a panel for each name, which share their axes; each has a line, and a band if it has one."""
    columns = max(1, min(_COLUMNS, int(page.width / _NARROWEST)))
    rows = ceil(len(panels) / columns)
    names = list(dict.fromkeys(curve.name for curves in panels.values() for curve in curves))
    colours = {name: (SERIES[k % len(SERIES)], page.choose_dash(k)) for k, name in enumerate(names)}
    legend, x, y = [], MARGIN, 74.0
    for name in names:
        text = shorten(name, 12, page.width - 2 * MARGIN - 28)
        if x > MARGIN and x + 28 + text_width(text, 12) > page.width - MARGIN:
            x, y = MARGIN, y + _LINE
        legend.append((x, y, text, *colours[name]))
        x += 56 + text_width(text, 12)
    first = y + TOP - 74
    root = start_page(
        first + rows * (HEIGHT + _ROW_GAP) - 20,
        title,
        subtitle,
        f"{subtitle}: {', '.join(names)}. A panel each for {', '.join(panels)}.",
        page,
    )
    curves = [curve for row in panels.values() for curve in row]
    last = max((float(curve.flights[-1]) for curve in curves), default=1.0)
    lines = [(c.flights, c.fitness if c.band is None else c.band[0]) for c in curves]
    # The first flights of a search are far below all others.
    lowest = min((float(line[flights > last / 20].min()) for flights, line in lines if len(flights)), default=0.0)
    step = floor_to_nice_number((100.0 - min(99.9, lowest)) / 2)
    low = max(0.0, float(np.floor(min(99.9, lowest) / step) * step))
    width = (page.width - LEFT - MARGIN - (columns - 1) * GUTTER) / columns
    drawn = []
    for number, (name, row) in enumerate(panels.items()):
        at, left = divmod(number, columns)
        box = Box(LEFT + left * (width + GUTTER), first + at * (HEIGHT + _ROW_GAP), 0, 0)
        box = Box(box.left, box.top, box.left + width, box.top + HEIGHT)
        drawn.append(_plot_panel(name, row, box, low, last) | {"styles": [colours[curve.name] for curve in row]})
    svg.draw_template(root, __package__, "trend", panels=drawn, legend=legend)
    return svg.render(root)


def _plot_panel(name: str, curves: Sequence[Curve], box: Box, low: float, last: float) -> dict[str, Any]:
    """Return what the template draws of a panel: its curves and ticks on the page."""

    def place(flights: npt.NDArray[Any], fitness: FloatArray) -> FloatArray:
        x = box.left + (box.right - box.left) * flights / last
        return np.column_stack(
            [x, box.bottom - (box.bottom - box.top) * (np.clip(fitness, low, 100) - low) / (100 - low)]
        )

    heights = tick_values(low, 100.0, floor_to_nice_number((100 - low) / 3))
    counts = tick_values(0.0, last, floor_to_nice_number(last / 2))
    bands = [
        None if c.band is None else np.vstack([place(c.flights, c.band[0]), place(c.flights, c.band[1])[::-1]])
        for c in curves
    ]
    return {
        "box": box,
        "name": shorten(name, 12, box.right - box.left, bold=True),
        "rises": [(y, f"{v:g}") for v, y in zip(heights, place(0 * heights, heights)[:, 1], strict=True)],
        "ticks": [(x, format_signed(v, 0)) for v, x in zip(counts, place(counts, 0 * counts)[:, 0], strict=True)],
        "bands": bands,
        "lines": [place(curve.flights, curve.fitness) for curve in curves],
    }
