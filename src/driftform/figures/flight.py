"""One flight through the pipe: the path, the attitude, and the closest approach to a target."""

from xml.etree import ElementTree as ET

import numpy as np

from driftform.figures import svg
from driftform.figures.layout import resample_polyline, shorten, write, write_title
from driftform.figures.plot import Window, draw_cross, draw_scene, draw_silhouette, label_points, pipe_ink, pipe_points
from driftform.figures.projection import PLAN, SIDE, drawing_times
from driftform.figures.style import BLUE, INK, MUTED, ORANGE, SCREEN, VERMILLION, Page, tint
from driftform.motion.path.approach import Approach
from driftform.motion.path.interpolation import interpolate_pose, interpolate_positions
from driftform.motion.path.targets import find_target_approaches
from driftform.types import Body, FloatArray, Trajectory
from driftform.water import Scenario

_LEFT, _RIGHT = 62.0, 24.0
_TALLEST = 440.0
_READABLE = 28.0
"""A silhouette shorter than this, in px, is magnified until its attitude can be seen."""
_MAGNIFICATIONS = (1, 2, 3, 4, 5, 6, 8, 10, 12, 15, 20, 25, 30, 40, 50, 75, 100)
_SIDEWAYS = 0.01
"""A flight that moves sideways (along y) by more than this, in m, is shown from above as well."""


def flight_svg(
    trajectory: Trajectory, scenario: Scenario, title: str = "", body: Body | None = None, page: Page = SCREEN
) -> str:
    """Return a flight as SVG: the pipe in side view (x to the right, z upward), to scale, axes in metres.

    Args:
        trajectory: its path is drawn with the interpolation between samples that fitness uses.
        scenario: pipe, current and targets; in open water, the window fits the path and the targets.
        title: a line above the picture.
        body: its silhouette is drawn in its attitude at several moments, magnified if it would be too small.
        page: on paper, title and captions are left out.

    A flight that also moves sideways gets a plan view (x to the right, y upward) below the side view.
    """
    line = interpolate_positions(trajectory, drawing_times(trajectory))
    targets = scenario.target_array()
    approaches = find_target_approaches(trajectory, scenario)
    # Number of the target, and the approach to it.
    nearest = min(enumerate(approaches), key=lambda pair: pair[1].distance, default=None)

    sideways = float(np.ptp(line[:, 1])) > _SIDEWAYS
    views = (SIDE, PLAN) if sideways else (SIDE,)
    windows: list[Window] = []
    top, magnification, width = 80.0, 1, page.width - _LEFT - _RIGHT
    for view in views:
        points = [line, targets, pipe_points(scenario.pipe)]
        if body is not None and scenario.pipe.is_open:
            # Without this margin, a body that hardly moves would fill the window.
            room = 1.5 * max(body.length, body.max_diameter)
            points.append(line[0] + room * np.vstack([np.eye(3), -np.eye(3)]))
        shown = np.vstack(points)
        tight = Window.around(view, shown, _LEFT, top, width, _TALLEST, 26)
        if view == SIDE and body is not None:
            natural = max(body.length, body.max_diameter) * tight.px_per_m
            magnification = next((m for m in _MAGNIFICATIONS if m * natural >= _READABLE), _MAGNIFICATIONS[-1])
        # A silhouette extends beyond the path by its reach from the core; the window grows by that.
        reach_m = 0.0 if body is None else float(np.hypot(*body.outer.T).max()) * magnification
        reach = reach_m * tight.px_per_m
        if reach > _TALLEST / 4:
            # A margin of so many pixels would leave none for the path.
            shown = np.vstack([shown + step for step in reach_m * np.vstack([np.eye(3), -np.eye(3)])])
            reach = 0.0
        windows.append(Window.around(view, shown, _LEFT, top, width, _TALLEST, max(26.0, reach + 3)))
        top = windows[-1].box.bottom + 74

    captions = _write_captions(trajectory, scenario, body, magnification, nearest)
    written = [] if page.is_paper else captions
    height = windows[-1].box.bottom + (40 if page.is_paper else 58 + 17 * len(written))
    described = title or "Flight of an agent", " ".join(captions)
    root = svg.start_document(page.width, height, *described, page=page, header=56)
    if not page.is_paper:
        write_title(root, 22, 34, title or "Flight", 17, width)
    headings = {SIDE: "Side view", PLAN: "Plan view, from above"}
    for window in windows:
        write(root, _LEFT, window.box.top - 10, headings[window.view], 12, MUTED)
        _draw_view(root, window, trajectory, scenario, body, magnification, nearest)
    for row, caption in enumerate(written):
        y = windows[-1].box.bottom + 56 + 17 * row
        write(root, _LEFT, y, shorten(caption, 12, width), 12, MUTED, class_="caption")
    return svg.render(root)


