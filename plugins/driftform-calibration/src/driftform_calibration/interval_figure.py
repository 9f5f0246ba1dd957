"""Factors on the model with their intervals, as a calibration found them."""

from collections.abc import Mapping, Sequence

from driftform.figures import svg
from driftform.figures.layout import MARGIN, floor_to_nice_number, shorten, tick_values, write
from driftform.figures.style import BLUE, GRID, INK, MUTED, tint

ROW, NAMES_WIDTH = 30.0, 190.0


def intervals_svg(
    intervals: Mapping[str, tuple[float, float, float]], title: str, unknown: Sequence[str] = ()
) -> str:
    """Return factors as SVG: value, and the interval that holds it with a probability of 90 %; unknown ones at 1.

    ``intervals`` are value, low and high by name.
    """
    count = len(intervals) + len(unknown)
    width, height = 560.0, 92 + ROW * count
    root = svg.start_document(
        width, height, title, "; ".join(f"{n}: {v[0]:.3g}" for n, v in intervals.items())
    )
    write(root, MARGIN, 24, shorten(title, 14, width - 2 * MARGIN, bold=True), 14, bold=True)
    write(
        root, MARGIN, 42, "factor on the model, with its 90 % interval; 1 is the model as it was", 11, MUTED
    )
    values = [v for interval in intervals.values() for v in interval]
    low, high = min([0.8, *values]), max([1.25, *values])
    low, high = low - 0.05 * (high - low), high + 0.05 * (high - low)
    left, right, top = MARGIN + NAMES_WIDTH, width - 76, 60.0

    def x_of(value: float) -> float:
        return float(left + (value - low) / (high - low) * (right - left))

    bottom = top + ROW * count
    for value in tick_values(low, high, floor_to_nice_number((high - low) / 4)):
        svg.add(root, "line", x1=x_of(value), y1=top, x2=x_of(value), y2=bottom, stroke=GRID)
        write(root, x_of(value), bottom + 16, f"{value:g}", 11, MUTED, "middle")
    svg.add(root, "line", x1=x_of(1), y1=top, x2=x_of(1), y2=bottom, stroke=MUTED, stroke_width=1.4)
    for number, name in enumerate([*intervals, *unknown]):
        y = top + ROW * (number + 0.5)
        write(root, left - 14, y + 4, name.replace("_", " "), 12, INK if name in intervals else MUTED, "end")
        if name not in intervals:
            write(root, x_of(1) + 8, y + 4, "not known, left at 1", 11, MUTED, halo=True)
            continue
        value, least, most = intervals[name]
        svg.add(
            root,
            "line",
            class_="interval",
            x1=x_of(least),
            y1=y,
            x2=x_of(most),
            y2=y,
            stroke=tint(BLUE, 0.55),
            stroke_width=7,
        )
        svg.add(root, "circle", class_="value", cx=x_of(value), cy=y, r=4.5, fill=BLUE)
        write(root, width - MARGIN, y + 4, f"{value:.3g}", 12, INK, "end")
    return svg.render(root)
