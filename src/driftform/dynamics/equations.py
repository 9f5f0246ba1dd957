"""Equations of motion of a rigid body in moving water (Kirchhoff's form).

With u the water's velocity at the centre of buoyancy, nu_r = (v, w) the velocity of the body's origin relative to
it, in body axes, and M = M_RB + M_A about that origin, the momentum of body and water is (P, H) = M nu_r, and::

    P' = P x w + F
    H' = H x w + P x v + T

nu_r' = M^-1 (P', H') is exact in a frame that moves with the water: the added mass is solved together with the dry
mass. Where the water accelerates with a, so does the frame, and each mass feels -a: the body's own with m a at the
COG. The displaced water would feel the same, and its pressure gradient therefore carries rho V a at the COB
(Froude and Krylov; Auton, Hunt and Prud'homme, J. Fluid Mech. 197, 1988, with a = Du/Dt). The paper's relative
form has no such term, and takes for a the change of u along the body's path.
"""

import numpy as np

from driftform.dynamics.buoyancy import buoyancy, half_height, slice_depth, submerged
from driftform.dynamics.contact import wall_wrench
from driftform.dynamics.drag import axial_drag, strip_drag
from driftform.dynamics.flow import water
from driftform.dynamics.model import (
    AXIAL_DRAG,
    BODY_MASS,
    COB,
    COG,
    CONTACT_RATE,
    CURRENT,
    DAMPED,
    DAMPING_POINT,
    DENSITY,
    DISPLACED_MASS,
    FRICTION,
    FROUDE_KRYLOV,
    GRAVITY,
    INVERSE,
    LINEAR,
    MASS,
    QUADRATIC,
    REACH,
    STEADY,
    VISCOSITY,
    WATER_LEVEL,
    FlightModel,
)
from driftform.dynamics.vectors import (
    ZERO,
    Rotation,
    Vector,
    Wrench,
    add,
    both,
    cross,
    force_at,
    forward,
    scale,
    subtract,
    to_body,
    to_world,
)
from driftform.types import FloatArray
from driftform.util.compiled import compiled


@compiled
def _vector(row: FloatArray) -> Vector:
    return row[0], row[1], row[2]


@compiled
def _times(matrix: FloatArray, a: Vector, b: Vector) -> tuple[Vector, Vector]:
    """Return the product of a 6x6 matrix with the six-vector (a, b)."""
    return _half(matrix[:3], a, b), _half(matrix[3:], a, b)


@compiled
def _half(rows: FloatArray, a: Vector, b: Vector) -> Vector:
    return _row(rows[0], a, b), _row(rows[1], a, b), _row(rows[2], a, b)


@compiled
def _row(row: FloatArray, a: Vector, b: Vector) -> float:
    return float(
        row[0] * a[0] + row[1] * a[1] + row[2] * a[2] + (row[3] * b[0] + row[4] * b[1] + row[5] * b[2])
    )


@compiled
def damping_wrench(moving: Vector, omega: Vector, table: FloatArray) -> Wrench:
    """Return -D_1 nu - D_2 |nu| nu about the body's origin, both taken at the point that the damping refers to."""
    point = _vector(table[DAMPING_POINT])
    v = add(moving, cross(omega, point))
    linear = _times(table[LINEAR:QUADRATIC], v, omega)
    squares = (v[0] * abs(v[0]), v[1] * abs(v[1]), v[2] * abs(v[2]))
    turns = (omega[0] * abs(omega[0]), omega[1] * abs(omega[1]), omega[2] * abs(omega[2]))
    quadratic = _times(table[QUADRATIC:COG], squares, turns)
    force = scale(-1.0, add(linear[0], quadratic[0]))
    torque = scale(-1.0, add(linear[1], quadratic[1]))
    return force, add(torque, cross(point, force))


