"""The cavity of a hull that is tuned by it: nowhere nearer to the outside than a wall, and no wider than a bore.

A narrower bore makes the hull heavier, continuously: the cavity stays connected, and a bore prints without support.
"""

from dataclasses import dataclass

import numpy as np

from driftform.agent import solid_of_revolution
from driftform.types import FloatArray
from driftform_frusta.section import DOME_STEP

MIN_BORE = 0.002
"""m: least radius of a bore that stays open in print."""


@dataclass(frozen=True, eq=False)
class Cavity:
    """The widest cavity that a hull may have, and the rooms that it must have; contours as in a body, (n, 2), m."""

    widest: FloatArray
    room: FloatArray

    def narrow(self, bore: float) -> FloatArray:
        """Return the cavity that is no wider than a bore of some radius (m), but for the rooms."""
        from driftform_frusta.envelope import unite_contours

        return unite_contours(_cut_off(self.widest, bore), self.room)

    def measure(self, bore: float) -> float:
        """Return the volume of the cavity with some bore, m3."""
        return solid_of_revolution(self.narrow(bore)).volume

    @property
    def bores(self) -> tuple[float, float]:
        """The radii of the narrowest and of the widest bore, m."""
        widest = float(self.widest[:, 1].max())
        return min(MIN_BORE, widest), widest

    def fit(self, volume: float) -> FloatArray:
        """Return the cavity of some volume (m3) between the least and the greatest."""
        from scipy.optimize import brentq

        least, widest = self.bores
        if volume >= self.measure(widest):
            return self.narrow(widest)
        if volume <= self.measure(least):
            return self.narrow(least)
        bore = brentq(lambda radius: self.measure(radius) - volume, least, widest, xtol=1e-12, rtol=1e-12)
        return self.narrow(float(bore))


def draw_pocket(start: float, x: float, radius: float) -> FloatArray:
    """Return the room of a ball at ``x`` on the axis, and of its way there from ``start`` (m): a bore with a round end."""
    side = 1.0 if x > start else -1.0
    angles = np.arange(0.0, np.pi / 2 + DOME_STEP / 2, DOME_STEP)
    # The polygon encloses the circle.
    corner = radius / np.cos(DOME_STEP / 2)
    end = np.column_stack((x + side * corner * np.sin(angles), corner * np.cos(angles)))
    end[-1, 1] = 0.0
    contour = np.vstack(([(start, 0.0), (start, corner)], end))
    return contour if side > 0 else contour[::-1]


def _cut_off(contour: FloatArray, radius: float) -> FloatArray:
    """Return a contour with what is beyond a radius cut off."""
    x, r = contour.T
    edges = np.flatnonzero(np.diff(r > radius))
    share = (radius - r[edges]) / (r[edges + 1] - r[edges])
    crossings = np.column_stack((x[edges] + share * (x[edges + 1] - x[edges]), np.full(len(edges), radius)))
    cut = np.insert(contour, edges + 1, crossings, axis=0)
    cut[:, 1] = np.minimum(cut[:, 1], radius)
    return cut
