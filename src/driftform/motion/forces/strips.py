"""A body of revolution in strips across its axis: its radius at equal steps, and Gauss points of its side area."""

import numpy as np

from driftform.types import FloatArray
from driftform.util.compiled import allocating


@allocating
def outer_radii(contour: FloatArray, count: int) -> FloatArray:
    """Return x and the outermost radius (m) of a contour (n, 2) in the middle of ``count`` equal steps, (2, count)."""
    low, high = contour[0, 0], contour[0, 0]
    for k in range(contour.shape[0]):
        low, high = min(low, contour[k, 0]), max(high, contour[k, 0])
    step = (high - low) / count
    out = np.zeros((2, count))
    for i in range(count):
        out[0, i] = low + (i + 0.5) * step
    for k in range(contour.shape[0] - 1):
        xa, ra, xb, rb = contour[k, 0], contour[k, 1], contour[k + 1, 0], contour[k + 1, 1]
        if xa > xb:
            xa, ra, xb, rb = xb, rb, xa, ra
        first, last = int((xa - low) / step), int((xb - low) / step)
        for i in range(max(0, first), min(count - 1, last) + 1):
            x = out[0, i]
            if xa <= x <= xb and xb > xa:
                out[1, i] = max(out[1, i], ra + (rb - ra) * (x - xa) / (xb - xa))
    return out


def gauss_strips(x: FloatArray, r: FloatArray, count: int) -> FloatArray:
    """Return x, diameter and width (m) of strips that integrate over the side area: Gauss points, (count, 3).

    The sum of d dx p(x) over them is the integral of 2 r p(x) dx for every polynomial p up to degree 2 ``count`` - 1
    (Golub and Welsch, Math. Comp. 23, 1969). Width and diameter of a strip are those of the part of the side that it
    represents: the parts lie side by side, in the order of the points.

    Args:
        x, r: radius at equal steps of x, m, (k,) each; the steps are the unit in which the integral is exact.
    """
    step = float(x[1] - x[0])
    middle, half = float(x[0] + x[-1]) / 2, step * len(x) / 2
    area = 2 * step * r
    diagonal, squares = _recurrence((x - middle) / half, area, count)
    off = np.sqrt(squares[1:])
    nodes, basis = np.linalg.eigh(np.diag(diagonal) + np.diag(off, 1) + np.diag(off, -1))
    total = float(area.sum())
    weights = total * basis[0] ** 2
    edges = np.interp(np.cumsum(weights), np.concatenate([[0.0], np.cumsum(area)]), np.arange(len(x) + 1.0))
    edges[-1] = len(x)
    widths = step * np.diff(edges, prepend=0.0)
    return np.column_stack([middle + half * nodes, weights / widths, widths])


@allocating
def _recurrence(s: FloatArray, weight: FloatArray, count: int) -> tuple[FloatArray, FloatArray]:
    """Return a_k and b_k of p_{k+1} = (s - a_k) p_k - b_k p_{k-1}, of polynomials that are orthogonal on points s (n,)."""
    a, b = np.zeros(count), np.zeros(count)
    p, before, last = np.ones(s.shape[0]), np.zeros(s.shape[0]), 1.0
    for k in range(count):
        norm, first = 0.0, 0.0
        for i in range(s.shape[0]):
            square = weight[i] * p[i] * p[i]
            norm += square
            first += s[i] * square
        a[k] = first / norm
        b[k] = norm / last if k > 0 else 0.0
        for i in range(s.shape[0]):
            p[i], before[i] = (s[i] - a[k]) * p[i] - b[k] * before[i], p[i]
        last = norm
    return a, b
