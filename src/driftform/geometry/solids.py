"""Solids of revolution with a polyline meridian: exact volume integrals, frustum by frustum."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from driftform.types import FloatArray


@dataclass(frozen=True)
class Moments:
    """Volume integrals of a solid of revolution about the x axis, for unit density, about the frame's origin.

    Attributes
    ----------
    volume
        V, m3.
    first
        integral of x dV, m4.
    second
        integral of x^2 dV, m5.
    polar
        integral of (y^2 + z^2) dV: the inertia about the axis, m5.
    """

    volume: float
    first: float
    second: float
    polar: float

    def __sub__(self, hole: "Moments") -> "Moments":
        return Moments(
            self.volume - hole.volume,
            self.first - hole.first,
            self.second - hole.second,
            self.polar - hole.polar,
        )

    @property
    def centroid(self) -> float:
        """x of the centroid, m."""
        return self.first / self.volume

    @property
    def transverse(self) -> float:
        """Inertia about the y (or z) axis through the origin, for unit density, m5 (eq. 16)."""
        return self.polar / 2 + self.second


def solid_of_revolution(contour: npt.ArrayLike) -> Moments:
    """Revolve a meridian polyline about the x axis.

    Each edge, from (x0, r0) to (x1, r1) with h = x1 - x0, sweeps a frustum, for which the paper's eq. 11 to 17,
    19 and 21 have the closed forms (times pi)::

        V   = h (r0^2 + r0 r1 + r1^2) / 3
        S_1 = x0 V + h^2 (r0^2 + 2 r0 r1 + 3 r1^2) / 12
        S_2 = x0^2 V + x0 h^2 (r0^2 + 2 r0 r1 + 3 r1^2) / 6 + h^3 (r0^2 + 3 r0 r1 + 6 r1^2) / 30
        I_x = h (r0^4 + r0^3 r1 + r0^2 r1^2 + r0 r1^3 + r1^4) / 10

    An edge that runs aft (h < 0) subtracts, so contours that fold back are integrated rightly too. Faces
    normal to the axis add nothing.

    Parameters
    ----------
    contour
        x and r, m, (n, 2), from the aft axis point to the fore axis point; fewer than two points make an empty
        solid.
    """
    points: FloatArray = np.asarray(contour, dtype=np.float64).reshape(-1, 2)
    x0 = points[:-1, 0]
    r0, r1 = points[:-1, 1], points[1:, 1]
    h = points[1:, 0] - x0
    volume = h * (r0 * r0 + r0 * r1 + r1 * r1) / 3
    lever = h * h * (r0 * r0 + 2 * r0 * r1 + 3 * r1 * r1) / 12
    first = x0 * volume + lever
    second = x0 * x0 * volume + 2 * x0 * lever + h**3 * (r0 * r0 + 3 * r0 * r1 + 6 * r1 * r1) / 30
    polar = h * (r0**4 + r0**3 * r1 + r0**2 * r1**2 + r0 * r1**3 + r1**4) / 10
    sums = np.pi * np.array([volume, first, second, polar]).sum(axis=1)
    return Moments(*(float(s) for s in sums))
