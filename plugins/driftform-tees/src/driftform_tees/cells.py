"""Integrals over the cells of a grid that the wall cuts, line by line (in the manner of Saye, SIAM J. Sci. Comput. 37, 2015).

Each cell is divided into smaller ones. In each, lines run along the axis that is closest to the wall's normal, and the
level changes sign at few points of a line: Gauss's rule is applied between them.
"""

import math

import numpy as np

from driftform.types import FloatArray
from driftform.util import allocating, compiled
from driftform.water.parts import tee_wall
from driftform_tees.region import distance_beyond_ends, water_level

PIECES = 4
"""Pieces of a line in which at most one change of sign is looked for."""


@compiled
def spline_values(u: float, values: FloatArray, slopes: FloatArray) -> None:
    """Write the four cubic B-splines at u, 0 to 1, of a cell of width 1, and their derivatives."""
    v = 1.0 - u
    values[0], values[3] = v * v * v / 6, u * u * u / 6
    values[1] = (3 * u * u * u - 6 * u * u + 4) / 6
    values[2] = (3 * v * v * v - 6 * v * v + 4) / 6
    slopes[0], slopes[3] = -v * v / 2, u * u / 2
    slopes[1] = (3 * u * u - 4 * u) / 2
    slopes[2] = -(3 * v * v - 4 * v) / 2


@compiled
def _line_axis(p: FloatArray, wall: FloatArray) -> int:
    """Return the axis that is closest to the normal of the boundary near a point."""
    level, normal = tee_wall.wall_level(p[0], p[1], p[2], wall)
    along = max(-wall[tee_wall.UPSTREAM] - p[0], p[0] - wall[tee_wall.DOWNSTREAM])
    beyond = distance_beyond_ends(p[0], p[1], p[2], wall)
    if beyond > level:
        return 0 if beyond == along or wall[tee_wall.COSINE] > wall[tee_wall.SINE] else 2
    if abs(normal[0]) > max(abs(normal[1]), abs(normal[2])):
        return 0
    return 1 if abs(normal[1]) > abs(normal[2]) else 2


@compiled
def _level_on_line(p: FloatArray, axis: int, at: float, wall: FloatArray) -> float:
    if axis == 0:
        return water_level(at, p[1], p[2], wall)
    if axis == 1:
        return water_level(p[0], at, p[2], wall)
    return water_level(p[0], p[1], at, wall)


