"""Formulas for the drag of parts of a body of revolution, each with its source, its range and a checked value."""

import math

import numpy as np

from driftform.geometry import solid_of_revolution
from driftform.types import FloatArray
from driftform.util.compiled import compiled

LAMINAR_BELOW = 5e5
"""Reynolds number (on length) at which a boundary layer becomes turbulent."""


@compiled
def crossflow_coefficient(reynolds: float) -> float:
    """Return C_d of a long circular cylinder across the flow, on its diameter: 1 + 10 Re^(-2/3).

    White, Viscous Fluid Flow, eq. 3-225, for Re (on the diameter) from 1 to 2e5; it leaves out the drag crisis.

    >>> crossflow_coefficient(1000.0)
    1.1
    """
    if reynolds <= 0.0:
        return math.inf
    root = float(np.cbrt(reynolds))
    return 1.0 + 10.0 / (root * root)


@compiled
def friction_coefficient(reynolds: float) -> float:
    """Return the mean skin friction coefficient C_f of a flat plate, on its wetted area.

    Blasius' 1.328 / sqrt(Re) if the layer is laminar. Otherwise the ITTC 1957 line 0.075 / (log10 Re - 2)^2 less
    A / Re for the laminar part at the front (after Prandtl), with A such that the two are continuous. Valid to Re = 1e9.

    >>> round(friction_coefficient(1e5), 5), round(friction_coefficient(1e7), 5)
    (0.0042, 0.00282)
    """
    if reynolds <= 0.0:
        return math.inf
    if reynolds < LAMINAR_BELOW:
        return 1.328 / math.sqrt(reynolds)
    front = LAMINAR_BELOW * 0.075 / (math.log10(LAMINAR_BELOW) - 2.0) ** 2 - 1.328 * math.sqrt(LAMINAR_BELOW)
    return 0.075 / (math.log10(reynolds) - 2.0) ** 2 - front / reynolds


_ASPECTS = np.array([1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 40.0])


_ACROSS = np.array([0.64, 0.68, 0.72, 0.74, 0.82, 0.91, 0.98]) / 1.20


BLUNT_BASE = 0.20
"""C_d, on the frontal area, of a base as wide as the body: that of cones, extrapolated to slender ones."""


_HALF_ANGLES = np.radians([0.0, 5.0, 10.0, 15.0, 20.0, 30.0, 37.5, 45.0, 90.0])


_CONES = np.array([0.20, 0.30, 0.40, 0.55, 0.65, 0.80, 1.05, 1.15, 1.17]) - BLUNT_BASE


_AFTERBODIES = np.array([0.0, 0.5, 1.0, 2.0, 4.0, 8.0])


_FLAT_FACED = (np.array([1.17, 1.15, 0.90, 0.85, 0.87, 0.99]) - BLUNT_BASE) / (1.17 - BLUNT_BASE)


def finite_length_factor(aspect: float) -> float:
    """Return the ratio of the drag of a cylinder across the flow to that of an infinitely long one.

    White, Fluid Mechanics (7th ed.), table 7.3, laminar short cylinders at Re >= 1e4; interpolated linearly in the
    logarithm of ``aspect``, length over diameter, from 1 to 40, and constant outside.

    >>> round(1.2 * finite_length_factor(10.0), 2)
    0.82
    """
    return float(np.interp(math.log(aspect), np.log(_ASPECTS), _ACROSS))


def form_factor(slenderness: float) -> float:
    """Return the ratio of the drag of a streamlined body of revolution to its skin friction.

    Hoerner, Fluid-Dynamic Drag (1965), eq. 6-28: 1 + 1.5 s^1.5 + 7 s^3, with s = diameter over length up to 0.4.
    Flatter bodies count as 0.4: their ends dominate, and have terms of their own in the drag.

    >>> round(form_factor(0.2), 4)
    1.1902
    """
    s = min(slenderness, 0.4)
    return float(1 + 1.5 * s**1.5 + 7 * s**3)


def nose_coefficient(half_angle: float, afterbody: float) -> float:
    """Return C_d of a nose that ends in a shoulder, on the frontal area, without the drag of a base.

    White, table 7.3, at Re >= 1e4: cones without an afterbody by their half angle (90 degrees is the disc), less
    :data:`BLUNT_BASE`, times the factor of an afterbody, to which the flow reattaches (flat-faced cylinders).

    Parameters
    ----------
    half_angle
        inclination of the nose against the axis at its shoulder, rad, 0 to pi/2.
    afterbody
        length behind the shoulder over diameter, up to 8; longer ones count as 8.

    >>> round(nose_coefficient(math.pi / 6, 0.0) + BLUNT_BASE, 2)
    0.8
    >>> round(nose_coefficient(math.pi / 2, 2.0) + BLUNT_BASE, 2)
    0.85
    """
    cone = float(np.interp(half_angle, _HALF_ANGLES, _CONES))
    return cone * float(np.interp(afterbody, _AFTERBODIES, _FLAT_FACED))


def base_coefficient(diameter_ratio: float, friction: float) -> float:
    """Return C_d of a base, on the frontal area, at most that of a blunt base.

    Hoerner, eq. 3-38: 0.029 (d_b / d)^3 / sqrt(C_df): the boundary layer of the forebody thickens the edge of the wake.
    ``friction`` is C_df, the friction drag coefficient of the forebody on the frontal area.

    >>> round(base_coefficient(1.0, 0.04), 3)
    0.145
    """
    return min(BLUNT_BASE, 0.029 / math.sqrt(friction)) * diameter_ratio**3


def sphericity(contour: FloatArray) -> float:
    """Return the surface of the sphere of equal volume over the surface of a solid; 1 for a sphere.

    Wadell, Journal of Geology 43 (1935), 250. ``contour`` is the meridian, m, (n, 2).

    >>> flat = np.array([(0.0, 0.0), (0.0, 1.0), (2.0, 1.0), (2.0, 0.0)])
    >>> round(sphericity(flat), 3)
    0.874
    """
    edges = np.diff(contour, axis=0)
    surface = math.pi * float((contour[:-1, 1] + contour[1:, 1]) @ np.hypot(edges[:, 0], edges[:, 1]))
    return float(np.cbrt(math.pi * (6 * solid_of_revolution(contour).volume) ** 2) / surface)
