"""Body -> drag: strips across the axis, friction and blunt ends along it, the wake of a tail, and what a pipe adds.

Each formula is a function with its source, its range and a checked value. They are first engineering estimates: the
strips are independent of each other, and so are the axial and the transverse direction. Bodies that are nearly spheres,
such as the bare core, are not slender: their drag is, in part or whole, that of a sphere.
"""

import math
from collections.abc import Collection
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from driftform.agent import solid_of_revolution
from driftform.motion.forces.creeping import creeping_resistance
from driftform.motion.forces.drag_coefficients import (
    base_coefficient,
    end_shape_factor,
    finite_length_factor,
    form_factor,
    friction_coefficient,
    nose_coefficient,
    sphericity,
)
from driftform.motion.forces.strips import gauss_strips, outer_radii
from driftform.motion.forces.tails import separation_point, wake_section
from driftform.types import Body, Coefficients, Drag, FloatArray

STRIPS = 5
"""Number of strips. They are Gauss points: force and moment on a body that does not turn are exact, and so is the
moment of a slow turn about a point outside the body; a cylinder that spins about its middle has 0.4 % too much."""

STATIONS = 256
"""Number of steps along the axis at which the radius of the body is taken."""

REFERENCE_SPEED = 0.3
"""Speed, m/s, of the friction coefficient from which the drag of the base follows."""

SHOULDER = 0.95
"""Share of the greatest radius outside which the inclination of a nose counts: a small chamfer does not make it sharp."""

SLENDER = 0.92
"""Sphericity below which a body counts as slender: about that of a capsule or a spheroid twice as long as thick.
Cylinders have 0.87 at most, cones 0.79."""

BLUNT = 0.85
"""C_d, on the frontal area, of blunt ends: the least of flat-faced cylinders (White, table 7.3)."""

SHEAR_LIFT = 0.5
"""Lift coefficient, on the volume, of a sphere in weakly sheared inviscid flow (Auton, J. Fluid Mech. 183, 1987)."""


def estimate_drag(body: Body, viscosity: float, wake_factor: float = 1.0, without: Collection[str] = ()) -> Drag:
    """Return the drag of a body in water of kinematic ``viscosity``, m2/s.

    Between a sphericity of :data:`SLENDER` and 1, the drag changes linearly from that of a slender body to a sphere's.

    Args:
        wake_factor: see :func:`wake_factor`; 1 is that of a slender body.
        without: terms to leave out: those of ``drag_without`` in :class:`driftform.interfaces.HydrodynamicsOptions`.
    """
    shape = _measure_shape(body.outer.tobytes(), viscosity)
    sphere = 0.0 if "sphere" in without else max(0.0, (shape.sphericity - SLENDER) / (1 - SLENDER))
    slender, radius = 1 - sphere, body.max_diameter / 2
    strips = shape.strips
    aspect = body.length**2 / float(strips[:, 1] @ strips[:, 2])
    finite = 1.0 if "ends" in without else finite_length_factor(aspect) * end_shape_factor(shape.sphericity, aspect)
    # Blunt ends have the pressure drag that the form factor adds to friction.
    smooth = max(0.0, 1 - (shape.end_ahead + shape.end_astern) / (2 * BLUNT * math.pi * radius**2))
    lift = 0.0 if "wake" in without else slender * wake_factor
    (x_ahead, area_ahead), (x_astern, area_astern) = shape.wake_ahead, shape.wake_astern
    bore = "bore" not in without
    return Drag(
        np.column_stack([strips, np.full(len(strips), slender * finite)]),
        friction_area=slender * shape.rubbed * (1 + (form_factor(body.max_diameter / body.length) - 1) * smooth),
        length=body.length,
        ahead=slender * shape.end_ahead,
        astern=slender * shape.end_astern,
        round_area=sphere * math.pi * radius**2,
        diameter=body.max_diameter,
        centre=shape.centre,
        wake_ahead=(x_ahead, lift * area_ahead),
        wake_astern=(-x_astern, lift * area_astern),
        spin=0.0 if "roll" in without else shape.spin,
        shear_volume=0.0 if "lift" in without else SHEAR_LIFT * shape.volume,
        spread=shape.spread if bore else (0.0, 0.0),
        blocking=body.max_diameter if bore else 0.0,
        creeping=shape.creeping,
        rubbing=1 / finite,
    )