@compiled
def _find_root(p: FloatArray, axis: int, low: float, high: float, at_low: float, wall: FloatArray) -> float:
    for _ in range(36):
        middle = 0.5 * (low + high)
        level = _level_on_line(p, axis, middle, wall)
        if (level < 0.0) == (at_low < 0.0):
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@allocating
def cut_cell(
    corner: FloatArray, width: float, wall: FloatArray, parts: int, nodes: FloatArray, weights: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the points of integration in the water of a cell, and those on its wall.

    Args:
        corner, width: of the cell.
        parts: smaller cells along each edge.
        nodes, weights: of Gauss's rule on 0 to 1.

    Returns:
        rows of point and weight, (n, 4), and rows of point, normal and weight, (m, 7).
    """
    count = len(nodes)
    inner = np.empty((parts**3 * count**3 * PIECES, 4))
    outer = np.empty((parts**3 * count**2 * PIECES, 7))
    n, m, w = 0, 0, width / parts
    p = np.empty(3)
    for part in range(parts**3):
        start = corner + w * np.array([part // (parts * parts), part // parts % parts, part % parts])
        middle = start + 0.5 * w
        axis = _line_axis(middle, wall)
        first, second = (axis + 1) % 3, (axis + 2) % 3
        for i in range(count):
            for j in range(count):
                p[first], p[second] = start[first] + w * nodes[i], start[second] + w * nodes[j]
                base = w * w * weights[i] * weights[j]
                low = start[axis]
                level = _level_on_line(p, axis, low, wall)
                begin = low
                for piece in range(PIECES):
                    high = start[axis] + w * (piece + 1) / PIECES
                    at_high = _level_on_line(p, axis, high, wall)
                    crossed = (at_high < 0.0) != (level < 0.0)
                    stop = _find_root(p, axis, low, high, level, wall) if crossed else high
                    last = piece == PIECES - 1
                    if level < 0.0 and (crossed or last):
                        n = _fill(inner, n, p, axis, begin, stop, base, nodes, weights)
                    if crossed:
                        p[axis] = stop
                        if distance_beyond_ends(p[0], p[1], p[2], wall) < -1e-9:
                            _, normal = tee_wall.wall_level(p[0], p[1], p[2], wall)
                            for e in range(3):
                                outer[m, e], outer[m, 3 + e] = p[e], normal[e]
                            outer[m, 6] = base / max(abs(normal[axis]), 0.05)
                            m += 1
                        if last and at_high < 0.0:
                            n = _fill(inner, n, p, axis, stop, high, base, nodes, weights)
                        begin = stop
                    low, level = high, at_high
    return inner[:n].copy(), outer[:m].copy()


@compiled
def _fill(
    rows: FloatArray,
    n: int,
    p: FloatArray,
    axis: int,
    begin: float,
    stop: float,
    base: float,
    nodes: FloatArray,
    weights: FloatArray,
) -> int:
    """Append Gauss's points between two points of a line."""
    for k in range(len(nodes)):
        p[axis] = begin + (stop - begin) * nodes[k]
        rows[n, 0], rows[n, 1], rows[n, 2] = p[0], p[1], p[2]
        rows[n, 3] = base * (stop - begin) * weights[k]
        n += 1
    return n


@allocating
def value_rows(points: FloatArray, corners: FloatArray, width: float) -> FloatArray:
    """Return the values of the 64 functions of cells (corners, (n, 3)) at points (n, 3+), (n, 64)."""
    rows = np.empty((len(points), 64))
    N, D = np.empty((3, 4)), np.empty((3, 4))
    for q in range(len(points)):
        for a in range(3):
            spline_values((points[q, a] - corners[q, a]) / width, N[a], D[a])
        for i in range(4):
            for j in range(4):
                for k in range(4):
                    rows[q, 16 * i + 4 * j + k] = N[0, i] * N[1, j] * N[2, k]
    return rows


@allocating
def gradient_rows(points: FloatArray, corner: FloatArray, width: float) -> FloatArray:
    """Return the gradients of the 64 functions of a cell at points (n, 3+), (3 n, 64)."""
    rows = np.empty((3 * len(points), 64))
    N, D = np.empty((3, 4)), np.empty((3, 4))
    for q in range(len(points)):
        for a in range(3):
            spline_values((points[q, a] - corner[a]) / width, N[a], D[a])
        for i in range(4):
            for j in range(4):
                for k in range(4):
                    f = 16 * i + 4 * j + k
                    rows[3 * q, f] = D[0, i] * N[1, j] * N[2, k] / width
                    rows[3 * q + 1, f] = N[0, i] * D[1, j] * N[2, k] / width
                    rows[3 * q + 2, f] = N[0, i] * N[1, j] * D[2, k] / width
    return rows


@allocating
def cut_stiffness(
    corners: FloatArray,
    width: float,
    wall: FloatArray,
    parts: int,
    nodes: FloatArray,
    weights: FloatArray,
    penalty: float,
) -> tuple[FloatArray, FloatArray]:
    """Return the matrices of cells (n, 64, 64), and their volumes of water (n,).

    A matrix is the integral of grad N_i . grad N_j over the water, plus ``penalty`` times the width times that of
    (n . grad N_i)(n . grad N_j) over the wall.
    """
    count = len(corners)
    matrices, volumes = np.empty((count, 64, 64)), np.empty(count)
    for c in range(count):
        inner, outer = cut_cell(corners[c], width, wall, parts, nodes, weights)
        rows = gradient_rows(inner, corners[c], width)
        for q in range(len(rows)):
            rows[q] *= math.sqrt(inner[q // 3, 3])
        matrices[c] = rows.T @ rows
        volumes[c] = inner[:, 3].sum()
        if len(outer) > 0:
            slopes = gradient_rows(outer, corners[c], width)
            normal = np.empty((len(outer), 64))
            for q in range(len(outer)):
                factor = math.sqrt(penalty * width * outer[q, 6])
                for f in range(64):
                    normal[q, f] = factor * (
                        outer[q, 3] * slopes[3 * q, f]
                        + outer[q, 4] * slopes[3 * q + 1, f]
                        + outer[q, 5] * slopes[3 * q + 2, f]
                    )
            matrices[c] += normal.T @ normal
    return matrices, volumes
