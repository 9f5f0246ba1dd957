"""Steps of a rigid body in water as the programs take them that read our files.

All of them take steps of first order, in which velocities change first, that of the centre of gravity in the world frame,
and the pose changes by the new velocities; these are the steps of DART. Programs that multiply added mass by an
acceleration use that of the previous step, smoothed or not.
"""

import math

from driftform.types import FloatArray
from driftform.util import compiled


@compiled
def fill_path(
    step: float,
    every: int,
    R: FloatArray,
    nu: FloatArray,
    inverse: FloatArray,
    momentum: FloatArray,
    damping: FloatArray,
    added: FloatArray,
    lacking: FloatArray,
    numbers: FloatArray,
    room: FloatArray,
    path: FloatArray,
) -> None:
    """Fill in the displacement of the centre of gravity relative to the water.

    Args:
        step, every: time step, s; steps between two points of the path.
        R, nu: attitude (body to world, (3, 3)) and velocities (body axes, (6,)) at the release; both change.
        inverse: of the mass matrix by which the program divides, (6, 6).
        momentum: matrix of the momenta whose change of direction are Coriolis forces, (6, 6).
        damping: linear and quadratic damping, (2, 6, 6).
        added: added mass that the program multiplies by the acceleration of the previous step, (6, 6).
        lacking: added mass whose force -M_A (w x u) the program lacks in a current u on a body that rotates at w, (6,
            6).
        numbers: weight less buoyancy, and buoyancy (N); centre of buoyancy (m, body axes); u (m/s, world frame);
            weight of the newest acceleration.
        room: work space, (5, 6); its third row is the smoothed acceleration.
        path: to be filled in, m, (n, 3).
    """
    weight, lift, smoothing = numbers[0], numbers[1], numbers[8]
    x, y, z = 0.0, 0.0, 0.0
    for k in range(path.shape[0] * every):
        for i in range(6):
            room[0, i], room[1, i] = 0.0, 0.0
            for j in range(6):
                room[0, i] += momentum[i, j] * nu[j]
                drag = damping[0, i, j] + damping[1, i, j] * abs(nu[j])
                room[1, i] -= drag * nu[j] + added[i, j] * room[2, j]
        for i in range(3):
            room[1, i] -= weight * R[2, i]
            room[3, i] = R[0, i] * numbers[5] + R[1, i] * numbers[6] + R[2, i] * numbers[7]
            room[3, 3 + i], room[4, i], room[4, 3 + i] = lift * R[2, i], 0.0, 0.0
        _add_cross(room[0], 0, nu, 3, room[1], 0)
        _add_cross(room[0], 3, nu, 3, room[1], 3)
        _add_cross(room[0], 0, nu, 0, room[1], 3)
        _add_cross(numbers, 2, room[3], 3, room[1], 3)
        _add_cross(nu, 3, room[3], 0, room[4], 0)
        _add_cross(nu, 3, nu, 0, room[4], 3)
        for i in range(6):
            for j in range(3):
                room[1, i] += lacking[i, j] * room[4, j]
        for i in range(6):
            room[0, i] = 0.0
            for j in range(6):
                room[0, i] += inverse[i, j] * room[1, j]
            room[2, i] += smoothing * (room[0, i] - room[2, i])
        for i in range(3):
            nu[i] += step * (room[0, i] + room[4, 3 + i])
            nu[3 + i] += step * room[0, 3 + i]
        for i in range(3):
            room[3, i] = R[i, 0] * nu[0] + R[i, 1] * nu[1] + R[i, 2] * nu[2]
        x, y, z = x + step * room[3, 0], y + step * room[3, 1], z + step * room[3, 2]
        _turn(R, step * nu[3], step * nu[4], step * nu[5])
        for i in range(3):
            nu[i] = R[0, i] * room[3, 0] + R[1, i] * room[3, 1] + R[2, i] * room[3, 2]
        if (k + 1) % every == 0:
            path[k // every, 0], path[k // every, 1], path[k // every, 2] = x, y, z


@compiled
def _add_cross(a: FloatArray, i: int, b: FloatArray, j: int, out: FloatArray, k: int) -> None:
    """Add the cross product of three numbers of ``a`` from ``i`` and of ``b`` from ``j`` to ``out`` from ``k``."""
    out[k] += a[i + 1] * b[j + 2] - a[i + 2] * b[j + 1]
    out[k + 1] += a[i + 2] * b[j] - a[i] * b[j + 2]
    out[k + 2] += a[i] * b[j + 1] - a[i + 1] * b[j]


@compiled
def _turn(R: FloatArray, p: float, q: float, r: float) -> None:
    """Rotate an attitude by a rotation vector (body axes, rad), by Rodrigues' formula."""
    square = p * p + q * q + r * r
    angle = math.sqrt(square)
    s, c = (math.sin(angle) / angle, (1.0 - math.cos(angle)) / square) if square > 1e-12 else (1.0, 0.5)
    for i in range(3):
        a, b, d = R[i, 0], R[i, 1], R[i, 2]
        # Of the row: times the vector, and its component along the vector.
        u, v, w = b * r - d * q, d * p - a * r, a * q - b * p
        R[i, 0] = a + s * u + c * (v * r - w * q)
        R[i, 1] = b + s * v + c * (w * p - u * r)
        R[i, 2] = d + s * w + c * (u * q - v * p)