def _write_captions(
    trajectory: Trajectory,
    scenario: Scenario,
    body: Body | None,
    magnification: int,
    nearest: tuple[int, Approach] | None,
) -> list[str]:
    captions = [f"Ends after {trajectory.t[-1]:.2f} s: {_ENDS[trajectory.end.value]}."]
    if nearest is not None:
        number, approach = nearest
        metres = approach.distance
        away = f"{1000 * metres:.1f} mm" if metres < 0.0995 else f"{metres:.2f} m"
        closest = f"Closest to {scenario.target_names[number]}: {away} away"
        captions.insert(0, f"{closest} after {approach.t:.2f} s.")
    if body is not None:
        scale = "to scale" if magnification == 1 else f"magnified {magnification} times about the core"
        # A magnified body that slides along the wall looks as if it were stuck in the wall.
        scale += ", so some cross the wall" if magnification > 1 and not scenario.pipe.is_open else ""
        captions.append(f"Silhouettes: attitude at equal distances along the path, {scale}.")
    # Two short sentences share a line.
    return [" ".join(captions[:2]), *captions[2:]] if nearest is not None else captions


_ENDS = {
    "outlet": "it left through the outlet",
    "inlet": "it left through the inlet",
    "edge of the grid": "it left the grid",
    "horizon": "it reached the time limit",
    "non-finite": "the simulation produced a value that is not finite",
    "step limit": "the simulation reached its step limit",
    "not converged": "the simulation did not reach its accuracy, so the flight counts as failed",
}


def _draw_view(
    root: ET.Element,
    window: Window,
    trajectory: Trajectory,
    scenario: Scenario,
    body: Body | None,
    magnification: int,
    nearest: tuple[int, Approach] | None,
) -> None:
    line = interpolate_positions(trajectory, drawing_times(trajectory))
    seen = window.to_page(line)
    draw_scene(root, window, scenario)
    data = window.path_data(line)
    svg.add_line(root, data, BLUE, 2, "path", stroke_linejoin="round", stroke_linecap="round")
    ink = [resample_polyline(seen, 3), pipe_ink(window, scenario.pipe)]
    if body is not None:
        size = max(body.length, body.max_diameter) * magnification * window.px_per_m
        for t in _choose_times(trajectory, seen, size):
            pale = (tint(BLUE, 0.22), INK, ORANGE)
            corners = draw_silhouette(root, window, body, interpolate_pose(trajectory, t), magnification, pale)
            ink.append(resample_polyline(corners, 4))
    x, y = seen[0]
    svg.add_circle(root, x, y, 4.5, "#ffffff", BLUE, 2, class_="start")

    anchors = np.vstack([seen[:1], window.to_page(scenario.target_array())])
    colours = [INK] * len(scenario.targets)
    if nearest is not None:
        colours[nearest[0]] = VERMILLION
    for (x, y), colour in zip(anchors[1:], colours, strict=True):
        draw_cross(root, x, y, 6, colour)
    if nearest is not None:
        number, approach = nearest
        foot, target = window.to_page(approach.position[None])[0], anchors[1 + number]
        dashes: dict[str, str | float] = {"stroke": VERMILLION, "stroke_width": 1.2, "stroke_dasharray": "3 2"}
        svg.add(root, "path", "", d=svg.path_data([foot, target]), **dashes)
        svg.add_circle(root, foot[0], foot[1], 3.5, "#ffffff", VERMILLION, 1.8, class_="closest")
        ink.append(resample_polyline(np.array([foot, target]), 3))
    names = [("start", MUTED, False)]
    names += [(name, colour, True) for name, colour in zip(scenario.target_names, colours, strict=True)]
    label_points(root, window, anchors, names, ink, keep=9)


def _choose_times(trajectory: Trajectory, seen: FloatArray, size: float) -> list[float]:
    """Return times (s) at equal distances along the path, far enough apart that bodies of ``size`` px do not overlap."""
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(seen, axis=0), axis=1))])
    count = int(np.clip(s[-1] / (1.9 * size), 1, 7))
    # Keep off both ends, where the start and the outlet are.
    wanted = s[-1] * (np.arange(count) + 0.5) / count
    return [float(t) for t in np.interp(wanted, s, drawing_times(trajectory))]
