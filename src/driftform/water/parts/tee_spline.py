"""The potential of a tee at a point: first and second derivatives of a hierarchical spline, from one flat array.

The array has, for each level, width of a cell, first cell along x, y and z, functions along x, y and z, and where the
coefficients begin; then the coefficients of all levels. Functions with y < 0 are left out: the potential is even in y.
A coefficient that no cell of a level's region needs is NaN.
"""

import math
from typing import TypeAlias

import numpy as np

from driftform.types import FloatArray
from driftform.util.compiled import compiled

HEAD = 1
"""Where the first level begins, after the number of levels."""

LEVEL_SIZE = 8
"""Numbers of a level."""

Derivatives: TypeAlias = tuple[float, float, float, float, float, float, float, float, float]
"""Derivatives in x, y, z, xx, xy, xz, yy, yz, zz."""

Four: TypeAlias = tuple[float, float, float, float]


@compiled
def cubic_values(u: float) -> Four:
    """Return the four cubic B-splines of a cell of width 1 at u, 0 to 1."""
    v = 1.0 - u
    return (
        v * v * v / 6.0,
        (3.0 * u * u * u - 6.0 * u * u + 4.0) / 6.0,
        (3.0 * v * v * v - 6.0 * v * v + 4.0) / 6.0,
        u * u * u / 6.0,
    )


@compiled
def cubic_slopes(u: float) -> Four:
    """Return the derivatives of :func:`cubic_values`."""
    v = 1.0 - u
    return -0.5 * v * v, 1.5 * u * u - 2.0 * u, 2.0 * v - 1.5 * v * v, 0.5 * u * u


@compiled
def cubic_bends(u: float) -> Four:
    """Return the second derivatives of :func:`cubic_values`."""
    v = 1.0 - u
    return v, 3.0 * u - 2.0, 3.0 * v - 2.0, u


@compiled
def potential_derivatives(x: float, y: float, z: float, field: FloatArray, start: int) -> Derivatives:
    """Return the derivatives of the potential at a point; NaN where no level covers it.

    ``start`` is the place of the number of levels in ``field``.
    """
    side = 1.0 if y >= 0.0 else -1.0
    y = abs(y)
    for level in range(int(field[start]) - 1, -1, -1):
        head = start + HEAD + LEVEL_SIZE * level
        width = field[head]
        a, b, c = x / width, y / width, z / width
        i, j, k = math.floor(a), math.floor(b), math.floor(c)
        u, v, w = a - i, b - j, c - k
        ny, nz = int(field[head + 5]), int(field[head + 6])
        i, j, k = int(i - field[head + 1]), int(j - field[head + 2]), int(k - field[head + 3])
        if i < 0 or j < 0 or k < 0 or i + 3 >= field[head + 4] or j + 3 >= ny or k + 3 >= nz:
            continue
        first = int(field[head + 7]) + (i * ny + j) * nz + k
        if math.isnan(field[first]) or math.isnan(field[first + (3 * ny + 3) * nz + 3]):
            continue
        found = _sum_cell(u, v, w, field, first, ny, nz, width, side)
        if not math.isnan(found[0]):
            return found
    n = np.nan
    return n, n, n, n, n, n, n, n, n


@compiled
def _sum_cell(
    u: float, v: float, w: float, field: FloatArray, first: int, ny: int, nz: int, width: float, side: float
) -> Derivatives:
    X, X1, X2 = cubic_values(u), cubic_slopes(u), cubic_bends(u)
    Y, Y1, Y2 = cubic_values(v), cubic_slopes(v), cubic_bends(v)
    Z, Z1, Z2 = cubic_values(w), cubic_slopes(w), cubic_bends(w)
    p_x, p_y, p_z, p_xx, p_xy, p_xz, p_yy, p_yz, p_zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(4):
        s, s_y, s_z, s_yy, s_yz, s_zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for j in range(4):
            at = first + (i * ny + j) * nz
            d, e, f, g = field[at], field[at + 1], field[at + 2], field[at + 3]
            c = d * Z[0] + e * Z[1] + f * Z[2] + g * Z[3]
            c1 = d * Z1[0] + e * Z1[1] + f * Z1[2] + g * Z1[3]
            c2 = d * Z2[0] + e * Z2[1] + f * Z2[2] + g * Z2[3]
            s += c * Y[j]
            s_y += c * Y1[j]
            s_yy += c * Y2[j]
            s_z += c1 * Y[j]
            s_yz += c1 * Y1[j]
            s_zz += c2 * Y[j]
        p_x += s * X1[i]
        p_xx += s * X2[i]
        p_y += s_y * X[i]
        p_xy += s_y * X1[i]
        p_z += s_z * X[i]
        p_xz += s_z * X1[i]
        p_yy += s_yy * X[i]
        p_yz += s_yz * X[i]
        p_zz += s_zz * X[i]
    one, two = 1.0 / width, 1.0 / (width * width)
    return (
        one * p_x,
        one * side * p_y,
        one * p_z,
        two * p_xx,
        two * side * p_xy,
        two * p_xz,
        two * p_yy,
        two * side * p_yz,
        two * p_zz,
    )
