"""Equations of motion of a rigid body in moving water (Kirchhoff's form).

With u the water's velocity at the centre of buoyancy, nu_r = (v, w) the velocity of the body's origin relative to
it, in body axes, and M = M_RB + M_A about that origin, the momentum of body and water is (P, H) = M nu_r, and::

    P' = P x w + F
    H' = H x w + P x v + T

nu_r' = M^-1 (P', H') is exact in a frame that moves with the water: the added mass is solved together with the dry
mass. If the water accelerates with a, so does the frame, and an inertial force acts on each mass: -m a at the COG for
the body's own. It would act on the displaced water as well, whose pressure gradient therefore exerts rho V a at the
COB (Froude and Krylov; Auton, Hunt and Prud'homme, J. Fluid Mech. 197, 1988, with a = Du/Dt). The paper's relative
form lacks this term, and uses for a the change of u along the body's path.
"""

import numpy as np

from driftform.motion.forces.buoyancy import buoyancy, half_height, slice_depth, submerged_share
from driftform.motion.forces.contact import wall_wrench
from driftform.motion.forces.drag import (
    axial_drag,
    creeping_drag,
    shear_lift,
    sphere_drag,
    spin_drag,
    strip_drag,
    wake_drag,
)
from driftform.motion.forces.drag_coefficients import blockage_factor
from driftform.motion.forces.model import FlightModel
from driftform.types import FloatArray
from driftform.util.compiled import compiled
from driftform.util.small_vectors import (
    ZERO,
    Rotation,
    Vector,
    Wrench,
    add,
    add_wrenches,
    body_axis,
    cross,
    force_wrench,
    multiply,
    scale,
    subtract,
    to_body,
    to_world,
)
from driftform.water.parts.stream import bore_radius
from driftform.water.velocity import gust_at, water_motion


@compiled
def _read_vector(row: FloatArray) -> Vector:
    return row[0], row[1], row[2]


@compiled
def damping_wrench(moving: Vector, omega: Vector, n: np.record) -> Wrench:
    """Return -D_1 nu - D_2 |nu| nu about the body's origin; nu is taken at the point that the damping refers to."""
    point = _read_vector(n.damping_point)
    v = add(moving, cross(omega, point))
    linear = multiply(n.linear, v, omega)
    squares = (v[0] * abs(v[0]), v[1] * abs(v[1]), v[2] * abs(v[2]))
    turns = (omega[0] * abs(omega[0]), omega[1] * abs(omega[1]), omega[2] * abs(omega[2]))
    quadratic = multiply(n.quadratic, squares, turns)
    force = scale(-1.0, add(linear[0], quadratic[0]))
    torque = scale(-1.0, add(linear[1], quadratic[1]))
    return force, add(torque, cross(point, force))


@compiled
def drag_wrench(
    height: float,
    R: Rotation,
    moving: Vector,
    omega: Vector,
    shear: Vector,
    model: FlightModel,
    bore: float = np.inf,
    curl: Vector = ZERO,
) -> Wrench:
    """Return drag and the lift of the tail, of the part under water, about the body's origin.

    ``height`` is that of the body's origin, ``bore`` the radius of the pipe around it, m; see
    :func:`driftform.motion.forces.drag.creeping_drag` for the other arguments.
    """
    n, strips = model.numbers[0], model.strips
    level, centre = n.water_level, _read_vector(n.cob)
    density, viscosity = n.density, n.viscosity
    rubbing = viscosity * n.rubbing * n.rubbing
    wrench, share = (ZERO, ZERO), 1.0
    if level < np.inf:
        under, area = 0.0, 0.0
        for k in range(strips.shape[0]):
            a = half_height(0.5 * strips[k, 1], strips[k, 2], R[2][0])
            wet = submerged_share(slice_depth(height, R, strips[k, 0], centre, level), a)
            area += strips[k, 1] * strips[k, 2]
            under += strips[k, 1] * strips[k, 2] * wet
            force = strip_drag(moving, omega, shear, centre[0], (density, rubbing, wet), strips[k])
            wrench = add_wrenches(wrench, force_wrench((strips[k, 0], 0.0, 0.0), force))
        share = under / area
    else:
        for k in range(strips.shape[0]):
            x = strips[k, 0]
            force = strip_drag(moving, omega, shear, centre[0], (density, rubbing, 1.0), strips[k])
            wrench = (
                (0.0, wrench[0][1] + force[1], wrench[0][2] + force[2]),
                (0.0, wrench[1][1] - x * force[2], wrench[1][2] + x * force[1]),
            )
    along = axial_drag(moving[0], density, viscosity, n.axial) * share
    wrench = add_wrenches(wrench, ((along, 0.0, 0.0), ZERO))
    there = _velocity_at(n.centre, moving, omega, shear, centre[0])
    force, couple = creeping_drag(there, omega, shear, curl, density * viscosity * share, n.creeping)
    wrench = add_wrenches(wrench, add_wrenches(force_wrench((n.centre, 0.0, 0.0), force), (ZERO, couple)))
    if n.round_area > 0.0:
        force = sphere_drag(there, density, viscosity, n.round_area * share, n.diameter)
        wrench = add_wrenches(wrench, force_wrench((n.centre, 0.0, 0.0), force))
    if n.blocking > 0.0:
        factor = blockage_factor(0.5 * n.blocking / bore)
        wrench = scale(factor, wrench[0]), scale(factor, wrench[1])
    tail = 0 if moving[0] > 0.0 else 2
    x = n.tails[tail]
    there = _velocity_at(x, moving, omega, shear, centre[0])
    force = wake_drag(moving[0], there[1], there[2], density, n.tails[tail + 1] * share)
    spinning = spin_drag(omega[0], density, viscosity, n.spin, n.diameter) * share
    wrench = add_wrenches(wrench, force_wrench((x, 0.0, 0.0), force))
    return add_wrenches(wrench, (ZERO, (spinning, 0.0, 0.0)))


