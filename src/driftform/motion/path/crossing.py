"""The cells of a grid that a path crosses, and its least distances from their centres: compiled kernels."""

import numpy as np

from driftform.types import FloatArray
from driftform.util.compiled import allocating, compiled
from driftform.util.cubic import Cubic, cubic_between, cubic_point, nearest_on_cubic
from driftform.util.small_vectors import Vector, distance_between, dot, norm, subtract

_STATIONS = 4
"""Parts of the path through a cell; the nearest of their ends is the start of Newton's method."""


@allocating
def lower_distances(
    t: FloatArray, place: FloatArray, rate: FloatArray, size: FloatArray, shape: tuple[int, int], nearest: FloatArray
) -> None:
    """Lower ``nearest`` to the least distance (m) of a path from the centre of each cell, while it is inside that cell.

    Args:
        t: time of the samples, s, (k,); at least two.
        place, rate: position and velocity in sides of a cell, (k, 3). The grid is one cell deep: it extends from 0 to
            ``shape[0]``, 0 to ``shape[1]`` and 0 to 1.
        size: sides of a cell, m, (3,).
        nearest: one number per cell, the second coordinate varying fastest, (shape[0] shape[1],).

    The path between samples is their cubic Hermite curve. It is cut where it crosses sides of cells.
    """
    counts = (shape[0], shape[1], 1)
    # A coordinate has at most three monotonic parts, and each of them crosses a side at most once.
    cuts = np.empty(2 + 3 * (shape[0] + shape[1] + 4))
    for s in range(t.shape[0] - 1):
        p = (place[s, 0], place[s, 1], place[s, 2])
        q = (place[s + 1, 0], place[s + 1, 1], place[s + 1, 2])
        v = (rate[s, 0], rate[s, 1], rate[s, 2])
        w = (rate[s + 1, 0], rate[s + 1, 1], rate[s + 1, 2])
        cubic = cubic_between(p, v, q, w, t[s + 1] - t[s])
        if _stays_in_cell(p, v, q, w, t[s + 1] - t[s]):
            _lower_distance(cubic, size, shape, nearest)
            continue
        for i in range(_find_cuts(cubic, counts, cuts) - 1):
            u, h = cuts[i], cuts[i + 1] - cuts[i]
            if h > 0.0:
                _lower_distance(_cut_cubic(cubic, u, h), size, shape, nearest)


@compiled
def _stays_in_cell(p: Vector, v: Vector, q: Vector, w: Vector, h: float) -> bool:
    """Return True if a stretch certainly stays in one cell: it lies between its Bezier points p, p + h v/3, q - h w/3, q."""
    for k in range(3):
        cell = np.floor(p[k])
        a, b = p[k] + h * v[k] / 3.0, q[k] - h * w[k] / 3.0
        if np.floor(q[k]) != cell or np.floor(a) != cell or np.floor(b) != cell:
            return False
    return True


@compiled
def _lower_distance(cubic: Cubic, size: FloatArray, shape: tuple[int, int], nearest: FloatArray) -> None:
    """Lower ``nearest`` for a part of the path that lies within one cell."""
    x, y, z = cubic_point(cubic, 0.5)
    column, row = int(np.floor(x)), int(np.floor(y))
    if 0 <= column < shape[0] and 0 <= row < shape[1] and 0.0 <= z < 1.0:
        cell = column * shape[1] + row
        centre = (column + 0.5, row + 0.5, 0.5)
        nearest[cell] = min(nearest[cell], _distance_from(cubic, centre, size, nearest[cell]))


@compiled
def _find_cuts(cubic: Cubic, counts: tuple[int, int, int], cuts: FloatArray) -> int:
    """Fill ``cuts`` with the ascending u at which a stretch crosses from cell to cell, and its two ends.

    Return the number of cuts.
    """
    _, b, c, d = cubic
    cuts[0], cuts[1] = 0.0, 1.0
    found = 2
    for k in range(3):
        # Between its turning points a coordinate crosses every side at most once.
        one, two = _turning_points(b[k], 2.0 * c[k], 3.0 * d[k])
        for low, high in ((0.0, one), (one, two), (two, 1.0)):
            if low < high:
                first, last = _crossed_sides(_coordinate(cubic, k, low), _coordinate(cubic, k, high), counts[k])
                for side in range(first, last + 1):
                    u = _locate_side(cubic, k, float(side), low, high)
                    place = found
                    while cuts[place - 1] > u:
                        cuts[place] = cuts[place - 1]
                        place -= 1
                    cuts[place] = u
                    found += 1
    return found


