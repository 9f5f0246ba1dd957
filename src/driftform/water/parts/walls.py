"""The wall of a pipe with parts: exact distance and normal, part by part, for compiled kernels.

A pipe with parts is one flat array, ``fittings``: the number of rows, the rows of the parts, and then the flow fields of its
tees (:mod:`driftform.water.fittings` makes it). Each part is described in its local frame: see
:mod:`driftform.water.parts.shapes`. Straight rows continue the inlet and the outlets.

In the water the gap is the distance from the wall, and in the wall it is negative: the depth. Tees have the wall that a ball makes
which rolls in the wall along both bores. Its centre moves along a closed curve, and the distance from the rounded edge is that from the
curve, less the ball's radius.
"""

import math

import numpy as np

from driftform.types import BoolArray, FloatArray
from driftform.util.compiled import allocating, compiled
from driftform.util.small_vectors import ZERO, Vector, add, dot, scale, subtract

STRAIGHT, BEND, REDUCER, TEE = 0.0, 1.0, 2.0, 3.0

HEAD = 1
"""Index of the first row in ``fittings``."""

# Indices in a row.
KIND, ORIGIN, AXES = 0, 1, 4
RADIUS, END_RADIUS, LENGTH = 13, 14, 15
CURVE = 16
"""Radius of a bend, or of the arcs of a reducer, m."""
ANGLE, COSINE, SINE = 17, 18, 19
FILLET, UPSTREAM, DOWNSTREAM, SIDE = 20, 21, 22, 23
CENTRE, EXTENT = 24, 27
"""Sphere around the part: its centre and its radius, m."""
NARROWEST = 28
EXIT = 29
"""-1 for a part of the pipe, -2 before the inlet, and the number of the outlet after an outlet."""
FIELD, FIELD_SIZE = 46, 47
"""Where the flow field of a tee begins in `fittings`, and how many numbers it has."""
EDGE = 48
"""Points of the ball's curve of a tee on the side y >= 0."""
EDGE_POINTS = 13
PART = EDGE + 3 * EDGE_POINTS + 1

INNER, OUTSIDE = -1.0, -2.0

_CORNER = 1e-9
"""Angle (rad) near a corner of a curve at which its slope is that of one side."""

FOUND = 1e-9
"""Part of a turn, or m, by which two neighbouring parts overlap: no point between them belongs to neither."""


@compiled
def to_part(point: Vector, f: FloatArray, o: int) -> Vector:
    """Return a point (m) in the local frame of the part whose row begins at ``o``."""
    off = subtract(point, (f[o + ORIGIN], f[o + ORIGIN + 1], f[o + ORIGIN + 2]))
    return turn_to_part(off, f, o)


@compiled
def turn_to_part(a: Vector, f: FloatArray, o: int) -> Vector:
    """Return a vector of the world frame in the local frame of a part."""
    o += AXES
    return (
        f[o] * a[0] + f[o + 1] * a[1] + f[o + 2] * a[2],
        f[o + 3] * a[0] + f[o + 4] * a[1] + f[o + 5] * a[2],
        f[o + 6] * a[0] + f[o + 7] * a[1] + f[o + 8] * a[2],
    )


@compiled
def turn_from_part(a: Vector, f: FloatArray, o: int) -> Vector:
    """Return a vector of the local frame of a part in the world frame."""
    o += AXES
    return (
        f[o] * a[0] + f[o + 3] * a[1] + f[o + 6] * a[2],
        f[o + 1] * a[0] + f[o + 4] * a[1] + f[o + 7] * a[2],
        f[o + 2] * a[0] + f[o + 5] * a[1] + f[o + 8] * a[2],
    )


