"""Formulas for the drag of parts of a body of revolution, each with its source, its range and a checked value."""

import math

import numpy as np

from driftform.agent import solid_of_revolution
from driftform.types import FloatArray
from driftform.util.compiled import compiled

CROSSFLOW_PLATEAU = 1.18
"""C_d of a long cylinder across the flow at Reynolds numbers from 3e4 to 2e5."""

CROSSFLOW_FRICTION = 1.96
"""Friction of a cylinder across the flow: its C_d times sqrt(Re)."""

LAMINAR_BELOW = 5e5
"""Reynolds number (on length) at which a boundary layer becomes turbulent."""

_FRONT = LAMINAR_BELOW * 0.075 / (math.log10(LAMINAR_BELOW) - 2.0) ** 2 - 1.328 * math.sqrt(LAMINAR_BELOW)
"""A of :func:`friction_coefficient`."""


@compiled
def crossflow_drag(speed: float, scale: float) -> float:
    """Return C_d times ``speed`` (m/s) of a long cylinder across the flow; ``scale`` is viscosity over diameter, m/s.

    C_d on the diameter is 1.18 + 1.96 / sqrt(Re), with Re = speed / scale, less what creeping motion adds: two terms of the
    fit of Sucker and Brauer (Waerme- und Stoffuebertragung 8, 1975, 149) to long cylinders, up to Re = 2e5: it leaves out the
    drag crisis. Their 6.8 / Re^0.89 is the creeping flow about a cylinder without ends, for which
    :mod:`driftform.motion.forces.creeping` has that of the whole body. Their dip of 0.33 about Re = 1700, of flow that is the
    same all along a cylinder, is left out: Hoelzer and Sommerfeld (2008) found none in the drag of bodies.

    >>> [round(crossflow_drag(re, 1.0) / re, 2) for re in (1.0, 100.0, 1000.0, 1e5)]
    [3.14, 1.38, 1.24, 1.19]
    """
    return CROSSFLOW_PLATEAU * speed + CROSSFLOW_FRICTION * math.sqrt(speed * scale)


@compiled
def sphere_excess(reynolds: float) -> float:
    """Return C_d of a sphere, on its frontal area, less what creeping motion has, 24 / Re; Re must be positive.

    C_d is 24 / Re (1 + 0.15 Re^0.687) + 0.42 / (1 + 42500 Re^(-1.16)): Clift and Gauvin (1970), in Clift, Grace and Weber,
    Bubbles, Drops and Particles (1978), table 5.1: within 6 % of the standard drag curve for Re (on the diameter) below 3e5,
    where the drag crisis begins.

    >>> [round(24 / re + sphere_excess(re), 3) for re in (1.0, 1000.0, 1e5)]
    [27.6, 0.466, 0.492]
    """
    return float(3.6 * reynolds ** (-0.313) + 0.42 / (1.0 + 42500.0 * reynolds ** (-1.16)))


@compiled
def spin_coefficient(reynolds: float) -> float:
    """Return C_f of a cylinder that spins about its axis in still water: shear stress over rho (omega r)^2 / 2.

    Theodorsen and Regier, NACA Report 793 (1944): 1/sqrt(C_f) = -0.6 + 4.07 log10(Re sqrt(C_f)), with Re = omega r^2 / nu;
    here solved for C_f as (3.507 log10 Re - 2.565)^-2, within 2 % for Re from 1e3 to 1e6. Below Re = 40 it is inversely
    proportional to Re, as for laminar flow (where it is 4 / Re), and continuous. The constants -0.6 and 4.07 were not
    checked against the report.

    >>> round(spin_coefficient(1e4), 4), round(spin_coefficient(1e6), 5)
    (0.0076, 0.00293)
    """
    if reynolds <= 0.0:
        return math.inf
    clipped = max(reynolds, 40.0)
    root = 3.507 * math.log10(clipped) - 2.565
    return clipped / reynolds / (root * root)