@dataclass(frozen=True, eq=False)
class _Shape:
    """What the drag of a body takes from its contour (SI): see :class:`driftform.types.Drag`.

    ``rubbed`` is the area along which friction acts; ``wake_ahead`` and ``wake_astern`` are those of
    :func:`~driftform.motion.forces.tails.wake_section`.
    """

    sphericity: float
    volume: float
    centre: float
    strips: FloatArray
    rubbed: float
    end_ahead: float
    end_astern: float
    wake_ahead: tuple[float, float]
    wake_astern: tuple[float, float]
    spin: float
    spread: tuple[float, float]
    creeping: tuple[float, float, float, float]


@lru_cache(maxsize=128)
def _measure_shape(outer: bytes, viscosity: float) -> _Shape:
    """Measure an outer contour, (n, 2) as bytes: the same hull is flown under many conditions."""
    contour = np.frombuffer(outer).reshape(-1, 2)
    solid = solid_of_revolution(contour)
    x, r = outer_radii(contour, STATIONS)
    step = float(x[1] - x[0])
    # Friction on a steep face does not act along the axis, so only the area along x counts.
    along = np.abs(np.diff(contour[:, 0]))
    rubbed = math.pi * float((contour[:-1, 1] + contour[1:, 1]) @ along)
    mirrored = contour[::-1] * (-1.0, 1.0)
    centre, square = float(solid.centroid), r * r
    share = square / float(square.sum())
    return _Shape(
        sphericity=sphericity(contour),
        volume=solid.volume,
        centre=centre,
        strips=gauss_strips(x, r, STRIPS),
        rubbed=rubbed,
        end_ahead=_end_area(contour, rubbed, viscosity),
        end_astern=_end_area(mirrored, rubbed, viscosity),
        wake_ahead=wake_section(contour, x, r),
        wake_astern=wake_section(mirrored, -x[::-1], r[::-1]),
        spin=2 * math.pi * step * float(square @ square),
        spread=(float(share @ square) / 4, float(share @ (x - centre) ** 2) + step**2 / 12),
        creeping=creeping_resistance(contour),
    )


def wake_factor(coefficients: Coefficients, displaced: float) -> float:
    """Return (M22 - M11) / (rho V), the factor of the lift on a tail; at least 0.

    A body at a small angle to the flow has the Munk moment (M22 - M11) u v. With the same factor on the lift, a body
    whose flow separates at its greatest section has the moment of slender-body theory, whatever its length.

    Args:
        displaced: mass of the displaced water, kg.
    """
    added = coefficients.added_mass
    return max(0.0, float(added[1, 1] - added[0, 0]) / displaced)


def _end_area(contour: FloatArray, rubbed: float, viscosity: float) -> float:
    """Return the drag area, m2, of nose and base of a contour that moves towards +x."""
    x, r = contour.T
    radius = float(r.max())
    frontal = math.pi * radius**2
    widest = np.flatnonzero(r > (1 - 1e-9) * radius)
    nose = nose_coefficient(_shoulder_angle(contour[widest[-1] :]), float(x[widest[-1]] - x[0]) / (2 * radius))
    length = float(x.max() - x.min())
    friction = friction_coefficient(REFERENCE_SPEED * length / viscosity) * rubbed / frontal
    base = base_coefficient(separation_point(contour)[1] / radius, friction)
    return frontal * (nose + base)


def _shoulder_angle(nose: FloatArray) -> float:
    """Return the inclination (rad) of a nose over the outermost part of its radius; points run from widest to tip."""
    x, r = nose.T
    inner = SHOULDER * r[0]
    k = int(np.argmax(r < inner))
    u = (r[k - 1] - inner) / (r[k - 1] - r[k])
    along = x[k - 1] + u * (x[k] - x[k - 1]) - x[0]
    return math.atan2(float(r[0] - inner), float(max(along, 0.0)))
