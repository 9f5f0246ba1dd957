"""Drag of a slender body in relative flow: strips across the axis; friction and blunt ends along it."""

import math

from driftform.dynamics.vectors import ZERO, Vector
from driftform.hydrodynamics.drag_coefficients import crossflow_coefficient, friction_coefficient
from driftform.types import FloatArray
from driftform.util.compiled import compiled


@compiled
def strip_drag(
    moving: Vector, omega: Vector, shear: Vector, middle: float, water: Vector, strip: FloatArray
) -> Vector:
    """Return the force on one strip, N, in body axes; its component along the axis is zero.

    Parameters
    ----------
    moving
        velocity of the body's origin relative to the water at x = ``middle`` (m), m/s.
    omega
        angular velocity, rad/s.
    shear
        derivative of the water's velocity along the body's axis, 1/s.
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
    """Return the force (N) along the axis on a body that moves through the water at ``speed`` (m/s) along its axis.

    ``axial`` holds friction area (m2), length (m), and the drag areas (m2) for motion ahead and astern.
    """
    if speed == 0.0:
        return 0.0
    area = axial[2] if speed > 0.0 else axial[3]
    reynolds = abs(speed) * axial[1] / viscosity
    if reynolds > 0.0:
        area += friction_coefficient(reynolds) * axial[0]
    return float(-0.5 * density * area * abs(speed) * speed)