@compiled
def blockage_factor(ratio: float) -> float:
    """Return the ratio of the drag of a body in a tube to that in open water: (1 + 1.45 b^4.5) / (1 - b^2)^2.

    Achenbach, J. Fluid Mech. 65 (1974), 113: for a sphere on the axis, b from 0.5 to 0.92, Re from 3e4; at small b it is
    the square of the speed-up in the gap. ``ratio`` is b, the diameter of the body over that of the bore; from 0.95 on it
    counts as 0.95. The constants 1.45 and 4.5 were not checked against the paper.

    >>> round(blockage_factor(0.1), 4), round(blockage_factor(0.5), 3)
    (1.0204, 1.892)
    """
    b = min(ratio, 0.95)
    square = b * b
    free = 1.0 - square
    return (1.0 + 1.45 * square * square * math.sqrt(b)) / (free * free)


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
    # The square is a product: numba compiles a function for powers, which can raise an exception.
    root = math.log10(reynolds) - 2.0
    return 0.075 / (root * root) - _FRONT / reynolds


_ASPECTS = np.array([1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 40.0])


_ACROSS = np.array([0.64, 0.68, 0.72, 0.74, 0.82, 0.91, 0.98]) / CROSSFLOW_PLATEAU


BLUNT_BASE = 0.20
"""C_d, on the frontal area, of a base as wide as the body: that of cones, extrapolated to slender ones."""


_HALF_ANGLES = np.radians([0.0, 5.0, 10.0, 15.0, 20.0, 30.0, 37.5, 45.0, 90.0])


_CONES = np.array([0.20, 0.30, 0.40, 0.55, 0.65, 0.80, 1.05, 1.15, 1.17]) - BLUNT_BASE


_AFTERBODIES = np.array([0.0, 0.5, 1.0, 2.0, 4.0, 8.0])


_FLAT_FACED = (np.array([1.17, 1.15, 0.90, 0.85, 0.87, 0.99]) - BLUNT_BASE) / (1.17 - BLUNT_BASE)


def finite_length_factor(aspect: float) -> float:
    """Return the ratio of the drag of a cylinder with flat ends across the flow to that of an infinitely long one.

    White, Fluid Mechanics (7th ed.), table 7.3, laminar short cylinders at Re >= 1e4; interpolated linearly in the
    logarithm of ``aspect``, length over diameter, from 1 to 40, and constant outside. Where the coefficient of a long
    cylinder is :data:`CROSSFLOW_PLATEAU`, the drag is that of the table.

    >>> round(CROSSFLOW_PLATEAU * finite_length_factor(10.0), 2)
    0.82
    """
    return float(np.interp(math.log(aspect), np.log(_ASPECTS), _ACROSS))


def end_shape_factor(sphericity: float, aspect: float) -> float:
    """Return the ratio of the drag across the axis to that of a cylinder with flat ends.

    Hoelzer and Sommerfeld, Powder Technology 184 (2008), 361: at high Reynolds numbers C_d, on the projected area, is
    0.42 x 10^(0.4 (-log10 sphericity)^0.2). The ratio is that of this formula for the body and for the cylinder of the
    same ``aspect``, whose sphericity is (12 aspect)^(2/3) / (4 aspect + 2).

    >>> round(end_shape_factor(0.874, 1.0), 3), round(end_shape_factor(1.0, 1.0), 2)
    (1.0, 0.59)
    """
    flat = (12 * aspect) ** (2 / 3) / (4 * aspect + 2)
    own, cylinder = (max(0.0, -math.log10(phi)) ** 0.2 for phi in (min(sphericity, 1.0), flat))
    return float(10 ** (0.4 * (own - cylinder)))


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

    Args:
        half_angle: inclination of the nose against the axis at its shoulder, rad, 0 to pi/2.
        afterbody: length behind the shoulder over diameter, up to 8; longer ones count as 8.

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
