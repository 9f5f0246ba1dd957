"""What a strategy found: an archive as a map of its cells, a front as points."""

from collections.abc import Mapping

import numpy as np

from driftform.figures import svg
from driftform.figures.layout import MARGIN, Box, floor_to_nice_number, label_ticks, start_page, tick_values
from driftform.figures.style import RAMP, SCREEN, Page
from driftform.interfaces import Result

_LEFT, _TOP, _HEIGHT = 84.0, 92.0, 380.0


def result_svg(result: Result, title: str, units: Mapping[str, str], page: Page = SCREEN) -> str:
    """Return a result that has axes as SVG; ``units`` are those of its columns, as far as they are known."""
    labels = [f"{name} ({units[name]})" if units.get(name) else name for name in (*result.axes, result.colour)]
    points = np.column_stack([result.columns[name] for name in result.axes])
    bounds = [(low, high) for low, high, _ in result.grid] or [_widen(column.tolist()) for column in points.T]
    low, span = np.array(bounds)[:, 0], np.ptp(bounds, axis=1)
    # The template places shares of the axes.
    shares, ticks = (points - low) / span, []
    for least, most in bounds:
        values = tick_values(least, most, step := floor_to_nice_number((most - least) / 4))
        ticks.append(list(zip(((values - least) / (most - least)).tolist(), label_ticks(values, step), strict=True)))
    counts, cells, scale, subtitle = [count for *_, count in result.grid], [], list[str](), result.meaning
    if counts:
        best = np.full(counts, np.nan)
        # As in pyribs, what is outside counts at the edge.
        where = np.clip((shares * counts).astype(int), 0, np.subtract(counts, 1))
        np.fmax.at(best, tuple(where.T), result.columns[result.colour])
        filled = np.isfinite(best)
        lowest, highest = (float(best[filled].min()), float(best[filled].max())) if filled.any() else (0.0, 1.0)
        steps = np.rint((best[filled] - lowest) / (highest - lowest or 1.0) * (len(RAMP) - 1)).astype(int)
        corners = (np.argwhere(filled) / counts).tolist()
        cells = [(*corner, RAMP[number]) for corner, number in zip(corners, steps.tolist(), strict=True)]
        scale = [f"{value:.4g}" for value in np.linspace(lowest, highest, len(RAMP))[::3]]
        subtitle += f" {len(cells)} of {best.size} cells are filled."
    root = start_page(_TOP + _HEIGHT + (92 if counts else 52), title, subtitle, f"{subtitle} {labels}", page)
    box, dots = Box(_LEFT, _TOP, page.width - MARGIN, _TOP + _HEIGHT), [] if counts else shares.tolist()
    drawn = {"cells": cells, "counts": counts, "dots": dots, "ticks": ticks, "scale": scale}
    svg.draw_template(root, __package__, "result", box=box, labels=labels, **drawn)
    return svg.render(root)


def _widen(values: list[float]) -> tuple[float, float]:
    """Return bounds that leave some room around values, which may be none, or all the same."""
    low, high = min(values, default=0.0), max(values, default=1.0)
    room = 0.05 * (high - low) or 0.05 * abs(high) or 1.0
    return low - room, high + room
