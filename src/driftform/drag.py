"""Body -> drag: strips across the axis, friction and blunt ends along it.

Each formula is a function with its source, its range and a checked value. They are those of an engineer's first
estimate: a strip knows nothing of its neighbours, and the two directions nothing of each other. Bodies that are nearly
spheres, as the bare core is one, are no slender ones: their drag is, in part or whole, that of a sphere.
"""

import math

import numpy as np

from driftform.dynamics.drag import friction_coefficient
from driftform.geometry import solid_of_revolution
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

SPHERE = 0.445
"""C_d of a sphere, on its frontal area (Clift, Grace and Weber, Bubbles, Drops and Particles, 1978, chapter 5): that of
Newton's law, within 13 % of the standard drag curve for Re from 750 to 3.5e5."""

SLENDER = 0.92
"""Sphericity below which a body has nothing of a sphere: about that of a capsule or a spheroid twice as long as thick.
Cylinders have 0.87 at most, cones 0.79."""

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


def sphericity(contour: FloatArray) -> float:
    """Return the surface of the sphere of a solid's volume over the solid's own surface, 1 for a sphere.

    Wadell, Journal of Geology 43 (1935), 250. ``contour`` is the meridian, m, (n, 2).

    >>> flat = np.array([(0.0, 0.0), (0.0, 1.0), (2.0, 1.0), (2.0, 0.0)])
    >>> round(sphericity(flat), 3)
    0.874
    """
    edges = np.diff(contour, axis=0)
    surface = math.pi * float((contour[:-1, 1] + contour[1:, 1]) @ np.hypot(edges[:, 0], edges[:, 1]))
    return float(np.cbrt(math.pi * (6 * solid_of_revolution(contour).volume) ** 2) / surface)


def drag_of(body: Body, viscosity: float) -> Drag:
    """Return the drag of a body in water of a kinematic ``viscosity``, m2/s.

    From a sphericity of :data:`SLENDER` to one of 1 it goes over, linearly, into that of a sphere.
    """
    sphere = max(0.0, (sphericity(body.outer) - SLENDER) / (1 - SLENDER))
    slender, round_area = 1 - sphere, sphere * SPHERE * math.pi * body.max_diameter**2 / 4
    x, volume, width = slices(body.outer, STRIPS).T
    diameter = 2 * np.sqrt(volume / (math.pi * width))
    finite = finite_length_factor(body.length**2 / float(diameter @ width))
    factor = slender * finite + sphere * SPHERE
    # What friction there is on a steep face is not along the axis.
    along = np.abs(np.diff(body.outer[:, 0]))
    rubbed = math.pi * float((body.outer[:-1, 1] + body.outer[1:, 1]) @ along)
    return Drag(
        np.column_stack([x, diameter, width, np.full(STRIPS, factor)]),
        friction_area=slender * rubbed * form_factor(body.max_diameter / body.length),
        length=body.length,
        ahead=slender * _end_area(body.outer, rubbed, viscosity) + round_area,
        astern=slender * _end_area(body.outer[::-1] * (-1.0, 1.0), rubbed, viscosity) + round_area,
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
