"""Compiled code: unions and inward offsets of sections whose height is a function of the distance along the axis.

All compiled functions are in this file, because the cache of a function detects no changes of other files of this plugin.

The section of a hull lies between the axis and a contour that never turns back. What covers it is a set of segments, and
its contour is their upper envelope; its offset by a wall is what no piece of wall covers, and its contour the lower
envelope of these pieces. Lengths are in m.
"""

import math

import numpy as np

from driftform.types import FloatArray
from driftform.util import compiled

MITRE_LIMIT = 2.0
"""A mitre longer than this many walls is cut off, so that a sharp neck does not pinch the cavity."""

ON_AXIS = 1e-10
"""A height that is less than this, m, is on the axis."""

RESOLUTION = 1e-12
"""Parts of a contour that extend less than this along the axis, m, are rounding errors."""

SIMPLIFY = 1e-7
"""Vertices within this distance (m) of the edge that replaces them carry no shape, only slivers of a mesh."""

_POINTS = 16
"""Room for the points of an envelope, for each of its segments; a piece has two.

An envelope of n segments has at most as many pieces as a Davenport-Schinzel sequence of order 3 has members: 42 for ten
segments, and hardly more for each where there are more (Sharir and Agarwal 1995).
"""


def unite_contours(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the contour of what lies between the axis and either of two contours, around x = 0, (k, 2).

    It begins and ends on the axis, and is empty if neither contour is above the axis at x = 0.

    Args:
        first, second: x and height, in ascending order of x, (n, 2) and (m, 2); a height that is not positive is on
            the axis.
    """
    size = len(first) + len(second)
    rows, points = np.empty((size, 5)), np.empty((_POINTS * size, 2))
    return points[: _unite(first, second, rows, points)].copy()


def offset_inward(contour: FloatArray, wall: float) -> FloatArray:
    """Return the contour of what is a wall away from another contour, (k, 2); a height that is not positive is on the axis.

    The wall is a strip along each edge, and a mitre at each corner that turns away from the axis; a mitre longer
    than :data:`MITRE_LIMIT` walls is cut off at one wall from its corner.

    Args:
        contour: x and height, from one point of the axis to another, in ascending order of x, (n, 2).
    """
    size = 5 * len(contour)
    rows, points = np.empty((size, 5)), np.empty((_POINTS * size, 2))
    return points[: _offset(contour, wall, rows, points)].copy()


@compiled
def _unite(first: FloatArray, second: FloatArray, rows: FloatArray, points: FloatArray) -> int:
    """Fill in the points of :func:`unite_contours`, and return their number; ``rows`` is room for the segments."""
    count, i, j = 0, 0, 0
    while i + 1 < first.shape[0] or j + 1 < second.shape[0]:
        if j + 1 == second.shape[0] or (i + 1 < first.shape[0] and first[i, 0] <= second[j, 0]):
            count = _add_segment(first[i, 0], first[i, 1], first[i + 1, 0], first[i + 1, 1], rows, count)
            i += 1
        else:
            count = _add_segment(second[j, 0], second[j, 1], second[j + 1, 0], second[j + 1, 1], rows, count)
            j += 1
    return _simplify(points, _cut_at_axis(points, _trace_envelope(rows, count, points)))


@compiled
def _offset(contour: FloatArray, wall: float, rows: FloatArray, points: FloatArray) -> int:
    """Fill in the points of :func:`offset_inward`, and return their number; ``rows`` is room for the segments."""
    last = contour.shape[0] - 1
    # Beyond the ends, too, there is nothing to keep.
    count = _add_segment(contour[0, 0] - wall, 0.0, contour[0, 0], 0.0, rows, 0)
    count = _add_segment(contour[last, 0], 0.0, contour[last, 0] + wall, 0.0, rows, count)
    # From the start of an edge to its end, and of the edge before it; as unit vectors.
    before, rise_before = 0.0, 0.0
    for k in range(last):
        x0, r0, x1, r1 = contour[k, 0], contour[k, 1], contour[k + 1, 0], contour[k + 1, 1]
        length = math.sqrt((x1 - x0) * (x1 - x0) + (r1 - r0) * (r1 - r0))
        if length == 0.0:
            continue
        along, rise = (x1 - x0) / length, (r1 - r0) / length
        # The lower envelope is the upper one upside down: here r points to the axis.
        x, r = wall * rise, wall * along
        count = _add_segment(x0 + x, -r0 + r, x1 + x, -r1 + r, rows, count)
        if rise > 0.0:
            count = _add_segment(x0, -r0, x0 + x, -r0 + r, rows, count)
        else:
            count = _add_segment(x1, -r1, x1 + x, -r1 + r, rows, count)
        if k > 0 and before * rise - rise_before * along > 0.0:
            count = _add_mitre(x0, -r0, before, rise_before, along, rise, wall, rows, count)
        before, rise_before = along, rise
    count = _trace_envelope(rows, count, points)
    for k in range(count):
        points[k, 1] = -points[k, 1]
    return count


@compiled
def _add_mitre(
    x: float, r: float, ux: float, ur: float, vx: float, vr: float, wall: float, rows: FloatArray, count: int
) -> int:
    """Add the lower sides of the mitre at a corner between edges along ``u`` and ``v``, upside down."""
    # Both ends of the mitre, and the bisector, from the corner, in walls.
    px, pr, qx, qr = ur, ux, vr, vx
    bx, br = px + qx, pr + qr
    size = math.sqrt(bx * bx + br * br)
    # A mitre is 1 / cos(half of the turn) = 2 / size long.
    if MITRE_LIMIT * size >= 2.0:
        sx, sr = 2.0 / (size * size) * bx, 2.0 / (size * size) * br
        tx, tr = sx, sr
    else:
        beyond = math.sqrt((2.0 - size) / (2.0 + size))
        sx, sr, tx, tr = px + beyond * ux, pr - beyond * ur, qx - beyond * vx, qr + beyond * vr
    count = _add_segment(x + wall * px, r + wall * pr, x + wall * sx, r + wall * sr, rows, count)
    count = _add_segment(x + wall * sx, r + wall * sr, x + wall * tx, r + wall * tr, rows, count)
    return _add_segment(x + wall * tx, r + wall * tr, x + wall * qx, r + wall * qr, rows, count)


@compiled
def _add_segment(x0: float, y0: float, x1: float, y1: float, rows: FloatArray, count: int) -> int:
    """Add a segment that is not across the axis, in ascending order of the segments' starts, and return their new number."""
    if x0 == x1:
        return count
    if x1 < x0:
        x0, y0, x1, y1 = x1, y1, x0, y0
    k = count
    while k > 0 and rows[k - 1, 0] > x0:
        for i in range(5):
            rows[k, i] = rows[k - 1, i]
        k -= 1
    rows[k, 0], rows[k, 1], rows[k, 2], rows[k, 3], rows[k, 4] = x0, y0, x1, y1, (y1 - y0) / (x1 - x0)
    return count + 1


@compiled
def _trace_envelope(rows: FloatArray, n: int, points: FloatArray) -> int:
    """Fill in the points of the upper envelope of ``n`` segments, from the least x on, and return their number.

    A segment has x and y of its start and of its end, and its slope. Together they leave no gap. A step has both of its
    points.
    """
    count, waiting, top, first = 0, 0, -1, 0
    x = rows[0, 0]
    while True:
        while waiting < n and rows[waiting, 0] <= x:
            waiting += 1
        # Segments before the first one, and those with an end at most x, are over.
        while first < waiting and rows[first, 2] <= x:
            first += 1
        if first == n:
            break
        # Up to the next start or end of a segment, all that are there are lines.
        end = rows[waiting, 0] if waiting < n else math.inf
        for k in range(first, waiting):
            if rows[k, 2] > x:
                end = min(end, rows[k, 2])
        # Segments that meet in one point may miss each other by a rounding error: what shows in between is not a part.
        if first < waiting and end - x >= RESOLUTION:
            best, height, slope = -1, -math.inf, 0.0
            for k in range(first, waiting):
                if rows[k, 2] > x:
                    # Of segments that coincide, the one that is on top stays there.
                    y = _height_at(rows, k, x) + (RESOLUTION if k == top else 0.0)
                    if y > height or (y == height and rows[k, 4] > slope):
                        best, height, slope = k, y, rows[k, 4]
            while best >= 0:
                if best != top:
                    if top >= 0:
                        points[count, 0], points[count, 1] = x, _height_at(rows, top, x)
                        count += 1
                    points[count, 0], points[count, 1] = x, _height_at(rows, best, x)
                    count, top = count + 1, best
                # The next line that comes out above this one.
                best, cross, height, slope = -1, end, _height_at(rows, top, x), rows[top, 4]
                for k in range(first, waiting):
                    if rows[k, 2] > x and rows[k, 4] > slope:
                        depth, faster = max(0.0, height - _height_at(rows, k, x)), rows[k, 4] - slope
                        if depth < faster * (cross - x) and depth + RESOLUTION < faster * (end - x):
                            best, cross = k, x + depth / faster
                x = cross
        x = end
    if top < 0:
        return 0
    points[count, 0], points[count, 1] = x, _height_at(rows, top, x)
    return count + 1


@compiled
def _height_at(rows: FloatArray, k: int, x: float) -> float:
    """Return the height of a segment, which is exact at both ends."""
    return float(rows[k, 3] if x >= rows[k, 2] else rows[k, 1] + rows[k, 4] * (x - rows[k, 0]))


@compiled
def _cut_at_axis(points: FloatArray, n: int) -> int:
    """Keep the part of a contour above the axis and around x = 0, from one point of the axis to another; return its size."""
    low, high = -1, n
    for k in range(n):
        if points[k, 1] <= ON_AXIS:
            if points[k, 0] <= 0.0:
                low = k
            elif high == n:
                high = k
    if high - low == 1:
        return 0
    aft = points[0, 0] if low < 0 else _meet_axis(points, low)
    fore = points[n - 1, 0] if high == n else _meet_axis(points, high - 1)
    if not aft <= 0.0 <= fore:
        return 0
    # In the order in which no point is overwritten before it is moved.
    size = high - low - 1
    if low < 0:
        for k in range(size, 0, -1):
            points[k, 0], points[k, 1] = points[k - 1, 0], points[k - 1, 1]
    else:
        for k in range(1, size + 1):
            points[k, 0], points[k, 1] = points[low + k, 0], points[low + k, 1]
    points[0, 0], points[0, 1] = aft, 0.0
    points[size + 1, 0], points[size + 1, 1] = fore, 0.0
    return size + 2


@compiled
def _meet_axis(points: FloatArray, k: int) -> float:
    """Return where the line through a point and the next one meets the axis."""
    x0, r0, x1, r1 = points[k, 0], points[k, 1], points[k + 1, 0], points[k + 1, 1]
    return float(x0 - r0 * (x1 - x0) / (r1 - r0))


@compiled
def _simplify(points: FloatArray, n: int) -> int:
    """Keep the first and the last of ``n`` points, and those that are not :data:`SIMPLIFY` near what replaces them."""
    count, start = 0, 0
    for k in range(n):
        if k == 0 or k == n - 1 or _bulge(points, count - 1, start + 1, k + 1) > SIMPLIFY:
            points[count, 0], points[count, 1] = points[k, 0], points[k, 1]
            count, start = count + 1, k
    return count


@compiled
def _bulge(points: FloatArray, a: int, first: int, b: int) -> float:
    """Return the greatest distance of the points from the first one to ``b`` from the line through ``a`` and ``b``."""
    x, r = points[a, 0], points[a, 1]
    dx, dr = points[b, 0] - x, points[b, 1] - r
    length, largest = math.sqrt(dx * dx + dr * dr), 0.0
    for k in range(first, b):
        px, pr = points[k, 0] - x, points[k, 1] - r
        apart = abs(px * dr - pr * dx) / length if length > 0.0 else math.sqrt(px * px + pr * pr)
        largest = max(largest, apart)
    return largest