@compiled
def find_part(point: Vector, f: FloatArray) -> tuple[int, float]:
    """Return the index in ``fittings`` of the row of the part to which a point (m) belongs, and its gap there, m.

    That is the part between whose ends the point lies, and if there are several (pipes that pass each other), the one
    that contains it.
    """
    best, found = -np.inf, HEAD
    for k in range(int(f[0])):
        o = HEAD + k * PART
        off = subtract(point, (f[o + CENTRE], f[o + CENTRE + 1], f[o + CENTRE + 2]))
        if dot(off, off) > f[o + EXTENT] * f[o + EXTENT]:
            continue
        local = to_part(point, f, o)
        if distance_beyond(local, f, o) > FOUND:
            continue
        gap, _ = local_gap(local, f, o)
        if gap >= 0.0 and f[o + EXIT] == INNER:
            return o, gap
        if gap > best:
            best, found = gap, o
    if best > -np.inf:
        return found, best
    # Deep in the wall, in a trial step: the nearest part.
    for k in range(int(f[0])):
        o = HEAD + k * PART
        local = to_part(point, f, o)
        gap, _ = local_gap(local, f, o)
        gap -= max(0.0, distance_beyond(local, f, o))
        if gap > best:
            best, found = gap, o
    return found, best


@compiled
def fitting_gap(point: Vector, f: FloatArray) -> tuple[float, Vector, int]:
    """Return the gap (m), the unit vector to the wall, and the index of the part's row; in the world frame."""
    o, _ = find_part(point, f)
    gap, normal = local_gap(to_part(point, f, o), f, o)
    return gap, turn_from_part(normal, f, o), o


