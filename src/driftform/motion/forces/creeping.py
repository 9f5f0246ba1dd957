"""Resistance of a body of revolution to creeping motion (Stokes flow): that of a spheroid as long, with as much surface.

A groove is hardly felt by a creeping flow, so the surface is that of the convex hull. Spheroids have closed forms. Cylinders
have, along and across, 0.97 to 1.07 times what Tirado and Garcia de la Torre computed (J. Chem. Phys. 71, 1979, 2581) for
lengths of 2 to 30 diameters, and 0.76 to 0.83 times their torque (73, 1980, 1986).
"""

import math

from driftform.motion.forces.surfaces import find_hull
from driftform.types import FloatArray

_POWER = 1.6075
"""Of Thomsen's formula for the surface of an ellipsoid, 4 pi ((a^p b^p + a^p c^p + b^p c^p) / 3)^(1/p): within 1.1 %."""


def creeping_resistance(contour: FloatArray) -> tuple[float, float, float, float]:
    """Return :attr:`driftform.types.Drag.creeping` of a body with the meridian ``contour``, m, (n, 2)."""
    hull = find_hull(contour)
    (x0, r0), (x1, r1) = hull[:-1].T, hull[1:].T
    sides = float((r0 + r1) @ ((x1 - x0) ** 2 + (r1 - r0) ** 2) ** 0.5)
    surface = math.pi * (sides + float(hull[[0, -1], 1] @ hull[[0, -1], 1]))
    a = float(hull[-1, 0] - hull[0, 0]) / 2
    half = a**_POWER
    b = (math.sqrt(half * half + 3 * (surface / (4 * math.pi)) ** _POWER) - half) ** (1 / _POWER)
    return *spheroid_resistance(a, b), b * b / (a * a + b * b)


def spheroid_resistance(a: float, b: float) -> tuple[float, float, float]:
    """Return the resistances of a spheroid of half axes ``a`` along and ``b`` across (m) to creeping, over the viscosity.

    They are force over velocity, along and across (m), and torque over the rate of a turn about a transverse axis (m3):
    Happel and Brenner, Low Reynolds Number Hydrodynamics (1965), section 5-11, and Jeffery (1922), with the integrals
    chi = int dx / D and alpha = a b^2 int dx / ((a^2 + x) D), D = (b^2 + x) sqrt(a^2 + x), x from 0 to infinity::

        along 16 pi / (chi + a alpha / b^2)      across 16 pi / (chi + (1 - alpha / 2) / a)
        turn (16 pi / 3) (a^2 + b^2) / (a alpha / b^2 + (1 - alpha / 2) / a)

    >>> [round(k / math.pi, 4) for k in spheroid_resistance(1.0, 1.0)]
    [6.0, 6.0, 8.0]
    >>> [round(k, 3) for k in spheroid_resistance(1e-6, 1.0)]
    [16.0, 10.667, 10.667]
    """
    square = 1 - (b / a) ** 2 if a > b else 1 - (a / b) ** 2
    e = math.sqrt(square)
    if e < 1e-2:
        # The closed forms are small differences of large numbers: of a sphere of the same volume.
        a = b = float((a * b * b) ** (1 / 3))
        chi, alpha = 2 / a, 2 / 3
    elif a > b:
        chi, alpha = 2 * math.atanh(e) / (e * a), 2 * (1 - square) / e**3 * (math.atanh(e) - e)
    else:
        chi, alpha = 2 * math.asin(e) / (e * b), 2 / square * (1 - a / b * math.asin(e) / e)
    along, across = a * alpha / (b * b), (1 - alpha / 2) / a
    turn = (a * a + b * b) / (along + across) / 3
    return 16 * math.pi / (chi + along), 16 * math.pi / (chi + across), 16 * math.pi * turn
