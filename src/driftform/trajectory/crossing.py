"""Which cells of a grid a path crosses, and how close it comes to their centres."""

import numpy as np

from driftform.dynamics.cubic import Cubic, at, cubic_between, foot
from driftform.dynamics.vectors import Vector, dot, subtract
from driftform.types import FloatArray
from driftform.util.compiled import compiled

_STATIONS = 4
"""Stretches of the path through a cell at whose ends the nearest point to its centre is sought."""


@compiled
def cross_cells(
    t: FloatArray,
    place: FloatArray,
    rate: FloatArray,
    size: FloatArray,
    shape: tuple[int, int],
    nearest: FloatArray,
) -> None:
    """Lower ``nearest`` to the distance (m) of a path from the centre of each cell, where it is inside of it.

    Parameters
    ----------
    t
        time of the samples, s, (k,), of which there are two at least.
    place, rate
        position and velocity in sides of a cell, (k, 3). The grid is one cell deep: it fills 0 to ``shape[0]``, 0 to
        ``shape[1]`` and 0 to 1.
    size
        sides of a cell, m, (3,).
    nearest
        by cell, the second coordinate first: (shape[0] shape[1],).

    The path between samples is their cubic Hermite curve. It is cut where it crosses sides of cells.
    """
    counts = (shape[0], shape[1], 1)
    # A coordinate has three parts at most that pass every side once.
    cuts = np.empty(2 + 3 * (shape[0] + shape[1] + 4))
    for s in range(t.shape[0] - 1):
        p = (place[s, 0], place[s, 1], place[s, 2])
        q = (place[s + 1, 0], place[s + 1, 1], place[s + 1, 2])
        v = (rate[s, 0], rate[s, 1], rate[s, 2])
        w = (rate[s + 1, 0], rate[s + 1, 1], rate[s + 1, 2])
        cubic = cubic_between(p, v, q, w, t[s + 1] - t[s])
        if _stays(p, v, q, w, t[s + 1] - t[s]):
            _approach(cubic, size, shape, nearest)
            continue
        for i in range(_cut(cubic, counts, cuts) - 1):
            u, h = cuts[i], cuts[i + 1] - cuts[i]
            if h > 0.0:
                _approach(_part(cubic, u, h), size, shape, nearest)


@compiled
def _stays(p: Vector, v: Vector, q: Vector, w: Vector, h: float) -> bool:
    """Whether a stretch is sure to stay in one cell: it lies between its Bezier points p, p + h v/3, q - h w/3, q."""
    for k in range(3):
        cell = np.floor(p[k])
        a, b = p[k] + h * v[k] / 3.0, q[k] - h * w[k] / 3.0
        if np.floor(q[k]) != cell or np.floor(a) != cell or np.floor(b) != cell:
            return False
    return True


@compiled
def _approach(cubic: Cubic, size: FloatArray, shape: tuple[int, int], nearest: FloatArray) -> None:
    """Take account of a part of the path that lies within one cell."""
    x, y, z = at(cubic, 0.5)
    column, row = int(np.floor(x)), int(np.floor(y))
    if 0 <= column < shape[0] and 0 <= row < shape[1] and 0.0 <= z < 1.0:
        cell = column * shape[1] + row
        centre = (column + 0.5, row + 0.5, 0.5)
        nearest[cell] = min(nearest[cell], _from_centre(cubic, centre, size, nearest[cell]))


@compiled
def _cut(cubic: Cubic, counts: tuple[int, int, int], cuts: FloatArray) -> int:
    """Put where a stretch of the path crosses from cell to cell into ``cuts``, with both of its ends: ascending u.

    Return how many there are.
    """
    _, b, c, d = cubic
    cuts[0], cuts[1] = 0.0, 1.0
    found = 2
    for k in range(3):
        # Between its turning points a coordinate passes every side but once.
        one, two = _turning(b[k], 2.0 * c[k], 3.0 * d[k])
        for low, high in ((0.0, one), (one, two), (two, 1.0)):
            if low < high:
                first, last = _sides(_value(cubic, k, low), _value(cubic, k, high), counts[k])
                for side in range(first, last + 1):
                    u = _crossing(cubic, k, float(side), low, high)
                    place = found
                    while cuts[place - 1] > u:
                        cuts[place] = cuts[place - 1]
                        place -= 1
                    cuts[place] = u
                    found += 1
    return found