@allocating
def wall_gaps(points: FloatArray, fittings: FloatArray) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Return distances of points (n, 3) from the wall (m, negative in it), unit vectors to it, and whether between the ends."""
    gaps, normals, inside = (np.empty(len(points)), np.empty((len(points), 3)), np.empty(len(points), dtype=np.bool_))
    for i in range(len(points)):
        gap, normal, row = fitting_gap((points[i, 0], points[i, 1], points[i, 2]), fittings)
        gaps[i], inside[i] = gap, fittings[row + EXIT] == INNER
        for a in range(3):
            normals[i, a] = normal[a]
    return gaps, normals, inside


@compiled
def distance_beyond(p: Vector, f: FloatArray, o: int) -> float:
    """Return how far a point of the local frame lies beyond the ends of the part, m; not positive between them."""
    kind = f[o + KIND]
    if kind == TEE:
        a, b, t = beyond_bores(p, f, o)
        if b < a:
            return float(t - f[o + SIDE])
        return float(max(-f[o + UPSTREAM] - p[0], p[0] - f[o + DOWNSTREAM]))
    if kind == BEND:
        turn = math.atan2(p[0], f[o + CURVE] - p[2])
        if turn < -FOUND:
            turn += 2.0 * math.pi
        if turn <= f[o + ANGLE]:
            return 0.0
        return float(f[o + CURVE] * min(turn - f[o + ANGLE], 2.0 * math.pi - turn))
    return float(max(-p[0], p[0] - f[o + LENGTH]))


@compiled
def local_gap(p: Vector, f: FloatArray, o: int) -> tuple[float, Vector]:
    """Return the gap (m) of a point of the local frame, and the unit vector to the wall, in the local frame."""
    kind = f[o + KIND]
    if kind == TEE:
        return gap_in_tee(p, f, o)
    if kind == BEND:
        z = p[2] - f[o + CURVE]
        far = math.hypot(p[0], z)
        across = far - f[o + CURVE]
        distance = math.hypot(across, p[1])
        if not (distance > 0.0 and far > 0.0):
            return f[o + RADIUS] - distance, ZERO
        share = across / (distance * far)
        return f[o + RADIUS] - distance, (share * p[0], p[1] / distance, share * z)
    rho = math.hypot(p[1], p[2])
    y, z = (p[1] / rho, p[2] / rho) if rho > 0.0 else (0.0, 0.0)
    if kind == STRAIGHT:
        return f[o + RADIUS] - rho, (0.0, y, z)
    gap, along, outward = _gap_in_ogee(p[0], rho, f, o)
    return gap, (along, outward * y, outward * z)


@compiled
def _gap_in_ogee(x: float, rho: float, f: FloatArray, o: int) -> tuple[float, float, float]:
    """Return the gap (m) in a reducer at ``x`` and ``rho`` from its axis, and the vector to the wall along and across the axis.

    The early arc is that about (0, R +- arc), the late one that about (L, R' -+ arc); the line through both centres parts them.
    """
    R, narrow, length, arc = f[o + RADIUS], f[o + END_RADIUS], f[o + LENGTH], f[o + CURVE]
    if x <= 0.0:
        return R - rho, 0.0, 1.0
    if x >= length:
        return narrow - rho, 0.0, 1.0
    sign = 1.0 if narrow > R else -1.0
    early, late = R + sign * arc, narrow - sign * arc
    side = x * (late - early) - length * (rho - early)
    centre_x, centre_r, bulging = 0.0, early, sign
    if side * sign < 0.0:
        centre_x, centre_r, bulging = length, late, -sign
    off_x, off_r = x - centre_x, rho - centre_r
    distance = math.hypot(off_x, off_r)
    if not distance > 0.0:
        return bulging * -arc, 0.0, 1.0
    # The wall bulges into the water about a centre in the wall, and away from a centre on the side of the axis.
    return bulging * (distance - arc), -bulging * off_x / distance, -bulging * off_r / distance


@compiled
def beyond_bores(p: Vector, f: FloatArray, o: int) -> tuple[float, float, float]:
    """Return how far (m) a point of the local frame of a tee lies beyond its run and its branch, and its place along the branch.

    The branch begins at the axis of the run. Beyond it the second number is infinite.
    """
    c, s = f[o + COSINE], f[o + SINE]
    t = c * p[0] + s * p[2]
    a = math.hypot(p[1], p[2]) - f[o + RADIUS]
    b = math.hypot(p[1], c * p[2] - s * p[0]) - f[o + END_RADIUS] if t >= 0.0 else np.inf
    return a, b, t


@compiled
def gap_in_tee(p: Vector, f: FloatArray, o: int) -> tuple[float, Vector]:
    """Return the gap (m) of a point of the local frame of a tee, and the unit vector to the wall, in that frame."""
    a, b, t = beyond_bores(p, f, o)
    fillet, c, s = f[o + FILLET], f[o + COSINE], f[o + SINE]
    rho = a + f[o + RADIUS]
    to_run = (0.0, p[1] / rho, p[2] / rho) if rho > 0.0 else ZERO
    # A bore's own wall is where the ball that touches it does not reach into the other bore; rounding must not decide that.
    least = fillet * (1.0 - 1e-9)
    by_run = beyond_bores(add(p, scale(fillet - a, to_run)), f, o)[1] >= least
    across, to_branch, by_branch = b + f[o + END_RADIUS], ZERO, False
    if t > 0.0 and across > 0.0:
        v = (c * p[2] - s * p[0]) / across
        to_branch = (-s * v, p[1] / across, c * v)
        by_branch = beyond_bores(add(p, scale(fillet - b, to_branch)), f, o)[0] >= least
    if a > 0.0 and b > 0.0:
        if by_run and not (by_branch and b < a):
            return -a, to_run
        if by_branch:
            return -b, to_branch
    elif by_run and a <= 0.0:
        return (-b, to_branch) if by_branch and a < b <= 0.0 else (-a, to_run)
    elif by_branch and b <= 0.0:
        return -b, to_branch
    off = subtract(nearest_on_edge(p, f, o), p)
    distance = math.sqrt(dot(off, off))
    return distance - fillet, scale(1.0 / distance, off) if distance > 0.0 else ZERO


@compiled
def edge_point(phi: float, f: FloatArray, o: int) -> tuple[Vector, Vector]:
    """Return the centre of the ball that rounds the edge of a tee (m), and its derivative with respect to ``phi``.

    ``phi`` is the angle about the axis of the branch, 0 on the downstream side.
    """
    c, s, rho = f[o + COSINE], f[o + SINE], f[o + END_RADIUS] + f[o + FILLET]
    height = f[o + RADIUS] + f[o + FILLET]
    sine, cosine = math.sin(phi), math.cos(phi)
    root = math.sqrt(max(height * height - rho * rho * sine * sine, 1e-24 * height * height))
    along, slope = (root + rho * cosine * c) / s, (-rho * rho * sine * cosine / root - rho * sine * c) / s
    point = (along * c + rho * cosine * s, rho * sine, along * s - rho * cosine * c)
    return point, (slope * c - rho * sine * s, rho * cosine, slope * s + rho * sine * c)


@compiled
def nearest_on_edge(p: Vector, f: FloatArray, o: int) -> Vector:
    """Return the point (m) nearest to ``p`` on the curve of the ball that rounds the edge of a tee."""
    q = (p[0], abs(p[1]), p[2])
    least, k = np.inf, 0
    for i in range(EDGE_POINTS):
        e = o + EDGE + 3 * i
        off = subtract((f[e], f[e + 1], f[e + 2]), q)
        square = dot(off, off)
        if square < least:
            least, k = square, i
    # The minimum lies between the neighbours of the nearest stored point. Half way the curve of two bores of the same radius has a
    # corner, on each side of which there may be a minimum.
    step, middle = math.pi / (EDGE_POINTS - 1), 0.5 * math.pi
    low, high = (k - 1) * step, (k + 1) * step
    if 2 * k == EDGE_POINTS - 1:
        early = _search_edge(q, low, middle - _CORNER, f, o)
        late = _search_edge(q, middle + _CORNER, high, f, o)
        off, other = subtract(early, q), subtract(late, q)
        x, y, z = early if dot(off, off) < dot(other, other) else late
    else:
        x, y, z = _search_edge(q, low, high, f, o)
    return x, y if p[1] >= 0.0 else -y, z


@compiled
def _search_edge(q: Vector, low: float, high: float, f: FloatArray, o: int) -> Vector:
    """Return the point of the curve (m) between two angles at which the distance from ``q`` has a minimum.

    The false position, in the Illinois variant: the value at an end that stays twice is halved.
    """
    below, above = _slope_of_distance(q, low, f, o), _slope_of_distance(q, high, f, o)
    side = 0
    for _ in range(60):
        if not below < 0.0 < above:
            break
        phi = (low * above - high * below) / (above - below)
        slope = _slope_of_distance(q, phi, f, o)
        if min(phi - low, high - phi) < 1e-12 or slope == 0.0:
            low = high = phi
            break
        if slope < 0.0:
            low, below = phi, slope
            above *= 0.5 if side < 0 else 1.0
            side = -1
        else:
            high, above = phi, slope
            below *= 0.5 if side > 0 else 1.0
            side = 1
    return edge_point(high if above <= 0.0 else low, f, o)[0]


@compiled
def _slope_of_distance(q: Vector, phi: float, f: FloatArray, o: int) -> float:
    point, slope = edge_point(phi, f, o)
    return dot(subtract(point, q), slope)


@compiled
def is_far_in_fittings(position: Vector, reach: float, f: FloatArray) -> bool:
    """Return True if nothing within ``reach`` (m) of ``position`` can touch a wall.

    A bore holds every ball of its radius about its axis. A body within ``reach`` of a point is therefore clear if the narrowest bore
    that it may reach leaves room around it.
    """
    narrowest = np.inf
    for k in range(int(f[0])):
        o = HEAD + k * PART
        off = subtract(position, (f[o + CENTRE], f[o + CENTRE + 1], f[o + CENTRE + 2]))
        near = f[o + EXTENT] + reach
        if dot(off, off) <= near * near:
            narrowest = min(narrowest, f[o + NARROWEST])
    room = narrowest - reach
    if room <= 0.0:
        return False
    o, gap = find_part(position, f)
    p = to_part(position, f, o)
    kind = f[o + KIND]
    if kind == BEND:
        return bool(f[o + RADIUS] - gap < room)
    if kind == TEE:
        a, b, _ = beyond_bores(p, f, o)
        return bool(a + f[o + RADIUS] < room or b + f[o + END_RADIUS] < room)
    return bool(p[1] * p[1] + p[2] * p[2] < room * room)
