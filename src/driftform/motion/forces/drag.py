"""Forces of viscosity on a body of revolution in relative flow, each as a function of the relative velocity.

Strips across the axis; friction and blunt ends along it; a sphere's drag; the lift on a tail; friction of a spin; the lift
in a shear flow. :class:`driftform.types.Drag` holds their coefficients.
"""

import math

import numpy as np

from driftform.motion.forces.drag_coefficients import (
    crossflow_drag,
    friction_coefficient,
    sphere_excess,
    spin_coefficient,
)
from driftform.types import Drag, FloatArray
from driftform.util.compiled import compiled
from driftform.util.small_vectors import ZERO, Vector, cross, dot, scale

SLOWEST = 1e-150
"""Speed, m/s, below which a motion is rest: its square would be zero, and its Reynolds number a division by zero."""


@compiled
def strip_drag(moving: Vector, omega: Vector, shear: Vector, middle: float, water: Vector, strip: FloatArray) -> Vector:
    """Return the force on one strip, N, in body axes; its component along the axis is zero.

    Args:
        moving: velocity of the body's origin relative to the water at x = ``middle`` (m), m/s.
        omega: angular velocity, rad/s.
        shear: derivative of the water's velocity along the body's axis, 1/s.
        water: density (kg/m3), kinematic viscosity (m2/s) times the square of ``Drag.rubbing``, and the share of the
            strip that is under water.
        strip: a row of :attr:`driftform.types.Drag.strips`.
    """
    x, d = strip[0], strip[1]
    vy = moving[1] + x * omega[2] - (x - middle) * shear[1]
    vz = moving[2] - x * omega[1] - (x - middle) * shear[2]
    drag = crossflow_drag(math.sqrt(vy * vy + vz * vz), water[1] / d)
    f = -0.5 * water[0] * strip[3] * d * strip[2] * water[2] * drag
    return 0.0, f * vy, f * vz


@compiled
def axial_drag(speed: float, density: float, viscosity: float, axial: FloatArray) -> float:
    """Return the force (N) along the axis on a body that moves through the water at ``speed`` (m/s) along its axis.

    ``axial`` holds friction area (m2), length (m), and the drag areas (m2) for motion ahead and astern.
    """
    if abs(speed) < SLOWEST:
        return 0.0
    area = axial[2] if speed > 0.0 else axial[3]
    area += friction_coefficient(abs(speed) * axial[1] / viscosity) * axial[0]
    return float(-0.5 * density * area * abs(speed) * speed)


@compiled
def sphere_drag(velocity: Vector, density: float, viscosity: float, area: float, diameter: float) -> Vector:
    """Return the force (N) on a sphere of frontal ``area`` (m2) with a ``velocity`` (m/s), beyond that of creeping."""
    speed = math.sqrt(dot(velocity, velocity))
    if speed < SLOWEST or area == 0.0:
        return ZERO
    coefficient = sphere_excess(speed * diameter / viscosity)
    return scale(-0.5 * density * coefficient * area * speed, velocity)


@compiled
def creeping_drag(
    there: Vector, omega: Vector, shear: Vector, curl: Vector, viscosity: float, creeping: FloatArray
) -> tuple[Vector, Vector]:
    """Return force (N) and couple (N m) on a body that creeps, in body axes; they rule at low Reynolds numbers.

    The couple vanishes where the axis turns with the water as that of a spheroid does (Jeffery, Proc. R. Soc. A 102, 1922, 161).

    Args:
        there: velocity of the centre of drag relative to the water, m/s.
        omega: angular velocity, rad/s.
        shear, curl: derivative of the water's velocity along the body's axis, and curl of that velocity, 1/s.
        viscosity: dynamic, Pa s.
        creeping: see :attr:`driftform.types.Drag.creeping`.
    """
    along, across, turn = -viscosity * creeping[0], -viscosity * creeping[1], -viscosity * creeping[2]
    share = creeping[3]
    pitch = omega[1] - share * curl[1] + (1.0 - 2.0 * share) * shear[2]
    yaw = omega[2] - share * curl[2] - (1.0 - 2.0 * share) * shear[1]
    return (along * there[0], across * there[1], across * there[2]), (0.0, turn * pitch, turn * yaw)