@compiled
def _coordinate(cubic: Cubic, k: int, u: float) -> float:
    a, b, c, d = cubic
    return a[k] + u * (b[k] + u * (c[k] + u * d[k]))


@compiled
def _turning_points(a: float, b: float, c: float) -> tuple[float, float]:
    """Return the roots of a + b u + c u^2, ascending and clipped to 0 to 1; 0 and 1 replace missing roots."""
    root = b * b - 4.0 * a * c
    if root < 0.0:
        return 0.0, 1.0
    # The sum without cancellation; the other root follows from the product of both.
    q = -0.5 * (b + np.copysign(np.sqrt(root), b))
    one = q / c if c != 0.0 else 0.0
    two = a / q if q != 0.0 else 1.0
    one, two = min(1.0, max(0.0, one)), min(1.0, max(0.0, two))
    return min(one, two), max(one, two)


@compiled
def _crossed_sides(a: float, b: float, count: int) -> tuple[int, int]:
    """Return the first and the last side of cells, 0 to ``count``, between the values a and b."""
    low, high = max(0.0, min(a, b)), min(float(count), max(a, b))
    if not low <= high:
        return 0, -1
    return int(np.ceil(low)), int(np.floor(high))


@compiled
def _locate_side(cubic: Cubic, k: int, value: float, low: float, high: float) -> float:
    """Return the u at which a monotonic coordinate has the value, by bisection."""
    rises = _coordinate(cubic, k, low) < _coordinate(cubic, k, high)
    while high - low > 1e-9:
        middle = 0.5 * (low + high)
        if (_coordinate(cubic, k, middle) < value) == rises:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@compiled
def _cut_cubic(cubic: Cubic, u: float, h: float) -> Cubic:
    """Return the part of a cubic from u to u + h, as a cubic from 0 to 1."""
    _, b, c, d = cubic
    return (
        cubic_point(cubic, u),
        (
            h * (b[0] + u * (2.0 * c[0] + 3.0 * u * d[0])),
            h * (b[1] + u * (2.0 * c[1] + 3.0 * u * d[1])),
            h * (b[2] + u * (2.0 * c[2] + 3.0 * u * d[2])),
        ),
        (h * h * (c[0] + 3.0 * u * d[0]), h * h * (c[1] + 3.0 * u * d[1]), h * h * (c[2] + 3.0 * u * d[2])),
        (h * h * h * d[0], h * h * h * d[1], h * h * h * d[2]),
    )


@compiled
def _distance_from(cubic: Cubic, centre: Vector, size: FloatArray, bound: float) -> float:
    """Return the least distance (m) of a path from a point, or infinity if it is certainly not below ``bound`` (m).

    Path and point are in sides of a cell.
    """
    a, b, c, d = cubic
    metric = (_to_metres(a, size), _to_metres(b, size), _to_metres(c, size), _to_metres(d, size))
    point = _to_metres(centre, size)
    # The path is no longer than this sum of its coefficients.
    length = norm(metric[1]) + 2.0 * norm(metric[2]) + 3.0 * norm(metric[3])
    if distance_between(cubic_point(metric, 0.5), point) - 0.5 * length >= bound:
        return np.inf
    nearest, station = np.inf, 0.0
    for g in range(_STATIONS + 1):
        offset = subtract(cubic_point(metric, g / _STATIONS), point)
        squared = dot(offset, offset)
        if squared < nearest:
            nearest, station = squared, g / _STATIONS
    distance, _ = nearest_on_cubic(metric, point, station)
    return distance


@compiled
def _to_metres(a: Vector, size: FloatArray) -> Vector:
    return a[0] * size[0], a[1] * size[1], a[2] * size[2]
