"""The result of a study in one picture: the best flight per target, and the bodies."""

from collections.abc import Sequence
from xml.etree import ElementTree as ET

import numpy as np

from driftform.figures import svg
from driftform.figures.gallery import GalleryEntry, arrange_rows, draw_gallery, group_shared
from driftform.figures.layout import MARGIN, resample_polyline, start_page, text_width
from driftform.figures.plot import Window, draw_cross, draw_scene, label_points, pipe_ink, pipe_points
from driftform.figures.projection import SIDE, drawing_times
from driftform.figures.style import INK, MUTED, SCREEN, SERIES, Page, tint
from driftform.motion.path.interpolation import interpolate_positions
from driftform.motion.path.targets import find_target_approaches
from driftform.types import FloatArray
from driftform.water import Scenario

_LEFT, _RIGHT = 58.0, 22.0


def overview_svg(
    flights: Sequence[GalleryEntry], scenario: Scenario, title: str, result: str = "", page: Page = SCREEN
) -> str:
    """Return the result of a study as SVG: the pipe with each flight in side view, a gallery of bodies below.

    Args:
        flights: each gets its colour, and is solid up to its closest approach and faint after it. If the scenario has
            no target of the flight's name, the closest approach is that to the nearest target.
        scenario: pipe, current and targets; x to the right, z upward, to scale.
        title: a line above the picture.
        result: what the flights come to, in a few words; left out if it does not fit on a line.
        page: on paper, title and result are left out, and the lines of flights differ in their dashes.

    The bodies of the gallery share one scale, fore end to the right.
    """
    groups = group_shared(flights)
    lines = [interpolate_positions(g[0].trajectory, drawing_times(g[0].trajectory)) for g in groups]
    targets = scenario.target_array()
    points = np.vstack([targets, pipe_points(scenario.pipe), scenario.release_position()[None], *lines])
    window = Window.around(SIDE, points, _LEFT, 92, page.width - _LEFT - _RIGHT, 460, 14)
    rows, px_per_m = arrange_rows(flights, page)
    top = window.box.bottom + 84
    height = top + sum(row.height for row in rows) + (2 if rows else -34)

    best = ", ".join(f"{f.name} {f.value:.2f} {f.unit}" for f in flights)
    shown = "1 flight" if len(groups) == 1 else f"{len(groups)} flights"
    subtitle = f"{shown}, solid up to the closest approach and faint after it"
    # The report has the results that are too long for the line.
    if result and text_width(f"{subtitle}; {result}", 12) <= page.width - 2 * MARGIN:
        subtitle += f"; {result}"
    description = (
        "Above: the pipe in side view with the best flight for each target. Below: the bodies, "
        f"at one scale. By target: {best or 'no flights'}."
    )
    root = start_page(height, title, subtitle if groups else "No flights", description, page)
    _draw_flights(root, window, groups, lines, scenario, page)
    draw_gallery(root, rows, px_per_m, top, page)
    return svg.render(root)


def _find_end(flight: GalleryEntry, scenario: Scenario) -> float:
    """Return when (s) it comes closest to its target, or, if the scenario lacks that, to any; infinite without targets."""
    approaches = find_target_approaches(flight.trajectory, scenario)
    if flight.name in scenario.targets:
        return approaches[scenario.target_names.index(flight.name)].t
    return min(approaches, key=lambda approach: approach.distance).t if approaches else np.inf


def _draw_flights(
    root: ET.Element,
    window: Window,
    groups: Sequence[Sequence[GalleryEntry]],
    lines: list[FloatArray],
    scenario: Scenario,
    page: Page,
) -> None:
    draw_scene(root, window, scenario)
    colours = [SERIES[number % len(SERIES)] for number in range(len(groups))]
    # A flight that is the best for several targets is solid up to the last of them.
    stops = [max(_find_end(flight, scenario) for flight in group) for group in groups]
    firm = [
        interpolate_positions(group[0].trajectory, drawing_times(group[0].trajectory, stop=end))
        for group, end in zip(groups, stops, strict=True)
    ]
    ends = {"stroke_linejoin": "round", "stroke_linecap": "round"}
    for line, colour in zip(lines, colours, strict=True):
        svg.add_line(root, window.path_data(line), tint(colour, 0.28), 1.2, "faint", **ends)
    for number, (line, colour) in enumerate(zip(firm, colours, strict=True)):
        dashes = page.choose_dash(number)
        ends = {"stroke_dasharray": dashes, "stroke_linejoin": "round", "stroke_linecap": "butt" if dashes else "round"}
        svg.add_line(root, window.path_data(line), colour, 2.2, "firm", **ends)
    ink = [pipe_ink(window, scenario.pipe), *(resample_polyline(window.to_page(line), 3) for line in firm)]
    # Faint lines count for less: a label may cross one if there is no free place.
    ink += [resample_polyline(window.to_page(line), 9) for line in lines]
    start = window.to_page(scenario.release_position()[None])
    svg.add_circle(root, start[0, 0], start[0, 1], 4.5, "#ffffff", INK, 1.6)

    names = list(scenario.target_names)
    anchors = window.to_page(scenario.target_array())
    owner = {flight.name: colour for group, colour in zip(groups, colours, strict=True) for flight in group}
    for name, (x, y) in zip(names, anchors, strict=True):
        draw_cross(root, x, y, 5.5, owner.get(name, MUTED), 2.4)
    label_points(root, window, anchors, [(name, INK, True) for name in names], ink, keep=8)
