"""A view of the pipe from one side: to scale, with axes in metres."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from xml.etree import ElementTree as ET

import numpy as np

from driftform.figures import svg
from driftform.figures.layout import (
    Box,
    floor_to_nice_number,
    label_ticks,
    place_labels,
    resample_polyline,
    shorten,
    text_width,
    tick_values,
    write,
)
from driftform.figures.projection import View, across_in_view, convex_hull, silhouette, simplify_polyline
from driftform.figures.style import GRID, INK, MUTED, WALL, WATER
from driftform.motion.path.interpolation import Pose
from driftform.types import Body, FloatArray
from driftform.water import Pipe, Scenario
from driftform.water.parts.shapes import Opening, Straight

_NAMES = "xyz"

_RIM = 36
"""Points of a circle on the wall of a pipe with parts."""


@dataclass(frozen=True, eq=False)
class Window:
    """The visible part of a view, and its place on the page.

    Attributes:
        view: the indices of the world coordinates that run to the right and upward.
        box: the window on the page, px.
        low: the world point (m, (2,)) at its lower left corner.
        px_per_m: the scale, the same in both directions.
    """

    view: View
    box: Box
    low: FloatArray
    px_per_m: float

    @classmethod
    def around(
        cls, view: View, points: FloatArray, left: float, top: float, width: float, tallest: float, margin: float
    ) -> "Window":
        """Return the window, ``width`` px wide and as tall as needed, that shows all of ``points``.

        ``points``, (n, 3) in m, keep ``margin`` px from the frame; the window is at most ``tallest`` px tall.
        """
        seen = points[:, list(view)]
        low, high = seen.min(axis=0), seen.max(axis=0)
        # A point has no extent to fill a window with.
        extent = np.maximum(high - low, 1e-3)
        scale = float(min((width - 2 * margin) / extent[0], (tallest - 2 * margin) / extent[1]))
        height = max(extent[1] * scale + 2 * margin, 120.0)
        middle = (low + high) / 2
        box = Box(left, top, left + width, top + float(height))
        return cls(view, box, middle - np.array([width, height]) / (2 * scale), scale)

    @property
    def high(self) -> FloatArray:
        """The world point (m, (2,)) at the upper right corner."""
        size = (self.box.right - self.box.left, self.box.bottom - self.box.top)
        return self.low + np.array(size) / self.px_per_m

    def to_page(self, points: FloatArray) -> FloatArray:
        """Return page points of world points (n, 3), or of points already projected (n, 2), in m."""
        seen = points[:, list(self.view)] if points.shape[1] == 3 else points
        corner = np.array([self.box.left, self.box.bottom])
        return corner + self.px_per_m * (seen - self.low) * (1.0, -1.0)

    def path_data(self, points: FloatArray, tolerance: float = 0.15) -> str:
        """Return path data through world points (n, 3), exact to ``tolerance`` px."""
        return svg.path_data(simplify_polyline(self.to_page(points), tolerance))


def draw_axes(root: ET.Element, window: Window, names: tuple[str, str] | None = None) -> None:
    """Draw ticks with their values (m) below and on the left, and faint grid lines.

    ``names`` are the labels of the axes to the right and upward; by default the view's world coordinates.
    """
    box, low, high = window.box, window.low, window.high
    # Labels of 11 px need about 40 px each.
    steps = [floor_to_nice_number(2.49 * wanted / window.px_per_m) for wanted in (40, 26)]
    for axis, step in enumerate(steps):
        values = tick_values(float(low[axis]), float(high[axis]), step)
        for value, label in zip(values, label_ticks(values, step), strict=True):
            offset = (value - low[axis]) * window.px_per_m
            if axis == 0:
                x = box.left + offset
                svg.add_segment(root, x, box.top, x, box.bottom + 4, GRID, class_="tick-right")
                write(root, x, box.bottom + 17, label, 11, MUTED, "middle", class_="tick-right-label")
            else:
                y = box.bottom - offset
                svg.add_segment(root, box.left - 4, y, box.right, y, GRID, class_="tick-up")
                write(root, box.left - 8, y + 4, label, 11, MUTED, "end", class_="tick-up-label")
    right, up = names or (_NAMES[i] for i in window.view)
    write(root, box.right, box.bottom + 32, f"{right} (m)", 11, MUTED, "end")
    write(root, box.left - 8, box.top - 10, f"{up} (m)", 11, MUTED, "end")


def draw_scene(root: ET.Element, window: Window, scenario: Scenario) -> None:
    """Draw the surroundings of a flight: the pipe with its water, the axes and the current."""
    draw_water(root, window, scenario.pipe)
    draw_axes(root, window)
    draw_ends(root, window, scenario.pipe)
    draw_current(root, window, scenario.current())


def draw_water(root: ET.Element, window: Window, pipe: Pipe) -> None:
    """Draw the wall of a pipe as the outline of all its parts, filled with water; nothing in open water."""
    if hulls := _list_hulls(window, pipe):
        data = "".join(svg.path_data(hull, closed=True) for hull in hulls)
        # The filling covers the inner strokes, so that only the outline of the union remains.
        svg.add(root, "path", class_="wall", d=data, stroke=WALL, stroke_width=5, stroke_linejoin="round")
        svg.add(root, "path", class_="water", d=data, fill=WATER, stroke=WATER, stroke_width=0.4)


def draw_ends(root: ET.Element, window: Window, pipe: Pipe) -> None:
    """Draw the open ends of a pipe as dashed lines, in place of its wall."""
    layout = pipe.layout
    for opening in () if pipe.is_open else (layout.inlet, *(outlet.opening for outlet in layout.outlets)):
        line = svg.path_data(window.to_page(_widest_line(opening, window.view)))
        svg.add(root, "path", d=line, stroke=WATER, stroke_width=6)
        svg.add(root, "path", d=line, stroke=WALL, stroke_width=0.8, stroke_dasharray="3 4")


def pipe_points(pipe: Pipe) -> FloatArray:
    """Return world points, (n, 3) in m, that bound the pipe in any view."""
    return np.vstack([np.zeros((0, 3)), *(rim.reshape(-1, 3) for rim in list_rims(pipe))])


def list_rims(pipe: Pipe) -> list[FloatArray]:
    """Return circles on the wall of each bore of a pipe, in the order of its axis, m, (k, n, 3) each."""
    parts = [placed.part for placed in pipe.layout.parts]
    steps = [part.length if isinstance(part, Straight) else 0.2 * part.end_radius for part in parts]
    return [rim for part, step in zip(parts, steps, strict=True) for rim in part.list_rims(step, _RIM)]


def _list_hulls(window: Window, pipe: Pipe) -> list[FloatArray]:
    """Return convex polygons whose union is the silhouette of a pipe, px; none in open water."""
    hulls: list[FloatArray] = []
    for rims in list_rims(pipe):
        seen = rims[:, :, list(window.view)]
        pairs = (convex_hull(np.vstack(pair)) for pair in pairwise(seen))
        hulls += [window.to_page(hull) for hull in pairs if len(hull) > 2]
    return hulls


def _widest_line(opening: Opening, view: View) -> FloatArray:
    """Return the two points of the rim of an opening that are farthest apart in a view, m, (2, 3)."""
    across = opening.radius * across_in_view(opening.axes[0], view)
    return np.array([opening.centre + across, opening.centre - across])


def pipe_ink(window: Window, pipe: Pipe) -> FloatArray:
    """Return points along the walls and ends, 3 px apart, for labels to avoid; px, (n, 2)."""
    return np.vstack(
        [np.zeros((0, 2)), *(resample_polyline(np.vstack([c, c[:1]]), 3) for c in _list_hulls(window, pipe))]
    )


def draw_current(root: ET.Element, window: Window, current: FloatArray) -> None:
    """Write the speed of the water above the window's right end, with an arrow in its direction."""
    seen = current[list(window.view)] * (1.0, -1.0)
    speed = float(np.linalg.norm(seen))
    if speed < 1e-9:
        return
    along = seen / speed
    aside = np.array([-along[1], along[0]])
    middle = np.array([window.box.right - 13, window.box.top - 14])
    tip = middle + 13 * along
    svg.add(root, "path", d=svg.path_data([middle - 13 * along, tip]), stroke=MUTED, stroke_width=1.2)
    head = np.array([tip, tip - 7 * along + 3 * aside, tip - 7 * along - 3 * aside])
    svg.add(root, "path", d=svg.path_data(head, closed=True), fill=MUTED)
    text = f"current {float(np.linalg.norm(current)):g} m/s"
    write(root, middle[0] - 20, middle[1] + 4, text, 11, MUTED, "end")


