"""Factors on the model with their intervals, as a calibration found them."""

from collections.abc import Mapping, Sequence

from driftform.figures import layout, style, svg

ROW, NAMES_WIDTH = 30.0, 190.0


def intervals_svg(
    intervals: Mapping[str, tuple[float, float, float]],
    title: str,
    unknown: Sequence[str] = (),
    page: style.Page = style.SCREEN,
) -> str:
    """Return factors as SVG: value, and the interval that holds it with a probability of 90 %; unknown ones at 1.

    ``intervals`` are value, low and high by name.
    """
    count = len(intervals) + len(unknown)
    width, height = page.width if page.is_paper else 560.0, 92 + ROW * count
    described = "; ".join(f"{name}: {value:.3g}" for name, (value, _, _) in intervals.items())
    root = svg.start_document(width, height, title, described, page=page, header=50)
    if not page.is_paper:
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

    rows = [
        {
            "name": name.replace("_", " "),
            "y": top + ROW * (number + 0.5),
            "interval": [x_of(value) for value in intervals[name]] if name in intervals else None,
            "value": f"{intervals[name][0]:.3g}" if name in intervals else "",
        }
        for number, name in enumerate([*intervals, *unknown])
    ]
    values = layout.tick_values(low, high, layout.floor_to_nice_number((high - low) / 4))
    ticks = [(x_of(value), f"{value:g}") for value in values]
    sides = {"left": left, "bottom": top + ROW * count, "one": x_of(1), "edge": width - layout.MARGIN}
    svg.draw_template(root, __package__, "intervals", rows=rows, ticks=ticks, **sides)
    return svg.render(root)