@compiled
def wake_drag(ahead: float, vy: float, vz: float, density: float, area: float) -> Vector:
    """Return the force (N) on a tail, in body axes: -rho area |u| v cos(alpha / 2), with alpha the angle of attack.

    For a tail of section S and ``area`` = k S (m2), at small angles: the wake takes with it the momentum that the tail
    gave the water across the axis, rho k S v for each metre that it moves (slender-body theory; physically the lift on the
    forebody that the tail does not take back). cos(alpha / 2) is Allen's factor for large angles, where
    rho k S u v cos(alpha / 2) = 1/2 rho V^2 k S sin(2 alpha) cos(alpha / 2) and the drag across the axis,
    1/2 rho V^2 C_d A sin(alpha)^2, add up to the measured force from 0 to 90 degrees (Allen and Perkins, NACA
    Report 1048, 1951; Jorgensen, NASA TN D-6996, 1973).

    Args:
        ahead, vy, vz: velocity of the tail relative to the water along and across the axis, m/s.
    """
    along = abs(ahead)
    square = vy * vy + vz * vz
    speed = math.sqrt(along * along + square)
    if speed < SLOWEST:
        return ZERO
    f = -density * area * along * math.sqrt(0.5 * (1.0 + along / speed))
    return 0.0, f * vy, f * vz


@compiled
def spin_drag(rate: float, density: float, viscosity: float, spin: float, diameter: float) -> float:
    """Return the torque (N m) about the axis of a body that spins at ``rate``, rad/s: -1/2 rho C_f |rate| rate spin.

    ``spin`` is the integral of 2 pi r^4 dx (m5); C_f is that of a cylinder of ``diameter`` (m) in still water.
    """
    if abs(rate) < SLOWEST or spin == 0.0:
        return 0.0
    coefficient = spin_coefficient(0.25 * abs(rate) * diameter * diameter / viscosity)
    return -0.5 * density * coefficient * abs(rate) * rate * spin


@compiled
def shear_lift(moving: Vector, curl: Vector, mass: float, diameter: float) -> Vector:
    """Return the lift (N) on a body in a shear flow: mass (u - v) x curl u / (1 + (G d / w)^4), with w = u - v and G = curl u.

    The formula without its denominator is Auton's (J. Fluid Mech. 183, 1987, 199), for weak shear: G d much smaller than the
    slip w. A smaller slip has no direction over the body: one side leads the water, the other lags. With the full lift there,
    any slip would grow: with the relaxation time tau of drag, w' = G v - w / tau along the flow and v' = C G w across it have a
    growing solution for every tau, and neutral bodies would gather at the wall, where simulations of such bodies in turbulent
    water find only a layer as thick as a body that has more of them (Costa, Picano, Brandt and Breugem, J. Fluid Mech. 843, 2018,
    450). The fourth power keeps 99 % of the lift at G d / w = 0.3. It is a choice, not a measurement; with the square bodies are
    spread as evenly.

    Args:
        moving: -w at the body's centre, m/s.
        curl: of the water's velocity, 1/s.
        mass: rho V times the lift coefficient, kg; that of a sphere is 1/2.
        diameter: d, m.
    """
    slip, weak = dot(moving, moving), diameter * diameter * dot(curl, curl)
    if slip < SLOWEST:
        return ZERO
    return scale(mass * slip * slip / (slip * slip + weak * weak), cross(curl, moving))


def still_water_wrench(drag: Drag, moving: Vector, omega: Vector, density: float, viscosity: float) -> FloatArray:
    """Return force (N) and torque (N m) about the body's origin of a motion through still, open water, (6,).

    ``moving`` is the velocity of the origin (m/s), ``omega`` the angular velocity (rad/s), both in body axes.
    """
    _, q, r = omega
    out = np.zeros(6)

    def push(force: Vector, x: float) -> None:
        out[:3] += force
        out[4:] += (-x * force[2], x * force[1])

    def velocity_at(x: float) -> Vector:
        return moving[0], moving[1] + x * r, moving[2] - x * q

    rubbing = viscosity * drag.rubbing**2
    for strip in drag.strips:
        push(strip_drag(moving, omega, ZERO, 0.0, (density, rubbing, 1.0), strip), float(strip[0]))
    axial = np.array([drag.friction_area, drag.length, drag.ahead, drag.astern])
    out[0] += axial_drag(moving[0], density, viscosity, axial)
    there = velocity_at(drag.centre)
    push(sphere_drag(there, density, viscosity, drag.round_area, drag.diameter), drag.centre)
    force, couple = creeping_drag(there, omega, ZERO, ZERO, density * viscosity, np.array(drag.creeping))
    push(force, drag.centre)
    out[3:] += couple
    x, area = drag.wake_ahead if moving[0] > 0 else drag.wake_astern
    push(wake_drag(*velocity_at(x), density, area), x)
    out[3] += spin_drag(omega[0], density, viscosity, drag.spin, drag.diameter)
    return out
