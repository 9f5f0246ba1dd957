"""6x6 mass matrices of a rigid body, and their change to another reference point."""

import numpy as np

from driftform.types import Coefficients, FloatArray, MassProperties


def cross_matrix(vector: FloatArray) -> FloatArray:
    """Return S with ``S @ b == cross(vector, b)``, (3, 3)."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def rigid_body_mass(mass: MassProperties) -> FloatArray:
    """Return M_RB about the body frame's origin, (6, 6) (Fossen 2011, eq. 3.44)."""
    m, (x, y, z) = mass.mass, mass.cog.tolist()
    matrix = np.array(
        [
            [m, 0.0, 0.0, 0.0, m * z, -m * y],
            [0.0, m, 0.0, -m * z, 0.0, m * x],
            [0.0, 0.0, m, m * y, -m * x, 0.0],
            [0.0, -m * z, m * y, m * y * y + m * z * z, -m * x * y, -m * x * z],
            [m * z, 0.0, -m * x, -m * x * y, m * x * x + m * z * z, -m * y * z],
            [-m * y, m * x, 0.0, -m * x * z, -m * y * z, m * x * x + m * y * y],
        ]
    )
    matrix[3:, 3:] += mass.inertia
    return matrix


def shift_origin(matrix: FloatArray, offset: FloatArray) -> FloatArray:
    """Return a 6x6 matrix about a point that lies at ``offset`` (m) from the one it referred to.

    A' = H^T A H, where H gives the old point's velocity from the new point's: v_old = v_new + w x (old - new).
    Holds for added mass, rigid-body mass and linear damping.
    """
    H = np.eye(6)
    H[:3, 3:] = cross_matrix(offset)
    return np.asarray(H.T @ matrix @ H, dtype=np.float64)


def added_mass_at(coefficients: Coefficients, point: FloatArray) -> FloatArray:
    """Return the added mass about ``point`` of the body frame, (6, 6)."""
    return shift_origin(coefficients.added_mass, point - coefficients.origin)


def largest_added_mass_ratio(mass: MassProperties, coefficients: Coefficients) -> float:
    """Return lambda_max, the largest eigenvalue of M_RB^-1 M_A: the largest ratio of added to own mass in any direction.

    It does not depend on the point that both refer to.
    """
    own, added = rigid_body_mass(mass), added_mass_at(coefficients, np.zeros(3))
    return float(np.linalg.eigvals(np.linalg.solve(own, added)).real.max())
