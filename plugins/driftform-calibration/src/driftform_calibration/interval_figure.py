"""Factors on the model with their intervals, as a calibration found them."""

from collections.abc import Mapping, Sequence

from driftform.figures import layout, style, svg

ROW, NAMES_WIDTH = 30.0, 190.0


def intervals_svg(
    intervals: Mapping[str, tuple[float, float, float]], title: str, unknown: Sequence[str] = ()
) -> str:
    """Return factors as SVG: value, and the interval that holds it with a probability of 90 %; unknown ones at 1.

    ``intervals`` are value, low and high by name.
    """
    count = len(intervals) + len(unknown)
    width, height = 560.0, 92 + ROW * count
    values = "; ".join(f"{name}: {value:.3g}" for name, (value, _, _) in intervals.items())
    root = svg.start_document(width, height, title, values)
    heading = layout.shorten(title, 14, width - 2 * layout.MARGIN, bold=True)
    layout.write(root, layout.MARGIN, 24, heading, 14, bold=True)
    note = "factor on the model, with its 90 % interval; 1 is the model as it was"
    layout.write(root, layout.MARGIN, 42, note, 11, style.MUTED)
    shown = [v for interval in intervals.values() for v in interval]
    low, high = min([0.8, *shown]), max([1.25, *shown])
    low, high = low - 0.05 * (high - low), high + 0.05 * (high - low)
    left, right, top = layout.MARGIN + NAMES_WIDTH, width - 76, 60.0

    def x_of(value: float) -> float:
        return float(left + (value - low) / (high - low) * (right - left))

    bottom = top + ROW * count
    for value in layout.tick_values(low, high, layout.floor_to_nice_number((high - low) / 4)):
        svg.add_segment(root, x_of(value), top, x_of(value), bottom, style.GRID)
        layout.write(root, x_of(value), bottom + 16, f"{value:g}", 11, style.MUTED, "middle")
    svg.add_segment(root, x_of(1), top, x_of(1), bottom, style.MUTED, 1.4)
    for number, name in enumerate([*intervals, *unknown]):
        y = top + ROW * (number + 0.5)
        ink = style.INK if name in intervals else style.MUTED
        layout.write(root, left - 14, y + 4, name.replace("_", " "), 12, ink, "end")
        if name not in intervals:
            layout.write(root, x_of(1) + 8, y + 4, "not known, left at 1", 11, style.MUTED, halo=True)
            continue
        value, least, most = intervals[name]
        pale = style.tint(style.BLUE, 0.55)
        svg.add_segment(root, x_of(least), y, x_of(most), y, pale, 7, class_="interval")
        svg.add_circle(root, x_of(value), y, 4.5, style.BLUE, class_="value")
        layout.write(root, width - layout.MARGIN, y + 4, f"{value:.3g}", 12, style.INK, "end")
    return svg.render(root)