def draw_cross(root: ET.Element, x: float, y: float, arm: float, colour: str = INK, width: float = 2) -> None:
    """Draw a target as an upright cross, with a white halo that sets it off from lines."""
    data = svg.path_data([(x - arm, y), (x + arm, y)]) + svg.path_data([(x, y - arm), (x, y + arm)])
    svg.add(root, "path", d=data, stroke="#ffffff", stroke_width=width + 2.5, stroke_linecap="round")
    svg.add(root, "path", class_="target", d=data, stroke=colour, stroke_width=width, stroke_linecap="round")


def label_points(
    root: ET.Element,
    window: Window,
    anchors: FloatArray,
    names: Sequence[tuple[str, str, bool]],
    ink: Sequence[FloatArray],
    keep: float,
) -> None:
    """Write names next to points of the page so that they overlap neither each other nor, if possible, lines.

    Args:
        anchors: the points, (n, 2) in px.
        names: text, colour and boldness, for each point.
        ink: as in :func:`driftform.figures.layout.place_labels`, as a list of parts.
        keep: as there.
    """
    texts = [shorten(name, 12, 140, bold=True) for name, _, _ in names]
    frame = window.box
    page = Box(frame.left + 2, frame.top + 2, frame.right - 2, frame.bottom - 2)
    widths = [text_width(text, 12, bold=True) for text in texts]
    boxes = place_labels(anchors, widths, 14, np.vstack(ink), page, keep)
    for text, (_, colour, bold), box in zip(texts, names, boxes, strict=True):
        middle = (box.left + box.right) / 2
        write(root, middle, box.bottom - 3, text, 12, colour, "middle", bold=bold, halo=True)


def draw_silhouette(
    root: ET.Element, window: Window, body: Body, pose: Pose, magnification: float, colours: tuple[str, str, str]
) -> FloatArray:
    """Draw a body's outline in its attitude, magnified about its core; ``colours`` are fill, edge and core.

    Return the corners of the drawn polygons and the core's centre, (n, 2) in px.
    """
    fill, edge, dot = colours
    size = window.px_per_m * magnification
    centre = window.to_page(pose.position[None])[0]
    polygons = [
        centre + size * polygon * (1.0, -1.0) for polygon in silhouette(body, pose.quaternion, window.view, 0.2 / size)
    ]
    data = "".join(svg.path_data(polygon, closed=True) for polygon in polygons)
    # The filling covers the inner strokes, so that only the outline of the union remains.
    svg.add_line(root, data, edge, 1.6, stroke_linejoin="round")
    svg.add(root, "path", class_="silhouette", d=data, fill=fill, stroke=fill, stroke_width=0.2)
    svg.add_circle(root, centre[0], centre[1], 2.5, dot)
    return np.vstack([centre[None], *polygons])
