"""Best fitness against the number of flights, a panel per target."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil
from typing import Any

import numpy as np

from driftform.figures import svg
from driftform.figures.layout import MARGIN, Box, floor_to_nice_number, format_signed, shorten, start_page, tick_values
from driftform.figures.style import SCREEN, Page
from driftform.types import FloatArray

_COLUMNS, _NARROWEST = 5, 120.0
HEIGHT, GUTTER, LEFT, TOP = 132.0, 40.0, 52.0, 108.0

_ROW_GAP = 70.0

_RANDOM = "#7f8b96"
"""Colour of random search."""


@dataclass(frozen=True, eq=False)
class Trend:
    """Growth of the best fitness for one target.

    Attributes:
        name: of the target.
        flights: number of flights up to each value, (g,).
        fitness: the best so far, %, a row per repeat, (repeats, g).
        random: the same for random search, (repeats, g), or (0, g) if there was no such search.
    """

    name: str
    flights: FloatArray
    fitness: FloatArray
    random: FloatArray


def trend_svg(trends: Sequence[Trend], title: str, strategy: str, page: Page = SCREEN) -> str:
    """Return the trends as SVG: mean and standard deviation over repeats, and those of random search as a band.

    All panels share their axes. With one repeat, no deviation is drawn.
    """
    columns = max(1, min(_COLUMNS, int(page.width / _NARROWEST)))
    rows = ceil(len(trends) / columns)
    # Where both names do not fit in one line, the second is below the first.
    at, first = ((272, 74), TOP) if page.width > 450 else ((22, 92), TOP + 18)
    repeats = max((len(trend.fitness) for trend in trends), default=0)
    over = f"mean and standard deviation over {repeats} repeats" if repeats > 1 else "one run"
    has_random = any(len(trend.random) for trend in trends)
    root = start_page(
        first + rows * (HEIGHT + _ROW_GAP) - 20,
        title,
        f"Best fitness so far (%) against flights for the target: {over}",
        f"For each target, the best fitness so far of {strategy} against flights"
        + ("; random search as a band." if has_random else "."),
        page,
    )
    low, panels = _find_lowest(trends), []
    width = (page.width - LEFT - MARGIN - (columns - 1) * GUTTER) / columns
    for number, trend in enumerate(trends):
        row, column = divmod(number, columns)
        left, top = LEFT + column * (width + GUTTER), first + row * (HEIGHT + _ROW_GAP)
        panels.append(_plot_panel(trend, Box(left, top, left + width, top + HEIGHT), low))
    names = {"strategy": strategy, "random": "random search" if has_random else ""}
    svg.draw_template(root, __package__, "trend", panels=panels, grey=_RANDOM, at=at, **names)
    return svg.render(root)


def _find_lowest(trends: Sequence[Trend]) -> float:
    """Return the lower limit of all panels, %: a round number below all values."""
    lowest = 99.9
    for trend in trends:
        for values in (trend.fitness, trend.random):
            if len(values):
                lowest = min(lowest, float((values.mean(axis=0) - values.std(axis=0)).min()))
    step = floor_to_nice_number((100.0 - lowest) / 2)
    return max(0.0, float(np.floor(lowest / step) * step))


def _plot_panel(trend: Trend, box: Box, low: float) -> dict[str, Any]:
    """Return what the template draws for a target: its lines and ticks on the page."""
    last = float(trend.flights[-1])

    def place(flights: FloatArray, fitness: FloatArray) -> FloatArray:
        x = box.left + (box.right - box.left) * np.asarray(flights) / last
        y = box.bottom - (box.bottom - box.top) * (np.clip(fitness, low, 100) - low) / (100 - low)
        return np.column_stack([x, y])

    heights = tick_values(low, 100.0, floor_to_nice_number((100 - low) / 3))
    counts = tick_values(0.0, last, floor_to_nice_number(last / 2))
    panel: dict[str, Any] = {
        "box": box,
        "name": shorten(trend.name, 12, box.right - box.left, bold=True),
        "rises": [(place(np.zeros(1), np.array([v]))[0, 1], f"{v:g}") for v in heights],
        "ticks": [(place(np.array([v]), np.array([low]))[0, 0], format_signed(v, 0)) for v in counts],
        "random": None,
        "bars": "",
    }
    if len(trend.random):
        mean, spread = trend.random.mean(axis=0), trend.random.std(axis=0)
        band = np.vstack([place(trend.flights, mean + spread), place(trend.flights, mean - spread)[::-1]])
        panel["random"] = {"band": band, "mean": place(trend.flights, mean)}
    mean, spread = trend.fitness.mean(axis=0), trend.fitness.std(axis=0)
    if len(trend.fitness) > 1:
        ends = np.stack([place(trend.flights, mean + spread), place(trend.flights, mean - spread)], axis=1)
        panel["bars"] = svg.lines_data(ends)
    return {**panel, "mean": place(trend.flights, mean)}
