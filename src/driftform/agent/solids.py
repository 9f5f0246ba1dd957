"""Solids of revolution with a polyline meridian: exact volume integrals, frustum by frustum."""

import numpy as np
import numpy.typing as npt

from driftform.types import FloatArray, Moments

_STATIONS = 0.5 + np.sqrt(0.15) * np.array([[-1.0], [0.0], [1.0]])
_AREA_WEIGHTS = np.pi * (np.array([[5.0], [8.0], [5.0]]) / 18)
"""Gaussian quadrature over (0, 1) with three points, exact for polynomials up to degree five; weights times pi."""


def solid_of_revolution(contour: npt.ArrayLike) -> Moments:
    """Revolve a meridian polyline about the x axis.

    Each edge sweeps a frustum, for which the paper's eq. 11 to 17, 19 and 21 are the integrals along it::

        V   = pi int r^2 dx
        S_1 = pi int x r^2 dx
        S_2 = pi int x^2 r^2 dx
        I_x = pi/2 int r^4 dx

    Along an edge r is linear in x, so the integrands are polynomials of degree four at most, for which Gaussian
    quadrature with three points (Abramowitz & Stegun, 25.4.30) is exact.

    An edge that runs aft (dx < 0) subtracts, so contours that fold back are integrated correctly too. Faces
    normal to the axis contribute nothing.

    Args:
        contour: x and r, m, (n, 2), from the aft axis point to the fore axis point; fewer than two points are an
            empty solid.
    """
    points: FloatArray = np.ascontiguousarray(np.asarray(contour, dtype=np.float64).reshape(-1, 2).T)
    steps = points[:, 1:] - points[:, :-1]
    station, radius = points[:, None, :-1] + _STATIONS * steps[:, None]
    square = radius**2
    slice_volume = _AREA_WEIGHTS * steps[0] * square
    slice_first = slice_volume * station
    return Moments(
        volume=float(slice_volume.sum()),
        first=float(slice_first.sum()),
        second=float(np.vdot(slice_first, station)),
        polar=float(np.vdot(slice_volume, square)) / 2,
    )
