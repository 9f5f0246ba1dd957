"""The curve of a fleet as SVG: what 1, 2, ... bodies see, beside tracers and perfect steering."""

from itertools import pairwise

import numpy as np

from driftform.figures import layout, style, svg
from driftform_networks.fleets import Fleet

_TOP, _HEIGHT, _LEFT, _LABELS = 88.0, 320.0, 60.0, 210.0


def curve_svg(fleet: Fleet, title: str) -> str:
    """Return the share of the reachable length that fleets of each size see."""
    size = len(fleet.curve)
    root = layout.start_page(
        _TOP + _HEIGHT + 60,
        title,
        "Share of the reachable length that is seen (%), against the number of bodies",
        "Curves of the fleet, of point tracers, of bodies that divide like the water but stay in the pipes, and of the "
        "bound of perfect steering.",
    )
    box = layout.Box(_LEFT, _TOP, layout.WIDTH - layout.MARGIN - _LABELS, _TOP + _HEIGHT)

    def place(count: float, share: float) -> tuple[float, float]:
        across, up = (box.right - box.left) * (count / size), (box.bottom - box.top) * share
        return box.left + across, box.bottom - up

    for percent in range(0, 101, 20):
        _, y = place(0, percent / 100)
        svg.add(root, "line", x1=box.left, y1=y, x2=box.right, y2=y, stroke=style.GRID)
        layout.write(root, box.left - 8, y + 4, f"{percent}", 11, style.MUTED, "end")
    step = next(step for step in (1, 2, 5, 10, 20, 50, 100, 1000) if size / step <= 12 or step == 1000)
    for count in range(0, size + 1, step):
        layout.write(root, place(count, 0)[0], box.bottom + 18, f"{count}", 11, style.MUTED, "middle")
    layout.write(root, box.right, box.bottom + 36, "bodies", 11, style.MUTED, "end")
    lines = [
        ("perfect steering (bound)", fleet.bound, style.MUTED, "5 4"),
        ("this fleet", fleet.curve, style.VERMILLION, ""),
        ("divided like water, retained", fleet.retained, style.BLUE, "5 4"),
        ("point tracers", fleet.tracers, style.BLUE, ""),
    ]
    heights = _spread([place(size, float(curve[-1]))[1] for _, curve, _, _ in lines])
    for (name, curve, colour, dashes), y in zip(lines, heights, strict=True):
        points = [place(count, share) for count, share in enumerate([0.0, *curve.tolist()])]
        svg.add_line(root, svg.path_data(points), colour, 2.2, "curve", stroke_dasharray=dashes)
        ink = style.INK if colour == style.MUTED else colour
        layout.write(root, box.right + 10, y + 4, f"{name} {100 * curve[-1]:.1f}", 12, ink)
    return svg.render(root)


def _spread(heights: list[float], least: float = 16.0) -> list[float]:
    """Return heights of labels that keep a distance from each other, in their order."""
    order, placed = np.argsort(heights), list(heights)
    for above, below in pairwise(order):
        placed[below] = max(placed[below], placed[above] + least)
    return placed
