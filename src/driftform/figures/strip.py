"""Misses under disturbed conditions, a strip per target: the robustness of a result."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from driftform.figures import svg
from driftform.figures.layout import MARGIN, shorten, start_page
from driftform.figures.style import SCREEN, Page
from driftform.types import FloatArray

LEFT, RIGHT, TOP, ROW = 110.0, 110.0, 112.0, 30.0
SMALLEST = 1e-4
"""Smallest miss (m) that is drawn: a logarithmic axis has no zero."""


@dataclass(frozen=True, eq=False)
class Strip:
    """Misses (m) of the best agent for one target.

    Attributes:
        name: of the target.
        nominal: of the undisturbed flight.
        misses: of the disturbed flights, (n,); infinite for failed ones, which are not drawn.
        promised: that 9 of 10 disturbed flights stay within.
    """

    name: str
    nominal: float
    misses: FloatArray
    promised: float


def strip_svg(strips: Sequence[Strip], title: str, subtitle: str, page: Page = SCREEN) -> str:
    """Return the misses as SVG: a dot per disturbed flight, a line at the 90 % miss, a diamond for the nominal one."""
    height = TOP + ROW * len(strips) + 52
    root = start_page(height, title, subtitle, f"{subtitle} A row of dots per target, misses in mm.", page)
    values = np.concatenate([np.zeros(0), *(np.append(s.misses, s.nominal) for s in strips)])
    values = values[np.isfinite(values)]
    shown = np.maximum(values, SMALLEST)
    low = np.floor(np.log10(shown.min(initial=0.1)))
    high = max(np.ceil(np.log10(shown.max(initial=0.1))), low + 1)
    bottom = TOP + ROW * len(strips)

    def x_of(miss: float) -> float:
        share = (np.log10(max(miss, SMALLEST)) - low) / (high - low)
        return float(LEFT + share * (page.width - LEFT - RIGHT))

    rows = {"strips": strips, "row": ROW, "x_of": x_of, "is_finite": np.isfinite}
    names = [shorten(strip.name, 12, LEFT - 30, bold=True) for strip in strips]
    ticks = [(x_of(10.0**power), f"{1000 * 10.0**power:g}") for power in np.arange(low, high + 1)]
    sides = {"left": LEFT, "right": page.width - RIGHT, "top": TOP, "bottom": bottom}
    edges = {"margin": MARGIN, "edge": page.width - MARGIN}
    spots = (0, 150, 300) if page.width > 500 else (0, 80, 170)
    svg.draw_template(root, __package__, "strip", **rows, names=names, ticks=ticks, spots=spots, **sides, **edges)
    return svg.render(root)
