"""The result of a study in one picture: the best flight for each target, and the bodies that flew them."""

from collections.abc import Sequence
from dataclasses import dataclass
from xml.etree import ElementTree as ET

import numpy as np

from driftform.figures import svg
from driftform.figures.bodies import Placement, closed_outline, draw_rims, draw_shading
from driftform.figures.layout import Box, nice_below, place_labels, shorten, text_width, write
from driftform.figures.plot import (
    Window,
    draw_axes,
    draw_cross,
    draw_current,
    draw_walls,
    draw_water,
    pipe_ink,
    pipe_points,
)
from driftform.figures.projection import SIDE, Approach, closest, positions, resample, times
from driftform.figures.style import GRID, INK, MUTED, SERIES, tint
from driftform.scenario import Scenario
from driftform.types import Agent, FloatArray, Trajectory

_WIDTH, _LEFT, _RIGHT, _MARGIN = 900.0, 58.0, 22.0, 22.0
_COLUMNS = 5
_TALLEST = 150.0
_GAP, _NARROWEST = 24.0, 132.0


@dataclass(frozen=True, eq=False)
class Flight:
    """The best flight for a target: ``name`` is the target's, ``error_percent`` is 100 (1 - fitness)."""

    name: str
    agent: Agent
    trajectory: Trajectory
    error_percent: float


def overview_svg(flights: Sequence[Flight], scenario: Scenario, title: str) -> str:
    """Return the result of a study as SVG: the pipe with each flight in side view, a gallery of bodies below.

    Parameters
    ----------
    flights
        each in a colour of its own, firm up to its closest approach and faint after. A flight whose name is
        no target of the scenario is cut at the target that it comes closest to.
    scenario
        pipe, current and targets; x to the right, z upward, to scale.
    title
        a line above the picture.

    The bodies of the gallery share one scale, fore end to the right.
    """
    lines = [positions(f.trajectory, times(f.trajectory)) for f in flights]
    targets = scenario.target_array()
    shown = np.vstack(
        [targets, pipe_points(scenario.pipe, SIDE), np.array([scenario.release.position]), *lines]
    )
    window = Window.around(SIDE, shown, _LEFT, 92, _WIDTH - _LEFT - _RIGHT, 460, 14)
    rows, px_per_m = _gallery(flights)
    top = window.box.bottom + 84
    height = top + sum(row.height for row in rows) + (2 if rows else -34)

    worst = max((f.error_percent for f in flights), default=0.0)
    best = ", ".join(f"{f.name} {f.error_percent:.2f} %" for f in flights)
    root = svg.document(
        _WIDTH,
        height,
        title,
        "Above, the pipe in side view with the best flight for each target; below, the bodies that flew, "
        f"at one scale. Error by target: {best or 'no flights'}.",
    )
    write(root, _MARGIN, 36, shorten(title, 20, _WIDTH - 2 * _MARGIN, bold=True), 20, bold=True)
    write(root, _MARGIN, 58, _subtitle(scenario, len(flights), worst), 12, MUTED)
    _draw_flights(root, window, flights, lines, scenario)
    _draw_gallery(root, rows, px_per_m, top)
    return svg.render(root)


def _subtitle(scenario: Scenario, count: int, worst: float) -> str:
    if not count:
        return "No flights"
    flights = "The flight" if count == 1 else f"The {count} flights"
    return f"{flights}, firm up to the closest approach and faint after; largest error {worst:.2f} %"


def _colours(flights: Sequence[Flight]) -> list[str]:
    return [SERIES[i % len(SERIES)] for i in range(len(flights))]


def _approach(flight: Flight, scenario: Scenario) -> Approach | None:
    """Return the closest approach to the flight's own target, or to any where it has none."""
    target = scenario.targets.get(flight.name)
    points = scenario.target_array() if target is None else np.array([target])
    approaches = closest(flight.trajectory, points) if len(points) else []
    return min(approaches, key=lambda a: a.distance, default=None)


def _draw_flights(
    root: ET.Element, window: Window, flights: Sequence[Flight], lines: list[FloatArray], scenario: Scenario
) -> None:
    draw_water(root, window, scenario.pipe)
    draw_axes(root, window)
    draw_walls(root, window, scenario.pipe)
    draw_current(root, window, scenario.current())
    colours = _colours(flights)
    approaches = [_approach(flight, scenario) for flight in flights]
    firm = [
        positions(f.trajectory, times(f.trajectory, stop=np.inf if a is None else a.t))
        for f, a in zip(flights, approaches, strict=True)
    ]
    for line, colour in zip(lines, colours, strict=True):
        _draw_line(root, window, line, tint(colour, 0.28), 1.2, "faint")
    for line, colour in zip(firm, colours, strict=True):
        _draw_line(root, window, line, colour, 2.2, "firm")
    ink = [pipe_ink(window, scenario.pipe), *(resample(window.to_page(line), 3) for line in firm)]
    # Faint lines count for less: a label may cross one where all else is taken.
    ink += [resample(window.to_page(line), 9) for line in lines]
    start = window.to_page(np.array([scenario.release.position]))
    svg.add(
        root, "circle", cx=start[0, 0], cy=start[0, 1], r=4.5, fill="#ffffff", stroke=INK, stroke_width=1.6
    )

    names = list(scenario.target_names)
    anchors = window.to_page(scenario.target_array())
    owner = {flight.name: colour for flight, colour in zip(flights, colours, strict=True)}
    for name, (x, y) in zip(names, anchors, strict=True):
        draw_cross(root, x, y, 5.5, owner.get(name, MUTED), 2.4)
    frame = window.box
    page = Box(frame.left + 2, frame.top + 2, frame.right - 2, frame.bottom - 2)
    labels = [shorten(name, 12, 140, bold=True) for name in names]
    widths = [text_width(label, 12, bold=True) for label in labels]
    boxes = place_labels(anchors, widths, 14, np.vstack(ink), page, keep=8)
    for label, box in zip(labels, boxes, strict=True):
        write(
            root, (box.left + box.right) / 2, box.bottom - 3, label, 12, INK, "middle", bold=True, halo=True
        )


