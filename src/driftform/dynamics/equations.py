"""Equations of motion of a rigid body in a uniform, steady current (Kirchhoff's form).

In the frame that moves with the water, the momentum of body and water is (P, H) = M nu_r, with
M = M_RB + M_A about the body's origin and nu_r the velocity relative to the water, in body axes. Then::

    P' = P x w + F
    H' = H x w + P x v + T

and nu_r' = M^-1 (P', H') is exact: the added mass is solved together with the dry mass.
"""

import numpy as np

from driftform.dynamics.compiled import compiled
from driftform.dynamics.contact import add_wall_forces
from driftform.dynamics.model import (
    COG_COB,
    CURRENT,
    DAMPING_ORIGIN,
    FORCES,
    INVERSE,
    LINEAR,
    MASS,
    QUADRATIC,
)
from driftform.dynamics.rotations import matrix_from_rotation_vector
from driftform.types import FloatArray


@compiled
def add_damping(nu: FloatArray, table: FloatArray, tau: FloatArray) -> None:
    """Add -D_1 nu - D_2 |nu| nu to ``tau`` (6,), both taken at the point that the damping refers to."""
    o = table[DAMPING_ORIGIN]
    local = nu.copy()
    local[0] += nu[4] * o[2] - nu[5] * o[1]
    local[1] += nu[5] * o[0] - nu[3] * o[2]
    local[2] += nu[3] * o[1] - nu[4] * o[0]
    f = np.zeros(6)
    for i in range(6):
        for j in range(6):
            f[i] -= (table[LINEAR + i, j] + table[QUADRATIC + i, j] * abs(local[j])) * local[j]
    for i in range(6):
        tau[i] += f[i]
    tau[3] += o[1] * f[2] - o[2] * f[1]
    tau[4] += o[2] * f[0] - o[0] * f[2]
    tau[5] += o[0] * f[1] - o[1] * f[0]


@compiled
def body_forces(
    position: FloatArray,
    R: FloatArray,
    velocity: FloatArray,
    omega: FloatArray,
    nu: FloatArray,
    table: FloatArray,
    rims: FloatArray,
    pipe: FloatArray,
    tau: FloatArray,
) -> None:
    """Fill ``tau`` (6,) with force and torque about the body's origin, in body axes.

    Gravity acts at the COG, buoyancy at the COB, damping on the velocity ``nu`` relative to the water, the wall
    on the velocity over ground.
    """
    weight, buoyancy = table[FORCES, 0], table[FORCES, 1]
    for i in range(3):
        tau[i] = (buoyancy - weight) * R[2, i]
    # Moment arm of the couple: B cob - W cog, crossed with the upward unit vector in body axes.
    ax = buoyancy * table[COG_COB, 3] - weight * table[COG_COB, 0]
    ay = buoyancy * table[COG_COB, 4] - weight * table[COG_COB, 1]
    az = buoyancy * table[COG_COB, 5] - weight * table[COG_COB, 2]
    tau[3] = ay * R[2, 2] - az * R[2, 1]
    tau[4] = az * R[2, 0] - ax * R[2, 2]
    tau[5] = ax * R[2, 1] - ay * R[2, 0]
    if table[DAMPING_ORIGIN, 3] != 0.0:
        add_damping(nu, table, tau)
    add_wall_forces(position, R, velocity, omega, rims, pipe, tau)


@compiled
def accelerations(
    pose: FloatArray,
    speed: FloatArray,
    table: FloatArray,
    rims: FloatArray,
    pipe: FloatArray,
    out: FloatArray,
) -> None:
    """Fill ``out`` (6,) with the acceleration of the body's origin (world, m/s2) and of rotation (body, rad/s2).

    Parameters
    ----------
    pose
        position in the world frame (m) and rotation vector body to world (rad), (6,).
    speed
        velocity in the world frame (m/s) and angular velocity in the body frame (rad/s), (6,).
    table, rims, pipe
        of a :class:`driftform.dynamics.model.FlightModel`.
    """
    # One allocation instead of five: they would take a fifth of the time.
    work = np.empty(33)
    R, nu, momentum, rate, nu_dot = work[:9].reshape(3, 3), work[9:15], work[15:21], work[21:27], work[27:]
    matrix_from_rotation_vector(pose[3:], R)
    for i in range(3):
        nu[i] = 0.0
        for j in range(3):
            nu[i] += R[j, i] * (speed[j] - table[CURRENT, j])
        nu[3 + i] = speed[3 + i]
    for i in range(6):
        momentum[i] = 0.0
        for j in range(6):
            momentum[i] += table[MASS + i, j] * nu[j]
    body_forces(pose[:3], R, speed[:3], speed[3:], nu, table, rims, pipe, rate)
    vx, vy, vz, wx, wy, wz = nu[0], nu[1], nu[2], nu[3], nu[4], nu[5]
    px, py, pz, hx, hy, hz = momentum[0], momentum[1], momentum[2], momentum[3], momentum[4], momentum[5]
    rate[0] += py * wz - pz * wy
    rate[1] += pz * wx - px * wz
    rate[2] += px * wy - py * wx
    rate[3] += hy * wz - hz * wy + py * vz - pz * vy
    rate[4] += hz * wx - hx * wz + pz * vx - px * vz
    rate[5] += hx * wy - hy * wx + px * vy - py * vx
    for i in range(6):
        nu_dot[i] = 0.0
        for j in range(6):
            nu_dot[i] += table[INVERSE + i, j] * rate[j]
    nu_dot[0] += wy * vz - wz * vy
    nu_dot[1] += wz * vx - wx * vz
    nu_dot[2] += wx * vy - wy * vx
    for i in range(3):
        out[i] = 0.0
        for j in range(3):
            out[i] += R[i, j] * nu_dot[j]
        out[3 + i] = nu_dot[3 + i]