@compiled
def drag_wrench(
    height: float, R: Rotation, moving: Vector, omega: Vector, shear: Vector, model: FlightModel
) -> Wrench:
    """Return strip and axial drag about the body's origin, of what is under water.

    ``height`` is that of the body's origin, m; see :func:`driftform.dynamics.drag.strip_drag` for the rest.
    """
    table, strips = model.table, model.strips
    level, centre = table[WATER_LEVEL], _vector(table[COB])
    wrench, under, area = (ZERO, ZERO), 0.0, 0.0
    for k in range(strips.shape[0]):
        wet = 1.0
        if level < np.inf:
            a = half_height(0.5 * strips[k, 1], strips[k, 2], R[2][0])
            wet = submerged(slice_depth(height, R, strips[k, 0], centre, level), a)
        area += strips[k, 1] * strips[k, 2]
        under += strips[k, 1] * strips[k, 2] * wet
        fluid = (table[DENSITY], table[VISCOSITY], wet)
        force = strip_drag(moving, omega, shear, centre[0], fluid, strips[k])
        wrench = both(wrench, force_at((strips[k, 0], 0.0, 0.0), force))
    along = axial_drag(moving[0], table[DENSITY], table[VISCOSITY], table[AXIAL_DRAG]) * under / area
    return both(wrench, ((along, 0.0, 0.0), ZERO))


@compiled
def surroundings(
    t: float, position: Vector, R: Rotation, velocity: Vector, omega: Vector, model: FlightModel
) -> tuple[Vector, Vector, Vector]:
    """Return the water's velocity and acceleration at the COB (world), and its shear along the axis (body frame)."""
    centre = _vector(model.table[COB])
    place = add(position, to_world(R, centre))
    speed, gradient, rate = water(place, t, model.pipe, model.flow, model.gusts)
    # What changes along the water's own path, or along the body's. A gust is given along the path already, and its
    # rate is all of its acceleration: carried across the mean shear once more it would drag a body along the wall.
    path = speed if model.gusts.shape[0] == 0 else ZERO
    if model.table[FROUDE_KRYLOV] == 0.0:
        path = add(velocity, to_world(R, cross(omega, centre)))
    return speed, add(rate, to_world(gradient, path)), to_body(R, to_world(gradient, forward(R)))


@compiled
def accelerations(
    t: float, position: Vector, R: Rotation, velocity: Vector, omega: Vector, model: FlightModel
) -> tuple[Vector, Vector]:
    """Return the acceleration of the body's origin (world, m/s2) and of rotation (body, rad/s2).

    Parameters
    ----------
    t
        time, s.
    position, velocity
        of the body's origin in the world frame, m and m/s.
    R
        rotation, body to world.
    omega
        angular velocity in the body frame, rad/s.
    """
    table = model.table
    stream, change, shear = _vector(table[CURRENT]), ZERO, ZERO
    if table[STEADY] == 0.0:
        stream, change, shear = surroundings(t, position, R, velocity, omega, model)
    moving = to_body(R, subtract(velocity, stream))
    pull = to_body(R, change)
    cog, centre = _vector(table[COG]), _vector(table[COB])
    weight = scale(-table[BODY_MASS], add(scale(table[GRAVITY], R[2]), pull))
    lift, displaced = scale(table[DISPLACED_MASS] * table[GRAVITY], R[2]), table[DISPLACED_MASS]
    wrench = (ZERO, ZERO)
    if table[WATER_LEVEL] < np.inf:
        wrench, volume, x = buoyancy(
            position[2], R, centre, table[WATER_LEVEL], table[DENSITY] * table[GRAVITY], model.slices
        )
        centre, lift, displaced = (x, centre[1], centre[2]), ZERO, table[DENSITY] * volume
    lift = add(lift, scale(displaced * table[FROUDE_KRYLOV], pull))
    wrench = both(wrench, both(force_at(cog, weight), force_at(centre, lift)))
    if table[DAMPED] != 0.0:
        wrench = both(wrench, damping_wrench(moving, omega, table))
    if model.strips.shape[0] > 0:
        wrench = both(wrench, drag_wrench(position[2], R, moving, omega, shear, model))
    wrench = both(
        wrench,
        wall_wrench(
            position,
            R,
            velocity,
            omega,
            model.rims,
            table[REACH],
            model.pipe,
            table[FRICTION],
            table[CONTACT_RATE],
        ),
    )
    momentum, turning = _times(table[MASS:INVERSE], moving, omega)
    force = add(wrench[0], cross(momentum, omega))
    torque = add(wrench[1], add(cross(turning, omega), cross(momentum, moving)))
    v_dot, w_dot = _times(table[INVERSE:LINEAR], force, torque)
    return add(to_world(R, add(v_dot, cross(omega, moving))), change), w_dot
