"""Vectors and rotations as tuples: kernels that use them allocate nothing and read like the formulas."""

from typing import TypeAlias

import numpy as np

from driftform.types import FloatArray
from driftform.util.compiled import compiled

Vector: TypeAlias = tuple[float, float, float]
"""Components of a vector."""

Rotation: TypeAlias = tuple[Vector, Vector, Vector]
"""Rows of the rotation matrix, body to world."""

Wrench: TypeAlias = tuple[Vector, Vector]
"""Force and torque about the body's origin, in body axes."""

ZERO: Vector = (0.0, 0.0, 0.0)
"""The vector of length 0."""


@compiled
def add(a: Vector, b: Vector) -> Vector:
    """Return a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@compiled
def subtract(a: Vector, b: Vector) -> Vector:
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@compiled
def scale(factor: float, a: Vector) -> Vector:
    """Return the vector times a number."""
    return factor * a[0], factor * a[1], factor * a[2]


@compiled
def dot(a: Vector, b: Vector) -> float:
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def cross(a: Vector, b: Vector) -> Vector:
    """Return the vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@compiled
def norm(a: Vector) -> float:
    """Return the length of a vector."""
    return float(np.sqrt(dot(a, a)))


@compiled
def distance_between(a: Vector, b: Vector) -> float:
    """Return the distance between two points."""
    return norm(subtract(a, b))


@compiled
def to_world(R: Rotation, a: Vector) -> Vector:
    """Return the vector ``a`` of the body frame in the world frame, R a."""
    return dot(R[0], a), dot(R[1], a), dot(R[2], a)


@compiled
def to_body(R: Rotation, a: Vector) -> Vector:
    """Return the vector ``a`` of the world frame in the body frame, R^T a."""
    return add(scale(a[0], R[0]), add(scale(a[1], R[1]), scale(a[2], R[2])))


@compiled
def body_axis(R: Rotation) -> Vector:
    """Return the body's axis in the world frame, R e_x."""
    return R[0][0], R[1][0], R[2][0]


@compiled
def add_wrenches(a: Wrench, b: Wrench) -> Wrench:
    """Return the sum of two wrenches."""
    return add(a[0], b[0]), add(a[1], b[1])


@compiled
def force_wrench(point: Vector, force: Vector) -> Wrench:
    """Return the wrench of a force that acts at a point."""
    return force, cross(point, force)


@compiled
def multiply(matrix: FloatArray, a: Vector, b: Vector) -> tuple[Vector, Vector]:
    """Return the product of a 6x6 matrix with the six-vector (a, b)."""
    return _multiply_half(matrix[:3], a, b), _multiply_half(matrix[3:], a, b)


@compiled
def _multiply_half(rows: FloatArray, a: Vector, b: Vector) -> Vector:
    return _multiply_row(rows[0], a, b), _multiply_row(rows[1], a, b), _multiply_row(rows[2], a, b)


@compiled
def _multiply_row(row: FloatArray, a: Vector, b: Vector) -> float:
    return float(row[0] * a[0] + row[1] * a[1] + row[2] * a[2] + (row[3] * b[0] + row[4] * b[1] + row[5] * b[2]))