@compiled
def _bore_around(position: Vector, pipe: FloatArray, fittings: FloatArray | None) -> float:
    """Return the radius of the bore around a position, m, infinite in open water."""
    if fittings is not None:
        return bore_radius(position, fittings)
    return pipe[0, 7] if pipe.shape[0] > 0 else np.inf


@compiled
def _velocity_at(x: float, moving: Vector, omega: Vector, shear: Vector, middle: float) -> Vector:
    """Return the velocity relative to the water of the point at ``x`` of the axis; see :func:`drag_wrench`."""
    along = x - middle
    return (moving[0], moving[1] + x * omega[2] - along * shear[1], moving[2] - x * omega[1] - along * shear[2])


@compiled
def water_motion_at_cob(
    t: float, position: Vector, R: Rotation, velocity: Vector, omega: Vector, model: FlightModel
) -> tuple[Vector, Vector, Vector, Vector]:
    """Return the water's velocity (m/s) and acceleration (m/s2) at the COB, world frame; shear and curl, body frame.

    The shear is the derivative of the water's velocity along the body's axis, 1/s.
    """
    n = model.numbers[0]
    centre = _read_vector(n.cob)
    place = add(position, to_world(R, centre))
    spread = (body_axis(R), n.spread_across, n.spread_along)
    mean, gradient, rate = water_motion(place, t, model.pipe, model.flow, spread, model.fittings)
    gust, change, along = gust_at(place, mean, model.pipe, model.flow, model.gusts, model.eddies, model.fittings)
    speed, rate = add(mean, gust), add(rate, change)
    # The velocity of the path along which the water's velocity changes: the water's own, or the body's.
    path = speed
    if n.has_pressure_gradient == 0.0:
        path = add(velocity, to_world(R, cross(omega, centre)))
    shear = to_body(R, add(to_world(gradient, body_axis(R)), along))
    curl = (gradient[2][1] - gradient[1][2], gradient[0][2] - gradient[2][0], gradient[1][0] - gradient[0][1])
    return speed, add(rate, to_world(gradient, path)), shear, to_body(R, curl)


@compiled
def wrench_in_water(
    t: float, position: Vector, R: Rotation, velocity: Vector, omega: Vector, model: FlightModel
) -> tuple[Wrench, Vector, Vector]:
    """Return the wrench on the body in a frame that moves with the water, the velocity relative to it, and its acceleration.

    The wrench (N, N m, about the origin) is that of weight, buoyancy, pressure gradient, damping, drag and the wall, in body
    axes as the velocity (m/s); the water's acceleration is in the world frame (m/s2). See :func:`accelerations`.
    """
    n = model.numbers[0]
    stream, change, shear, curl = _read_vector(n.current), ZERO, ZERO, ZERO
    if n.is_steady == 0.0:
        stream, change, shear, curl = water_motion_at_cob(t, position, R, velocity, omega, model)
    moving = to_body(R, subtract(velocity, stream))
    pull = to_body(R, change)
    cog, centre = _read_vector(n.cog), _read_vector(n.cob)
    weight = scale(-n.body_mass, add(scale(n.gravity, R[2]), pull))
    lift, displaced = scale(n.displaced_mass * n.gravity, R[2]), n.displaced_mass
    wrench = (ZERO, ZERO)
    if n.water_level < np.inf:
        wrench, volume, x = buoyancy(position[2], R, centre, n.water_level, n.density * n.gravity, model.slices)
        centre, lift, displaced = (x, centre[1], centre[2]), ZERO, n.density * volume
    lift = add(lift, scale(displaced * n.has_pressure_gradient, pull))
    wrench = add_wrenches(wrench, add_wrenches(force_wrench(cog, weight), force_wrench(centre, lift)))
    if n.is_damped != 0.0:
        wrench = add_wrenches(wrench, damping_wrench(moving, omega, n))
    if model.strips.shape[0] > 0:
        bore = _bore_around(position, model.pipe, model.fittings)
        wrench = add_wrenches(wrench, drag_wrench(position[2], R, moving, omega, shear, model, bore, curl))
        if n.is_steady == 0.0 and n.shear_volume > 0.0:
            there = add(moving, cross(omega, centre))
            mass = n.density * n.shear_volume * displaced / n.displaced_mass
            wrench = add_wrenches(wrench, force_wrench(centre, shear_lift(there, curl, mass, n.diameter)))
    return add_wrenches(wrench, wall_wrench(position, R, velocity, omega, model)), moving, change


@compiled
def accelerations(
    t: float, position: Vector, R: Rotation, velocity: Vector, omega: Vector, model: FlightModel
) -> tuple[Vector, Vector]:
    """Return the acceleration of the body's origin (world frame, m/s2) and the angular one (body frame, rad/s2).

    Args:
        t: time, s.
        position, velocity: of the body's origin in the world frame, m and m/s.
        R: rotation, body to world.
        omega: angular velocity in the body frame, rad/s.
    """
    n = model.numbers[0]
    wrench, moving, change = wrench_in_water(t, position, R, velocity, omega, model)
    momentum, turning = multiply(n.mass, moving, omega)
    force = add(wrench[0], cross(momentum, omega))
    torque = add(wrench[1], add(cross(turning, omega), cross(momentum, moving)))
    v_dot, w_dot = multiply(n.inverse, force, torque)
    return add(to_world(R, add(v_dot, cross(omega, moving))), change), w_dot
