"""Flights of the same agents under different conditions: the spread of their paths."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil
from xml.etree import ElementTree as ET

import numpy as np

from driftform.figures import layout, plot, style, svg
from driftform.motion import path
from driftform.types import FloatArray, Trajectory
from driftform.water import Scenario

COLUMNS = 2
LEFT, GUTTER, TOP = 52.0, 62.0, 108.0
NARROW = 500.0
"""Width of a page with one column, px."""

STATIONS = 240

SIDE = (0, 2)
"""x to the right and z upward on the page."""


@dataclass(frozen=True, eq=False)
class FlightSpread:
    """Flights of one agent for one target, cut at their closest approach as in the paper's Figure 7.

    ``note`` is written after the target's name.
    """

    name: str
    trajectories: tuple[Trajectory, ...]
    note: str = ""


def spread_svg(
    repeats: Sequence[FlightSpread], scenario: Scenario, title: str, subtitle: str, page: style.Page = style.SCREEN
) -> str:
    """Return a panel for each target: every flight faint, their mean solid, one standard deviation as a band.

    Mean and deviation are those of the height at equal x, over the range of x that all flights cover.
    """
    columns = COLUMNS if page.width > NARROW else 1
    width = (page.width - LEFT - layout.MARGIN - (columns - 1) * GUTTER) / columns
    shown = np.vstack([plot.pipe_points(scenario.pipe, SIDE), scenario.target_array()])
    tallest = plot.Window.around(SIDE, shown, LEFT, 0, width, 260, 6).box.bottom
    rows = ceil(len(repeats) / columns)
    height = TOP + rows * (tallest + 74)
    root = layout.start_page(height, title, subtitle, f"{subtitle} A panel for each target.", page)
    for number, repeated in enumerate(repeats):
        row, column = divmod(number, columns)
        left, top = LEFT + column * (width + GUTTER), TOP + row * (tallest + 74)
        window = plot.Window.around(SIDE, shown, left, top, width, 260, 6)
        _draw_panel(root, window, repeated, scenario, style.SERIES[number % len(style.SERIES)])
    return svg.render(root)


def compute_band(flights: Sequence[Trajectory], target: FloatArray) -> tuple[list[FloatArray], FloatArray, FloatArray]:
    """Return the paths up to their closest approach to ``target`` (3,), their mean, and the standard deviation.

    Paths are (n, 3) each, the mean (k, 3), the deviation of the height (k,); world frame, m.
    """
    paths = []
    for flight in flights:
        _, [closest] = path.closest_approach(flight, target[None])
        t = np.linspace(flight.t[0], max(closest, flight.t[0] + 1e-6), STATIONS)
        paths.append(path.interpolate_positions(flight, np.minimum(t, flight.t[-1])))
    along = np.linspace(max(path[0, 0] for path in paths), min(path[:, 0].max() for path in paths), STATIONS)
    # A path may turn back for a moment: the first time at a station counts.
    heights = np.array([np.interp(along, np.maximum.accumulate(path[:, 0]), path[:, 2]) for path in paths])
    mean = np.column_stack([along, np.zeros_like(along), heights.mean(axis=0)])
    return paths, mean, heights.std(axis=0)


def _draw_panel(root: ET.Element, window: plot.Window, repeated: FlightSpread, scenario: Scenario, colour: str) -> None:
    plot.draw_water(root, window, scenario.pipe)
    plot.draw_axes(root, window)
    plot.draw_walls(root, window, scenario.pipe)
    target = np.array(scenario.target_points()[repeated.name])
    paths, mean, deviation = compute_band(repeated.trajectories, target)
    up = np.array([0.0, 0.0, 1.0])
    edge = [window.to_page(mean + sign * deviation[:, None] * up) for sign in (1, -1)]
    outline = np.vstack([edge[0], edge[1][::-1]])
    svg.add(root, "path", class_="band", d=svg.path_data(outline, closed=True), fill=style.tint(colour, 0.3))
    for line in paths:
        svg.add_line(root, window.path_data(line), style.tint(colour, 0.55), 0.8)
    svg.add_line(root, window.path_data(mean), colour, 2, "mean")
    x, y = window.to_page(target[None])[0]
    plot.draw_cross(root, x, y, 5, style.INK, 2)
    name = f"{repeated.name}  {repeated.note}".strip()
    layout.write(root, window.box.left, window.box.top - 8, layout.shorten(name, 12, 330, bold=True), 12, bold=True)
