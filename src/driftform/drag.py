"""Body -> drag: strips across the axis, friction and blunt ends along it.

Each formula is a function with its source, its range and a checked value. They are those of an engineer's first
estimate: a strip knows nothing of its neighbours, and the two directions nothing of each other. Against measured
bodies it is right to a tenth for cones, discs and cylinders, and to a third for a sphere.
"""

import math

import numpy as np

from driftform.dynamics.drag import friction_coefficient
from driftform.geometry.slices import slices
from driftform.types import Body, Drag, FloatArray

STRIPS = 12
"""Number of strips: with 24 the moment of a spinning cylinder changes by less than a percent."""

REFERENCE_SPEED = 0.3
"""Speed, m/s, at which the friction is taken that decides the drag of the base."""

SEPARATION = math.radians(20)
"""Inclination of a tail against the axis beyond which the flow leaves it (Hoerner, chapter 3: 15 to 20 degrees)."""

SHOULDER = 0.95
"""Part of the greatest radius beyond which the inclination of a nose counts: a small chamfer does not make it sharp."""

_ASPECTS = np.array([1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 40.0])
_ACROSS = np.array([0.64, 0.68, 0.72, 0.74, 0.82, 0.91, 0.98]) / 1.20

BLUNT_BASE = 0.20
"""C_d, on the frontal area, of a base as wide as the body: that of cones as they get slender, extrapolated."""

_HALF_ANGLES = np.radians([0.0, 5.0, 10.0, 15.0, 20.0, 30.0, 37.5, 45.0, 90.0])
_CONES = np.array([0.20, 0.30, 0.40, 0.55, 0.65, 0.80, 1.05, 1.15, 1.17]) - BLUNT_BASE

_AFTERBODIES = np.array([0.0, 0.5, 1.0, 2.0, 4.0, 8.0])
_FLAT_FACED = (np.array([1.17, 1.15, 0.90, 0.85, 0.87, 0.99]) - BLUNT_BASE) / (1.17 - BLUNT_BASE)


def finite_length_factor(aspect: float) -> float:
    """Return the drag of a cylinder across the flow over that of an infinitely long one.

    White, Fluid Mechanics (7th ed.), table 7.3, laminar short cylinders at Re >= 1e4; between its values linear in the
    logarithm of ``aspect``, length over diameter, from 1 to 40, and constant beyond.

    >>> round(1.2 * finite_length_factor(10.0), 2)
    0.82
    """
    return float(np.interp(math.log(aspect), np.log(_ASPECTS), _ACROSS))


def form_factor(slenderness: float) -> float:
    """Return the drag of a streamlined body of revolution over that of its skin's friction.

    Hoerner, Fluid-Dynamic Drag (1965), eq. 6-28: 1 + 1.5 s^1.5 + 7 s^3, with s = diameter over length up to 0.4.
    Anything flatter counts as that: its ends decide, and they are accounted for by themselves.

    >>> round(form_factor(0.2), 4)
    1.1902
    """
    s = min(slenderness, 0.4)
    return float(1 + 1.5 * s**1.5 + 7 * s**3)


def nose_coefficient(half_angle: float, afterbody: float) -> float:
    """Return C_d of a nose that ends in a shoulder, on the frontal area, without that of a base.

    White, table 7.3, at Re >= 1e4: cones of half the full angle with nothing behind them, 90 degrees being the disc,
    less :data:`BLUNT_BASE`, times what an afterbody makes of it by letting the flow come back to the body (flat-faced
    cylinders).

    Parameters
    ----------
    half_angle
        inclination of the nose against the axis at its shoulder, rad, 0 to pi/2.
    afterbody
        length behind the shoulder over diameter, up to 8, as which anything longer counts.

    >>> round(nose_coefficient(math.pi / 6, 0.0) + BLUNT_BASE, 2)
    0.8
    >>> round(nose_coefficient(math.pi / 2, 2.0) + BLUNT_BASE, 2)
    0.85
    """
    cone = float(np.interp(half_angle, _HALF_ANGLES, _CONES))
    return cone * float(np.interp(afterbody, _AFTERBODIES, _FLAT_FACED))


def base_coefficient(diameter_ratio: float, friction: float) -> float:
    """Return C_d of a base, on the frontal area, at most that of a blunt one.

    Hoerner, eq. 3-38: 0.029 (d_b / d)^3 / sqrt(C_df): the boundary layer from ahead thickens the edge of the wake.
    ``friction`` is C_df, that of the forebody on the frontal area.

    >>> round(base_coefficient(1.0, 0.04), 3)
    0.145
    """
    return min(BLUNT_BASE, 0.029 / math.sqrt(friction)) * diameter_ratio**3


def drag_of(body: Body, viscosity: float) -> Drag:
    """Return the drag of a body in water of a kinematic ``viscosity``, m2/s."""
    x, volume, width = slices(body.outer, STRIPS).T
    diameter = 2 * np.sqrt(volume / (math.pi * width))
    factor = finite_length_factor(body.length**2 / float(diameter @ width))
    # What friction there is on a steep face is not along the axis.
    along = np.abs(np.diff(body.outer[:, 0]))
    rubbed = math.pi * float((body.outer[:-1, 1] + body.outer[1:, 1]) @ along)
    return Drag(
        np.column_stack([x, diameter, width, np.full(STRIPS, factor)]),
        friction_area=rubbed * form_factor(body.max_diameter / body.length),
        length=body.length,
        ahead=_end_area(body.outer, rubbed, viscosity),
        astern=_end_area(body.outer[::-1] * (-1.0, 1.0), rubbed, viscosity),
    )


def _end_area(contour: FloatArray, rubbed: float, viscosity: float) -> float:
    """Drag area, m2, of nose and base of a contour that moves towards +x."""
    x, r = contour.T
    radius = float(r.max())
    frontal = math.pi * radius**2
    widest = np.flatnonzero(r > (1 - 1e-9) * radius)
    nose = nose_coefficient(_shoulder(contour[widest[-1] :]), float(x[widest[-1]] - x[0]) / (2 * radius))
    length = float(x.max() - x.min())
    friction = friction_coefficient(REFERENCE_SPEED * length / viscosity) * rubbed / frontal
    base = base_coefficient(_base_radius(contour[widest[0] :: -1]) / radius, friction)
    return frontal * (nose + base)


def _shoulder(nose: FloatArray) -> float:
    """Inclination (rad) of a nose, from its widest point to its tip, over the outermost part of its radius."""
    x, r = nose.T
    inner = SHOULDER * r[0]
    k = int(np.argmax(r < inner))
    u = (r[k - 1] - inner) / (r[k - 1] - r[k])
    along = x[k - 1] + u * (x[k] - x[k - 1]) - x[0]
    return math.atan2(float(r[0] - inner), float(max(along, 0.0)))


def _base_radius(tail: FloatArray) -> float:
    """Radius (m) at which the flow leaves a tail, from its widest point to its end: where it is first too steep."""
    x, r = tail.T
    for k in range(len(tail) - 1):
        if r[k + 1] < r[k] and math.atan2(r[k] - r[k + 1], max(x[k] - x[k + 1], 0.0)) > SEPARATION:
            return float(r[k])
    return 0.0
