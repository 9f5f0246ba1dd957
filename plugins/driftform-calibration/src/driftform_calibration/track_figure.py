"""Filmed flights against flights of the model, before and after calibration."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from driftform.figures import layout, plot, style, svg
from driftform.types import FloatArray

LEFT, TOP, TALLEST, LOWEST, GAP = 62.0, 138.0, 300.0, 150.0, 88.0
MIDDLE = 420.0
"""Left edge of the plots of distances, px; on a narrower page they are below the paths."""


@dataclass(frozen=True, eq=False)
class TrackPanel:
    """One track: what was seen, and what the model shows before and after calibration.

    Attributes:
        name: of the track.
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
    boxes, top, edge = [], TOP, page.width - layout.MARGIN
    is_wide = page.width > MIDDLE + LOWEST
    right = MIDDLE - 20 if is_wide else edge
    for panel in panels:
        box = layout.Box(LEFT, top, right, top + LOWEST)
        if _is_flat(panel):
            box = _fit_window(panel, top, right).box
        bottom = max(box.bottom, top + LOWEST)
        other = layout.Box(MIDDLE + 50, top, edge, bottom)
        if not is_wide:
            other = layout.Box(LEFT, bottom + GAP - 20, edge, bottom + GAP - 20 + LOWEST)
        boxes.append((box, other))
        top = other.bottom + GAP
    root = layout.start_page(top - GAP + 56, title, subtitle, f"{subtitle} A row for each track.", page)
    svg.draw_template(root, __package__, "tracks", legend=True)
    for panel, (box, other) in zip(panels, boxes, strict=True):
        layout.write(root, LEFT, box.top - 26, layout.shorten(panel.name, 12, 300, bold=True), 12, bold=True)
        most = float(np.nanmax([*panel.off_before, *panel.off_after], initial=1e-6)) * 1050
        chart = _Chart(other, (panel.t[0], panel.t[-1]), (0.0, most))
        lines = [
            svg.path_data(chart.place(panel.t[np.isfinite(off)], 1000 * off[np.isfinite(off)]))
            for off in (panel.off_before, panel.off_after)
        ]
        if _is_flat(panel):
            window = _fit_window(panel, box.top, right)
            plot.draw_axes(root, window, ("right", "up"))
            paths = [window.path_data(path) for path in (panel.before, panel.after)]
            points = window.to_page(panel.seen[np.isfinite(panel.seen).all(axis=1)])
            drawn: dict[str, Any] = {"heights": None, "paths": paths, "seen": points}
        else:
            drawn = _plot_heights(panel, box)
        distances = {**chart.plot_axes("distance of model and film (mm)"), "lines": lines}
        svg.draw_template(root, __package__, "tracks", legend=False, **drawn, distances=distances)
    return svg.render(root)


def _is_flat(panel: TrackPanel) -> bool:
    """True if both coordinates of the picture were measured."""
    return bool(np.isfinite(panel.seen).any(axis=0).all())


def _fit_window(panel: TrackPanel, top: float, right: float) -> plot.Window:
    shown = np.vstack([panel.seen[np.isfinite(panel.seen).all(axis=1)], panel.before, panel.after])
    return plot.Window.around((0, 1), shown, LEFT, top, right - LEFT, TALLEST, 10)


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
            "rises": self._label(self.place(np.full(len(rises), start), rises)[:, 1], rises, step),
            "ticks": self._label(self.place(ticks, np.full(len(ticks), low))[:, 0], ticks, later),
        }

    @staticmethod
    def _label(places: FloatArray, values: FloatArray, step: float) -> list[tuple[float, str]]:
        digits = max(0, -int(np.floor(np.log10(step) + 1e-9)))
        texts = [layout.format_signed(value, digits) for value in values]
        return list(zip(places.tolist(), texts, strict=True))
