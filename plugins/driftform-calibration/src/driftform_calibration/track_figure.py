"""Filmed flights against flights of the model, before and after calibration."""

from collections.abc import Sequence
from dataclasses import dataclass
from xml.etree import ElementTree as ET

import numpy as np

from driftform.figures import layout, plot, style, svg
from driftform.types import FloatArray

LEFT, TOP, TALLEST, LOWEST, GAP = 62.0, 138.0, 300.0, 150.0, 88.0
MIDDLE = 420.0
"""Left edge of the plots of distances, px."""


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


def tracks_svg(panels: Sequence[TrackPanel], title: str, subtitle: str) -> str:
    """Return the tracks as SVG: for each the paths, to scale, and the distance of model and film over time.

    If one coordinate alone was measured, it is drawn over time.
    """
    boxes, top = [], TOP
    for panel in panels:
        box = layout.Box(LEFT, top, MIDDLE - 20, top + LOWEST)
        if _is_flat(panel):
            box = _fit_window(panel, top).box
        boxes.append(box)
        top = max(box.bottom, top + LOWEST) + GAP
    root = layout.start_page(top - GAP + 56, title, subtitle, f"{subtitle} A row for each track.")
    _draw_legend(root)
    for panel, box in zip(panels, boxes, strict=True):
        layout.write(root, LEFT, box.top - 26, layout.shorten(panel.name, 12, 300, bold=True), 12, bold=True)
        if _is_flat(panel):
            _draw_paths(root, panel, _fit_window(panel, box.top))
        else:
            _draw_heights(root, panel, box)
        right = layout.Box(
            MIDDLE + 50, box.top, layout.WIDTH - layout.MARGIN, max(box.bottom, box.top + LOWEST)
        )
        most = float(np.nanmax([*panel.off_before, *panel.off_after], initial=1e-6)) * 1050
        chart = _Chart(right, (float(panel.t[0]), float(panel.t[-1])), (0.0, most))
        chart.draw_axes(root, "distance of model and film (mm)")
        for off, line in ((panel.off_before, BEFORE), (panel.off_after, AFTER)):
            seen = np.isfinite(off)
            chart.draw_line(root, panel.t[seen], 1000 * off[seen], "distance", line)
    return svg.render(root)


def _is_flat(panel: TrackPanel) -> bool:
    """True if both coordinates of the picture were measured."""
    return bool(np.isfinite(panel.seen).any(axis=0).all())


def _fit_window(panel: TrackPanel, top: float) -> plot.Window:
    shown = np.vstack([panel.seen[np.isfinite(panel.seen).all(axis=1)], panel.before, panel.after])
    return plot.Window.around((0, 1), shown, LEFT, top, MIDDLE - LEFT - 20, TALLEST, 10)


def _draw_paths(root: ET.Element, panel: TrackPanel, window: plot.Window) -> None:
    plot.draw_axes(root, window, ("right", "up"))
    for path, name, line in ((panel.before, "before", BEFORE), (panel.after, "after", AFTER)):
        line.draw(root, window.path_data(path), name)
    for x, y in window.to_page(panel.seen[np.isfinite(panel.seen).all(axis=1)]):
        svg.add_circle(root, x, y, 1.8, style.INK, class_="seen")


def _draw_heights(root: ET.Element, panel: TrackPanel, box: layout.Box) -> None:
    column = int(np.isfinite(panel.seen).any(axis=0).argmax())
    values = 1000 * np.concatenate([panel.seen[:, column], panel.before[:, column], panel.after[:, column]])
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    room = 0.04 * max(high - low, 1e-6)
    ends = (float(min(panel.t[0], panel.t_path[0])), float(max(panel.t[-1], panel.t_path[-1])))
    chart = _Chart(box, ends, (low - room, high + room))
    chart.draw_axes(root, ("right (mm)", "up (mm)")[column])
    for path, name, line in ((panel.before, "before", BEFORE), (panel.after, "after", AFTER)):
        chart.draw_line(root, panel.t_path, 1000 * path[:, column], name, line)
    seen = np.isfinite(panel.seen[:, column])
    for x, y in chart.place(panel.t[seen], 1000 * panel.seen[seen, column]):
        svg.add_circle(root, x, y, 1.8, style.INK, class_="seen")


@dataclass(frozen=True)
class _Line:
    colour: str
    width: float
    dashes: str

    def draw(self, root: ET.Element, data: str, name: str) -> None:
        svg.add_line(root, data, self.colour, self.width, name, stroke_dasharray=self.dashes)


BEFORE = _Line(style.tint(style.VERMILLION, 0.8), 1.6, "5 3")
AFTER = _Line(style.BLUE, 2.0, "none")


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

    def draw_axes(self, root: ET.Element, label: str) -> None:
        (start, end), (low, high), box = self.times, self.range, self.box
        step = layout.floor_to_nice_number(max(high - low, 1e-9) / 3)
        for value in layout.tick_values(low, high, step):
            y = self.place(np.array([start]), np.array([value]))[0, 1]
            svg.add(root, "line", x1=box.left - 4, y1=y, x2=box.right, y2=y, stroke=style.GRID)
            text = layout.format_signed(value, _count_digits(step))
            layout.write(root, box.left - 8, y + 4, text, 11, style.MUTED, "end")
        step = layout.floor_to_nice_number(max(end - start, 1e-9) / 4)
        for value in layout.tick_values(start, end, step):
            x = self.place(np.array([value]), np.array([low]))[0, 0]
            svg.add(root, "line", x1=x, y1=box.bottom, x2=x, y2=box.bottom + 4, stroke=style.MUTED)
            text = layout.format_signed(value, _count_digits(step))
            layout.write(root, x, box.bottom + 17, text, 11, style.MUTED, "middle")
        layout.write(root, box.right, box.bottom + 32, "t (s)", 11, style.MUTED, "end")
        layout.write(root, box.left - 8, box.top - 10, label, 11, style.MUTED)

    def draw_line(self, root: ET.Element, t: FloatArray, values: FloatArray, name: str, line: _Line) -> None:
        line.draw(root, svg.path_data(self.place(t, values)), name)


def _count_digits(step: float) -> int:
    return max(0, -int(np.floor(np.log10(step) + 1e-9)))


def _draw_legend(root: ET.Element) -> None:
    y = 82.0
    for x, line, text in ((22.0, BEFORE, "model before"), (180.0, AFTER, "calibrated")):
        ends = svg.path_data([(x, y - 4), (x + 26, y - 4)])
        svg.add_line(root, ends, line.colour, 2, stroke_dasharray=line.dashes)
        layout.write(root, x + 32, y, text, 12, style.INK)
    svg.add(root, "circle", cx=324, cy=y - 4, r=2.5, fill=style.INK)
    layout.write(root, 334, y, "film", 12, style.INK)
