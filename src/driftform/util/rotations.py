"""Rotation vectors, quaternions and matrices, all from the body frame to the world frame."""

import numpy as np

from driftform.types import FloatArray
from driftform.util.compiled import compiled
from driftform.util.small_vectors import Rotation


@compiled
def rotation_from_vector(x: float, y: float, z: float) -> Rotation:
    """Return the rotation by ``|(x, y, z)|`` rad about (x, y, z) (Rodrigues' formula)."""
    square = x * x + y * y + z * z
    if square > 1e-8:
        angle = np.sqrt(square)
        s = np.sin(angle) / angle
        c = (1.0 - np.cos(angle)) / square
    else:
        s = 1.0 - square / 6.0
        c = 0.5 - square / 24.0
    return (
        (1.0 - c * (y * y + z * z), c * x * y - s * z, c * x * z + s * y),
        (c * x * y + s * z, 1.0 - c * (x * x + z * z), c * y * z - s * x),
        (c * x * z - s * y, c * y * z + s * x, 1.0 - c * (x * x + y * y)),
    )


@compiled
def rotation_from_quaternion(w: float, x: float, y: float, z: float) -> Rotation:
    """Return the rotation of a quaternion, whose length may be any but zero."""
    c = 2.0 / (w * w + x * x + y * y + z * z)
    return (
        (1.0 - c * (y * y + z * z), c * (x * y - w * z), c * (x * z + w * y)),
        (c * (x * y + w * z), 1.0 - c * (x * x + z * z), c * (y * z - w * x)),
        (c * (x * z - w * y), c * (y * z + w * x), 1.0 - c * (x * x + y * y)),
    )


@compiled
def quaternion_product(
    w: float, x: float, y: float, z: float, W: float, X: float, Y: float, Z: float
) -> tuple[float, float, float, float]:
    """Return the product of the quaternions (w, x, y, z) and (W, X, Y, Z): the second turn, then the first."""
    return (
        w * W - x * X - y * Y - z * Z,
        w * X + x * W + y * Z - z * Y,
        w * Y - x * Z + y * W + z * X,
        w * Z + x * Y - y * X + z * W,
    )


@compiled
def quaternion_rate(
    w: float, x: float, y: float, z: float, p: float, q: float, r: float
) -> tuple[float, float, float, float]:
    """Return q' = q (0, omega) / 2 of a quaternion that turns with omega = (p, q, r), rad/s in the body frame."""
    return (
        -0.5 * (x * p + y * q + z * r),
        0.5 * (w * p + y * r - z * q),
        0.5 * (w * q + z * p - x * r),
        0.5 * (w * r + x * q - y * p),
    )


def quaternion_from_rotation_vector(vector: FloatArray) -> FloatArray:
    """Return the quaternions (w, x, y, z) of rotation vectors (k, 3), (k, 4)."""
    half = np.linalg.norm(vector, axis=1, keepdims=True) / 2
    # sinc(x) is sin(pi x) / (pi x): finite for a vector of zero.
    return np.concatenate([np.cos(half), np.sinc(half / np.pi) * vector / 2], axis=1)


def rotation_vector_from_quaternion(quaternion: FloatArray) -> FloatArray:
    """Return the rotation vector (rad, (3,)) of a unit quaternion; its angle is at most pi."""
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