def _draw_line(
    root: ET.Element, window: Window, line: FloatArray, colour: str, width: float, class_: str
) -> None:
    svg.add(
        root,
        "path",
        class_=class_,
        d=window.line(line),
        fill="none",
        stroke=colour,
        stroke_width=width,
        stroke_linejoin="round",
        stroke_linecap="round",
    )


@dataclass(frozen=True, eq=False)
class _Row:
    """Some bodies side by side: each with its colour and its cell's width, the tallest, and the row; px."""

    cells: list[tuple[Flight, str, float]]
    tallest: float
    height: float


def _gallery(flights: Sequence[Flight]) -> tuple[list[_Row], float]:
    """Return the rows of the gallery, and the px for a metre, the same in all of them."""
    if not flights:
        return [], 1.0
    bodies = [flight.agent.body for flight in flights]
    pairs = list(zip(flights, _colours(flights), strict=True))
    split = [pairs[first : first + _COLUMNS] for first in range(0, len(pairs), _COLUMNS)]
    inner = _WIDTH - 2 * _MARGIN

    def cells(row: list[tuple[Flight, str]], px_per_m: float) -> list[float]:
        return [max(f.agent.body.length * px_per_m + _GAP, _NARROWEST) for f, _ in row]

    # The largest scale at which every row fits: widths only grow with it, so bisection finds it.
    low, high = 0.0, _TALLEST / max(body.max_diameter for body in bodies)
    for _ in range(50):
        middle = (low + high) / 2
        fits = all(sum(cells(row, middle)) <= inner for row in split)
        low, high = (middle, high) if fits else (low, middle)
    rows = []
    for row in split:
        widths = cells(row, low)
        # A short last row keeps to the left, in cells like those above it.
        spare = (inner - sum(widths)) / len(row) if len(row) == _COLUMNS else 0.0
        tallest = max(f.agent.body.max_diameter for f, _ in row) * low
        rows.append(
            _Row([(f, c, w + spare) for (f, c), w in zip(row, widths, strict=True)], tallest, tallest + 66)
        )
    return rows, low


def _draw_gallery(root: ET.Element, rows: list[_Row], px_per_m: float, top: float) -> None:
    if not rows:
        return
    svg.add(root, "line", x1=_MARGIN, y1=top - 38, x2=_WIDTH - _MARGIN, y2=top - 38, stroke=GRID)
    write(root, _MARGIN, top - 14, "The bodies, to one scale, fore end to the right", 12, MUTED)
    bar = nice_below(110 / px_per_m)
    end, base = _WIDTH - _MARGIN, top - 12
    ticks = [(end - bar * px_per_m, base - 4), (end - bar * px_per_m, base), (end, base), (end, base - 4)]
    svg.add(
        root, "path", class_="scale-bar", d=svg.polyline(ticks), fill="none", stroke=INK, stroke_width=1.2
    )
    middle = end - bar * px_per_m / 2
    write(root, middle, base - 6, f"{1000 * bar:g} mm", 11, MUTED, "middle", class_="scale-bar-label")

    for row in rows:
        x = _MARGIN
        for flight, colour, cell in row.cells:
            x += cell / 2
            body = flight.agent.body
            _draw_body(root, flight, colour, Placement.centred(body, x, top + 12 + row.tallest / 2, px_per_m))
            base = top + row.tallest + 36
            name = shorten(flight.name, 13, cell - 84, bold=True)
            error = f"{flight.error_percent:.2f} %"
            # The name, in the colour of its line, and the error stand as one centred group.
            group = [20.0, text_width(name, 13, bold=True) + 4, text_width(error, 12)]
            left = x - sum(group) / 2
            svg.add(
                root,
                "line",
                x1=left,
                y1=base - 4.5,
                x2=left + 12,
                y2=base - 4.5,
                stroke=colour,
                stroke_width=3.5,
                stroke_linecap="round",
            )
            write(root, left + group[0], base, name, 13, INK, bold=True)
            write(root, left + group[0] + group[1], base, error, 12, MUTED)
            x += cell / 2
        top += row.height


def _draw_body(root: ET.Element, flight: Flight, colour: str, place: Placement) -> None:
    body = flight.agent.body
    draw_shading(root, body, place, colour, below=1, bands=6)
    draw_rims(root, body, place, tint(colour, 0.5), 0.5, below=1)
    svg.add(
        root,
        "path",
        class_="outline",
        d=svg.polyline(place.to_page(closed_outline(body.outer)), closed=True),
        fill="none",
        stroke=colour,
        stroke_width=1.1,
        stroke_linejoin="round",
    )
    radius = max(1.5, body.core.radius * place.px_per_m)
    svg.add(root, "circle", class_="core", cx=place.x, cy=place.y, r=radius, fill=colour)
