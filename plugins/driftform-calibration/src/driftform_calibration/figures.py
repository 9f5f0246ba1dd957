"""Pictures: films against flights of the model, and drops in a tank."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from driftform.figures import layout, plot, style, svg
from driftform.motion import path
from driftform.types import Body, FloatArray

LEFT, TOP, TALLEST, LOWEST, GAP = 62.0, 138.0, 300.0, 150.0, 88.0
MIDDLE = 420.0
"""Left edge of the plots of distances, px; on a narrower page they are below the paths."""

WIDTH, TITLE, CAPTION = 300.0, 26.0, 20.0
"""Of a picture and of the lines above and below the tank, px."""


@dataclass(frozen=True, eq=False)
class TrackPanel:
    """One track: what was seen, and what the model shows before and after calibration.

    Attributes:
        t: times of the points since the release, s, (n,).
        seen: points of the core in the picture, to the right and up, m, (n, 2); NaN in a column that was not
            measured.
        t_path: times of the paths since the release, s, (k,).
        before, after: paths of the model in the picture, m, (k, 2) each.
        off_before, off_after: distances of the points from the model, m, (n,); NaN where nothing was seen.
    """

    name: str
    t: FloatArray
    seen: FloatArray
    t_path: FloatArray
    before: FloatArray
    after: FloatArray
    off_before: FloatArray
    off_after: FloatArray


def tracks_svg(panels: Sequence[TrackPanel], title: str, subtitle: str, page: style.Page = style.SCREEN) -> str:
    """Return the tracks as SVG: for each the paths, to scale, and the distance of model and film over time.

    If one coordinate alone was measured, it is drawn over time.
    """
    places, top, edge = [], TOP, page.width - layout.MARGIN
    is_wide = page.width > MIDDLE + LOWEST
    right = MIDDLE - 20 if is_wide else edge
    for panel in panels:
        box, window, known = layout.Box(LEFT, top, right, top + LOWEST), None, np.isfinite(panel.seen)
        if known.any(axis=0).all():
            shown = np.vstack([panel.seen[known.all(axis=1)], panel.before, panel.after])
            window = plot.Window.around((0, 1), shown, LEFT, top, right - LEFT, TALLEST, 10)
            box = window.box
        bottom = max(box.bottom, top + LOWEST)
        other = layout.Box(MIDDLE + 50, top, edge, bottom)
        if not is_wide:
            other = layout.Box(LEFT, bottom + GAP - 20, edge, bottom + GAP - 20 + LOWEST)
        places.append((box, window, other))
        top = other.bottom + GAP
    root = layout.start_page(top - GAP + 56, title, subtitle, f"{subtitle} A row for each track.", page)
    svg.draw_template(root, __package__, "tracks", legend=True)
    for panel, (box, window, other) in zip(panels, places, strict=True):
        layout.write(root, LEFT, box.top - 26, layout.shorten(panel.name, 12, 300, bold=True), 12, bold=True)
        most = float(np.nanmax([*panel.off_before, *panel.off_after], initial=1e-6)) * 1050
        chart = _Chart(other, (panel.t[0], panel.t[-1]), (0.0, most))
        lines = [
            svg.path_data(chart.place(panel.t[np.isfinite(off)], 1000 * off[np.isfinite(off)]))
            for off in (panel.off_before, panel.off_after)
        ]
        if window is not None:
            plot.draw_axes(root, window, ("right", "up"))
            paths = [window.path_data(path) for path in (panel.before, panel.after)]
            points = window.to_page(panel.seen[np.isfinite(panel.seen).all(axis=1)])
            drawn: dict[str, Any] = {"heights": None, "paths": paths, "seen": points}
        else:
            drawn = _plot_heights(panel, box)
        distances = {**chart.plot_axes("distance of model and film (mm)"), "lines": lines}
        svg.draw_template(root, __package__, "tracks", legend=False, **drawn, distances=distances)
    return svg.render(root)


def _plot_heights(panel: TrackPanel, box: layout.Box) -> dict[str, Any]:
    """Return what the template draws of the one coordinate that was measured, over time."""
    column = int(np.isfinite(panel.seen).any(axis=0).argmax())
    values = 1000 * np.concatenate([panel.seen[:, column], panel.before[:, column], panel.after[:, column]])
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    room = 0.04 * max(high - low, 1e-6)
    ends = (float(min(panel.t[0], panel.t_path[0])), float(max(panel.t[-1], panel.t_path[-1])))
    chart = _Chart(box, ends, (low - room, high + room))
    paths = [svg.path_data(chart.place(panel.t_path, 1000 * p[:, column])) for p in (panel.before, panel.after)]
    seen = np.isfinite(panel.seen[:, column])
    points = chart.place(panel.t[seen], 1000 * panel.seen[seen, column])
    return {"heights": chart.plot_axes(("right (mm)", "up (mm)")[column]), "paths": paths, "seen": points}


@dataclass(frozen=True)
class _Chart:
    """A quantity over time: its place on the page, and the ranges of time (s) and quantity."""

    box: layout.Box
    times: tuple[float, float]
    range: tuple[float, float]

    def place(self, t: FloatArray, values: FloatArray) -> FloatArray:
        """Return points on the page, (n, 2)."""
        (start, end), (low, high), box = self.times, self.range, self.box
        x = box.left + (box.right - box.left) * (np.asarray(t) - start) / max(end - start, 1e-12)
        y = box.bottom - (box.bottom - box.top) * (np.asarray(values) - low) / max(high - low, 1e-12)
        return np.column_stack([x, y])

    def plot_axes(self, label: str) -> dict[str, Any]:
        """Return what the template draws of the axes: ticks with their values."""
        (start, end), (low, high) = self.times, self.range
        step = layout.floor_to_nice_number(max(high - low, 1e-9) / 3)
        rises = layout.tick_values(low, high, step)
        later = layout.floor_to_nice_number(max(end - start, 1e-9) / 4)
        ticks = layout.tick_values(start, end, later)
        return {
            "box": self.box,
            "label": label,
            "rises": zip(
                self.place(np.full(len(rises), start), rises)[:, 1], layout.label_ticks(rises, step), strict=True
            ),
            "ticks": zip(
                self.place(ticks, np.full(len(ticks), low))[:, 0], layout.label_ticks(ticks, later), strict=True
            ),
        }


def drop_svg(
    title: str, caption: str, body: Body, quaternion: FloatArray, track: FloatArray, tank: tuple[float, float]
) -> str:
    """Return a release as SVG, to scale.

    Args:
        quaternion: attitude of the body at the release, body to world, (4,).
        track: expected path of the core, to the right of the middle of the tank and above the surface, m, (k, 2).
        tank: its length, and the depth of the water, m.
    """
    length, depth = tank
    corners = np.array([[-length / 2, -depth], [length / 2, 0.0]])
    window = plot.Window.around((0, 1), corners, 0.0, TITLE, WIDTH, 420.0, 6.0)
    (left, bottom), (right, top) = window.to_page(corners)
    height = window.box.bottom + CAPTION + 6
    root = svg.start_document(WIDTH, height, title, caption)
    layout.write(root, 6, 16, title, 13, style.INK, bold=True)
    svg.add(root, "rect", class_="water", x=left, y=top, width=right - left, height=bottom - top, fill=style.WATER)
    walls = [(left, top - 8), (left, bottom), (right, bottom), (right, top - 8)]
    svg.add_line(root, svg.path_data(walls), style.WALL, 2.5, "tank")
    svg.add_line(root, window.path_data(track), style.BLUE, 1.8, "path", stroke_dasharray="4 3")
    start = np.array([track[0, 0], 0.0, track[0, 1]])
    colours = (style.tint(style.BLUE, 0.25), style.INK, style.ORANGE)
    pose = path.Pose(start, quaternion)
    plot.draw_silhouette(root, replace(window, view=(0, 2)), body, pose, 1.0, colours)
    layout.draw_scale_bar(root, right - 4, bottom - 8, window.px_per_m, (right - left) / 3, style.MUTED)
    layout.write(root, 6, height - 8, caption, 11, style.MUTED)
    return svg.render(root)


def ruler_svg(length_mm: int = 150) -> str:
    """Return a ruler as SVG whose natural size is its length: to print, and to hang where the agent falls."""
    px = style.PX_PER_MM
    root = svg.start_document((length_mm + 20) * px, 26 * px, "Ruler", f"A ruler of {length_mm} mm.", "mm")
    svg.draw_template(root, __package__, "ruler", px=px, length=length_mm)
    return svg.render(root)
