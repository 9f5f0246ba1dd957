"""Drag of a slender body in relative flow: strips across the axis, friction and blunt ends along it."""

import math

import numpy as np

from driftform.dynamics.compiled import compiled
from driftform.dynamics.vectors import ZERO, Vector
from driftform.types import FloatArray

LAMINAR_BELOW = 5e5
"""Reynolds number (on length) at which a boundary layer becomes turbulent."""


@compiled
def crossflow_coefficient(reynolds: float) -> float:
    """Return C_d of a long circular cylinder across the flow, on its diameter: 1 + 10 Re^(-2/3).

    White, Viscous Fluid Flow, eq. 3-225, for Re (on the diameter) from 1 to 2e5; without the drag crisis.

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

    Blasius' 1.328 / sqrt(Re) while the layer is laminar. Beyond it, the ITTC 1957 line 0.075 / (log10 Re - 2)^2 less
    A / Re for the laminar part at the front (after Prandtl), with A such that the two meet. Valid to Re = 1e9.

    >>> round(friction_coefficient(1e5), 5), round(friction_coefficient(1e7), 5)
    (0.0042, 0.00282)
    """
    if reynolds <= 0.0:
        return math.inf
    if reynolds < LAMINAR_BELOW:
        return 1.328 / math.sqrt(reynolds)
    front = LAMINAR_BELOW * 0.075 / (math.log10(LAMINAR_BELOW) - 2.0) ** 2 - 1.328 * math.sqrt(LAMINAR_BELOW)
    return 0.075 / (math.log10(reynolds) - 2.0) ** 2 - front / reynolds


@compiled
def strip_drag(
    moving: Vector, omega: Vector, shear: Vector, middle: float, water: Vector, strip: FloatArray
) -> Vector:
    """Return the force on one strip, N, in body axes; it has no component along the axis.

    Parameters
    ----------
    moving
        velocity of the body's origin relative to the water at x = ``middle`` (m), m/s.
    omega
        angular velocity, rad/s.
    shear
        change of the water's velocity along the body's axis, 1/s.
    water
        density (kg/m3), kinematic viscosity (m2/s), and the share of the strip that is under water.
    strip
        a row of :attr:`driftform.types.Drag.strips`.
    """
    x, d = strip[0], strip[1]
    vy = moving[1] + x * omega[2] - (x - middle) * shear[1]
    vz = moving[2] - x * omega[1] - (x - middle) * shear[2]
    speed = math.sqrt(vy * vy + vz * vz)
    if speed == 0.0:
        return ZERO
    coefficient = strip[3] * crossflow_coefficient(speed * d / water[1])
    f = -0.5 * water[0] * coefficient * d * strip[2] * speed * water[2]
    return 0.0, f * vy, f * vz


@compiled
def axial_drag(speed: float, density: float, viscosity: float, axial: FloatArray) -> float:
    """Return the force (N) along the axis on a body that moves at ``speed`` (m/s) through the water along it.

    ``axial`` holds friction area (m2), length (m), and the drag areas ahead and astern (m2).
    """
    if speed == 0.0:
        return 0.0
    area = axial[2] if speed > 0.0 else axial[3]
    reynolds = abs(speed) * axial[1] / viscosity
    if reynolds > 0.0:
        area += friction_coefficient(reynolds) * axial[0]
    return float(-0.5 * density * area * abs(speed) * speed)
