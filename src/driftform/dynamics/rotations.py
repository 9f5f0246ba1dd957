"""Rotation vectors, quaternions and matrices, all from the body frame to the world frame."""

import numpy as np

from driftform.dynamics.compiled import compiled
from driftform.types import FloatArray


@compiled
def matrix_from_rotation_vector(vector: FloatArray, out: FloatArray) -> None:
    """Fill ``out`` (3, 3) with the rotation by ``|vector|`` rad about ``vector`` (Rodrigues' formula)."""
    x, y, z = vector[0], vector[1], vector[2]
    square = x * x + y * y + z * z
    if square > 1e-8:
        angle = np.sqrt(square)
        s = np.sin(angle) / angle
        c = (1.0 - np.cos(angle)) / square
    else:
        s = 1.0 - square / 6.0
        c = 0.5 - square / 24.0
    out[0, 0] = 1.0 - c * (y * y + z * z)
    out[0, 1] = c * x * y - s * z
    out[0, 2] = c * x * z + s * y
    out[1, 0] = c * x * y + s * z
    out[1, 1] = 1.0 - c * (x * x + z * z)
    out[1, 2] = c * y * z - s * x
    out[2, 0] = c * x * z - s * y
    out[2, 1] = c * y * z + s * x
    out[2, 2] = 1.0 - c * (x * x + y * y)


def quaternion_from_rotation_vector(vector: FloatArray) -> FloatArray:
    """Return the quaternions (w, x, y, z) of rotation vectors (k, 3), (k, 4)."""
    half = np.linalg.norm(vector, axis=1, keepdims=True) / 2
    # sinc(x) is sin(pi x) / (pi x): finite where the vector vanishes.
    return np.concatenate([np.cos(half), np.sinc(half / np.pi) * vector / 2], axis=1)


def rotation_vector_from_quaternion(quaternion: FloatArray) -> FloatArray:
    """Return the rotation vector (3,) of one unit quaternion, of angle at most pi."""
    w, axis = quaternion[0], quaternion[1:]
    sine = np.linalg.norm(axis)
    if sine < 1e-12:
        return np.asarray(2 * np.sign(w or 1.0) * axis, dtype=np.float64)
    angle = 2 * np.arctan2(sine, abs(w)) * np.sign(w or 1.0)
    return np.asarray(angle * axis / sine, dtype=np.float64)


def matrix_from_quaternion(quaternion: FloatArray) -> FloatArray:
    """Return the rotation matrices of unit quaternions (..., 4), (..., 3, 3)."""
    w, x, y, z = np.moveaxis(np.asarray(quaternion, dtype=np.float64), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))
