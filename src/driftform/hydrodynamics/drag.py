"""Body -> drag: strips across the axis, friction and blunt ends along it.

Each formula is a function with its source, its range and a checked value. They are first engineering estimates: the
strips are independent of each other, and so are the axial and the transverse direction. Bodies that are nearly spheres,
such as the bare core, are not slender: their drag is, in part or whole, that of a sphere.
"""

import math

import numpy as np

from driftform.geometry.slices import slice_solid
from driftform.hydrodynamics.drag_coefficients import (
    base_coefficient,
    finite_length_factor,
    form_factor,
    friction_coefficient,
    nose_coefficient,
    sphericity,
)
from driftform.types import Body, Drag, FloatArray

STRIPS = 12
"""Number of strips: with 24, the moment on a spinning cylinder changes by less than a percent."""

REFERENCE_SPEED = 0.3
"""Speed, m/s, of the friction coefficient from which the drag of the base follows."""

SEPARATION = math.radians(20)
"""Inclination (rad) of a tail against the axis beyond which the flow separates (Hoerner, chapter 3: 15 to 20 degrees)."""

SHOULDER = 0.95
"""Share of the greatest radius outside which the inclination of a nose counts: a small chamfer does not make it sharp."""

SPHERE = 0.445
"""C_d of a sphere, on its frontal area (Clift, Grace and Weber, Bubbles, Drops and Particles, 1978, chapter 5): that of
Newton's law, within 13 % of the standard drag curve for Re from 750 to 3.5e5."""

SLENDER = 0.92
"""Sphericity below which a body counts as slender: about that of a capsule or a spheroid twice as long as thick.
Cylinders have 0.87 at most, cones 0.79."""


def estimate_drag(body: Body, viscosity: float) -> Drag:
    """Return the drag of a body in water of kinematic ``viscosity``, m2/s.

    Between a sphericity of :data:`SLENDER` and 1, the drag changes linearly from that of a slender body to a sphere's.
    """
    sphere = max(0.0, (sphericity(body.outer) - SLENDER) / (1 - SLENDER))
    slender, round_area = 1 - sphere, sphere * SPHERE * math.pi * body.max_diameter**2 / 4
    x, volume, width = slice_solid(body.outer, STRIPS).T
    diameter = 2 * np.sqrt(volume / (math.pi * width))
    finite = finite_length_factor(body.length**2 / float(diameter @ width))
    factor = slender * finite + sphere * SPHERE
    # Friction on a steep face does not act along the axis, so only the area along x counts.
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
    """Return the drag area, m2, of nose and base of a contour that moves towards +x."""
    x, r = contour.T
    radius = float(r.max())
    frontal = math.pi * radius**2
    widest = np.flatnonzero(r > (1 - 1e-9) * radius)
    nose = nose_coefficient(
        _shoulder_angle(contour[widest[-1] :]), float(x[widest[-1]] - x[0]) / (2 * radius)
    )
    length = float(x.max() - x.min())
    friction = friction_coefficient(REFERENCE_SPEED * length / viscosity) * rubbed / frontal
    base = base_coefficient(_base_radius(contour[widest[0] :: -1]) / radius, friction)
    return frontal * (nose + base)


def _shoulder_angle(nose: FloatArray) -> float:
    """Return the inclination (rad) of a nose over the outermost part of its radius; points run from widest to tip."""
    x, r = nose.T
    inner = SHOULDER * r[0]
    k = int(np.argmax(r < inner))
    u = (r[k - 1] - inner) / (r[k - 1] - r[k])
    along = x[k - 1] + u * (x[k] - x[k - 1]) - x[0]
    return math.atan2(float(r[0] - inner), float(max(along, 0.0)))


def _base_radius(tail: FloatArray) -> float:
    """Return the radius (m) at which the flow separates from a tail: where it is first too steep, from its widest point."""
    x, r = tail.T
    for k in range(len(tail) - 1):
        if r[k + 1] < r[k] and math.atan2(r[k] - r[k + 1], max(x[k] - x[k + 1], 0.0)) > SEPARATION:
            return float(r[k])
    return 0.0
