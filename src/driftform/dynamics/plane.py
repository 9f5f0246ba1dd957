"""Motion in the vertical plane: surge, heave and pitch alone, for a fraction of the work of motion in space.

A body of revolution that is released level, in water that flows alike everywhere along a level pipe, never leaves the
plane of its axis and the pipe's: sway, roll and yaw are zero for ever, and so are their forces. What is then left of
:mod:`driftform.dynamics.equations` is written out here: with u, v the velocities relative to the water along the
body's x and z axes, q the pitch rate, and (P_x, P_z, H) = M (u, v, q) the momentum,::

    P_x' = X - P_z q        P_z' = Z + P_x q        H' = N + P_z u - P_x v

X, Z and N are those of weight and buoyancy and of the wall.
"""

import math

import numpy as np

from driftform.dynamics.compiled import compiled
from driftform.dynamics.contact import coplanar_force
from driftform.dynamics.model import (
    BODY_MASS,
    COB,
    COG,
    CURRENT,
    DAMPED,
    DISPLACED_MASS,
    FRICTION,
    GRAVITY,
    INVERSE,
    LINEAR,
    MASS,
    REACH,
    STEADY,
    WATER_LEVEL,
    FlightModel,
)
from driftform.types import FloatArray

PLACES = (0, 2, 3, 5, 7, 9, 11)
"""Places of what changes in a state of 13 numbers: x, z, the quaternion's w and y, the velocities along x and z, q."""

NUMBERS = 23


@compiled
def stays_in_plane(start: FloatArray, model: FlightModel) -> bool:
    """Return True where :func:`slope_in_plane` is all there is to a motion from the state ``start`` (13,).

    Everything that lies across the plane is exactly zero, the water is calm, the pipe is full, straight and at least
    four times as wide as the body reaches (the wall that is near is then the same all along the body), and nothing but
    weight, buoyancy, added mass and the smooth wall acts.
    """
    table, pipe = model.table, model.pipe
    if table[STEADY] == 0.0 or table[WATER_LEVEL] < np.inf or table[DAMPED] != 0.0 or table[FRICTION] != 0.0:
        return False
    if model.strips.shape[0] > 0 or pipe.shape[0] > 1:
        return False
    across = abs(start[4]) + abs(start[6]) + abs(start[8]) + abs(start[10]) + abs(start[12])
    across += abs(table[COG, 1]) + abs(table[COB, 1]) + abs(table[CURRENT, 1])
    for first in range(MASS, LINEAR, 6):
        for i in range(0, 6, 2):
            for j in range(1, 6, 2):
                across += abs(table[first + i, j]) + abs(table[first + j, i])
    if pipe.shape[0] == 1:
        if pipe[0, 7] < 2.0 * table[REACH]:
            return False
        across += abs(pipe[0, 1] - start[1]) + abs(pipe[0, 4])
    return bool(across == 0.0)


@compiled
def plane_model(model: FlightModel) -> FloatArray:
    """Return all numbers that :func:`slope_in_plane` reads but the rims, (23,)."""
    table, out = model.table, np.zeros(NUMBERS)
    place = 0
    for first in (MASS, INVERSE):
        for i in range(0, 6, 2):
            for j in range(i, 6, 2):
                out[place] = table[first + i, j]
                place += 1
    weight, lift = table[BODY_MASS] * table[GRAVITY], table[DISPLACED_MASS] * table[GRAVITY]
    out[12] = weight - lift
    out[13] = weight * table[COG, 2] - lift * table[COB, 2]
    out[14] = weight * table[COG, 0] - lift * table[COB, 0]
    out[15], out[16] = table[CURRENT, 0], table[CURRENT, 2]
    out[17] = math.inf
    if model.pipe.shape[0] == 1:
        # Across the bore runs (-e_z, e_x).
        pipe = model.pipe[0]
        out[17], out[18] = pipe[7], pipe[7] - table[REACH]
        out[19], out[20] = -pipe[5], pipe[3]
        out[21], out[22] = pipe[0], pipe[2]
    return out


@compiled
def slope_in_plane(y: FloatArray, plane: FloatArray, rims: FloatArray, out: FloatArray) -> None:
    """Fill ``out`` (7,) with the rate of ``y`` (7,), the numbers of a state that :data:`PLACES` names.

    ``plane`` is that of :func:`plane_model`, ``rims`` are those of its :class:`FlightModel`.
    """
    w, h, q = y[2], y[3], y[6]
    # The body's axis is (c, -s) in the world, its z axis (s, c).
    double = 2.0 / (w * w + h * h)
    c, s = 1.0 - double * h * h, double * w * h
    along, upward = y[4] - plane[15], y[5] - plane[16]
    u, v = c * along - s * upward, s * along + c * upward
    X, Z, N = plane[12] * s, -plane[12] * c, plane[13] * s + plane[14] * c
    off = plane[19] * (y[0] - plane[21]) + plane[20] * (y[1] - plane[22])
    if abs(off) >= plane[18] and plane[17] < math.inf:
        side = 1.0 if off > 0.0 else -1.0
        n_x, n_z = side * plane[19], side * plane[20]
        tilt, upright = c * n_x - s * n_z, s * n_x + c * n_z
        speed = n_x * y[4] + n_z * y[5]
        # The axis times the normal is -upright along y.
        force, torque, _ = coplanar_force(rims, tilt, plane[17] - side * off, speed, -upright * q)
        X, Z, N = X - force * tilt, Z - force * upright, N + torque * upright
    P_x = plane[0] * u + plane[1] * v + plane[2] * q
    P_z = plane[1] * u + plane[3] * v + plane[4] * q
    X, Z, N = X - P_z * q, Z + P_x * q, N + P_z * u - P_x * v
    a_x = plane[6] * X + plane[7] * Z + plane[8] * N + q * v
    a_z = plane[7] * X + plane[9] * Z + plane[10] * N - q * u
    out[0], out[1] = y[4], y[5]
    out[2], out[3] = -0.5 * h * q, 0.5 * w * q
    out[4], out[5] = c * a_x + s * a_z, c * a_z - s * a_x
    out[6] = plane[8] * X + plane[10] * Z + plane[11] * N
