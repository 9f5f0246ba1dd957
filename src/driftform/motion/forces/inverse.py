"""The inverse of a 6x6 mass matrix."""

import math

import numpy as np

from driftform.types import FloatArray
from driftform.util.compiled import compiled

_DEFINITE = 1e-9
"""Least inertia in a direction, relative to the largest, for which no eigenvalues are needed."""


def invert_mass(total: FloatArray, length: float) -> FloatArray:
    """Invert a 6x6 mass matrix in units of kg and ``length`` (m), so that its blocks are of similar size.

    A direction without inertia (roll of a massless body) gets an acceleration of zero instead of an infinite one. The
    inverse of a matrix that is not finite is NaN, and the flight fails at its first step.
    """
    inverse = np.empty((6, 6))
    if not _invert_definite(total, length, np.empty((2, 6, 6)), inverse):
        if not np.isfinite(total).all():
            return np.full((6, 6), np.nan)
        scale = np.array([[1.0], [1.0], [1.0], [1 / length], [1 / length], [1 / length]])
        values, vectors = np.linalg.eigh(scale * total * scale.T)
        kept = values > 1e-13 * values[-1]
        axes = scale * vectors[:, kept]
        inverse = (axes / values[kept]) @ axes.T
    # The inverse for a body with a plane of symmetry does not couple motions in and out of that plane. Rounding must
    # not couple them either: it would start an out-of-plane motion that the undamped equations amplify.
    size = np.abs(inverse)
    inverse[size <= 1e-14 * size.max()] = 0.0
    return inverse


@compiled
def _invert_definite(total: FloatArray, length: float, room: FloatArray, inverse: FloatArray) -> bool:
    """Fill in the inverse by Cholesky's factor L, as L^-T L^-1; return False if a direction has hardly any inertia.

    ``room`` is for the factor and its inverse, (2, 6, 6).
    """
    factor, root = room[0], room[1]
    largest = 0.0
    for j in range(6):
        largest = max(largest, total[j, j] if j < 3 else total[j, j] / (length * length))
    for j in range(6):
        for i in range(j, 6):
            rest = total[i, j] / ((1.0 if i < 3 else length) * (1.0 if j < 3 else length))
            for k in range(j):
                rest -= factor[i, k] * factor[j, k]
            if i == j:
                if not rest > _DEFINITE * largest:
                    return False
                factor[j, j] = math.sqrt(rest)
            else:
                factor[i, j] = rest / factor[j, j]
    for j in range(6):
        root[j, j] = 1.0 / factor[j, j]
        for i in range(j + 1, 6):
            rest = 0.0
            for k in range(j, i):
                rest -= factor[i, k] * root[k, j]
            root[i, j] = rest / factor[i, i]
    for j in range(6):
        for i in range(j, 6):
            found = 0.0
            for k in range(i, 6):
                found += root[k, i] * root[k, j]
            found /= (1.0 if i < 3 else length) * (1.0 if j < 3 else length)
            inverse[i, j], inverse[j, i] = found, found
    return True