@compiled
def _value(cubic: Cubic, k: int, u: float) -> float:
    a, b, c, d = cubic
    return a[k] + u * (b[k] + u * (c[k] + u * d[k]))


@compiled
def _turning(a: float, b: float, c: float) -> tuple[float, float]:
    """The roots of a + b u + c u^2 between 0 and 1, ascending; 0 and 1 stand for those that are not there."""
    root = b * b - 4.0 * a * c
    if root < 0.0:
        return 0.0, 1.0
    # The sum that does not cancel; the other root follows from the product of both.
    q = -0.5 * (b + np.copysign(np.sqrt(root), b))
    one = q / c if c != 0.0 else 0.0
    two = a / q if q != 0.0 else 1.0
    one, two = min(1.0, max(0.0, one)), min(1.0, max(0.0, two))
    return min(one, two), max(one, two)


@compiled
def _sides(a: float, b: float, count: int) -> tuple[int, int]:
    """First and last side of cells from the value a to b, of those from 0 to ``count``."""
    low, high = max(0.0, min(a, b)), min(float(count), max(a, b))
    if not low <= high:
        return 0, -1
    return int(np.ceil(low)), int(np.floor(high))


@compiled
def _crossing(cubic: Cubic, k: int, value: float, low: float, high: float) -> float:
    """Where a coordinate that only rises or only falls has the value: bisection."""
    rises = _value(cubic, k, low) < _value(cubic, k, high)
    while high - low > 1e-9:
        middle = 0.5 * (low + high)
        if (_value(cubic, k, middle) < value) == rises:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@compiled
def _part(cubic: Cubic, u: float, h: float) -> Cubic:
    """The part of a cubic from u to u + h, as a cubic from 0 to 1."""
    _, b, c, d = cubic
    return (
        at(cubic, u),
        (
            h * (b[0] + u * (2.0 * c[0] + 3.0 * u * d[0])),
            h * (b[1] + u * (2.0 * c[1] + 3.0 * u * d[1])),
            h * (b[2] + u * (2.0 * c[2] + 3.0 * u * d[2])),
        ),
        (
            h * h * (c[0] + 3.0 * u * d[0]),
            h * h * (c[1] + 3.0 * u * d[1]),
            h * h * (c[2] + 3.0 * u * d[2]),
        ),
        (h * h * h * d[0], h * h * h * d[1], h * h * h * d[2]),
    )


@compiled
def _from_centre(cubic: Cubic, centre: Vector, size: FloatArray, bound: float) -> float:
    """Distance (m) of a path from a point, both in sides of a cell; infinite where it is sure not to be below a bound."""
    a, b, c, d = cubic
    metric = (_resize(a, size), _resize(b, size), _resize(c, size), _resize(d, size))
    point = _resize(centre, size)
    # The path goes no farther than the sum of its terms' rates.
    length = _norm(metric[1]) + 2.0 * _norm(metric[2]) + 3.0 * _norm(metric[3])
    if _norm(subtract(at(metric, 0.5), point)) - 0.5 * length >= bound:
        return np.inf
    nearest, station = np.inf, 0.0
    for g in range(_STATIONS + 1):
        offset = subtract(at(metric, g / _STATIONS), point)
        squared = dot(offset, offset)
        if squared < nearest:
            nearest, station = squared, g / _STATIONS
    distance, _ = foot(metric, point, station)
    return distance


@compiled
def _resize(a: Vector, size: FloatArray) -> Vector:
    return a[0] * size[0], a[1] * size[1], a[2] * size[2]


@compiled
def _norm(a: Vector) -> float:
    return float(np.sqrt(dot(a, a)))
