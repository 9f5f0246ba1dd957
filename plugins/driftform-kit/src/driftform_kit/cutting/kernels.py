"""Compiled code: the volume that joints and seats add to a hull, and the seats that hold its core, without drawing them.

All compiled functions are in this file, because the cache of a function detects no changes of other files of this plugin.

A joint is a row of :data:`Z` to :data:`FURTHEST` and the radius of its meeting surface, points (s, r) with s from its cut towards
the part with the plug, in ascending order. That surface, and those at a distance from it, are polylines; the parts at a
joint lie between them and the cavity. Lengths are in mm.
"""

import math

import numpy as np

from driftform.types import FloatArray
from driftform.util import allocating, compiled

Z, SIDE, LAP, PLUG, GAP, RECESS, GROOVE, WIDTH, LEAD, BORE, TIP, CORE, FURTHEST = range(13)
"""Numbers of a joint: those of :class:`driftform_kit.cutting.joint.Joint`, width of the groove and size of the chamfer, the radius
inside the plug at the cut and outside its tip, the radius that the core needs, and how far from the cut the joint may
reach."""

STEP = 0.05
"""Thickness of the slices of joints and seats."""

FINE = 0.02
"""Thickness of the slices in which a seat is clear of other parts."""

HEIGHTS = 480
"""Heights at which the least radius around the core is known."""

PLACES = 25
"""Places tried between that of the core and the end of its play."""

AREA = 1e-3
"""mm2: sections that share less than this do not meet."""

_GAUSS = (0.5 - math.sqrt(1.0 / 12.0), 0.5 + math.sqrt(1.0 / 12.0))


@compiled
def read_line(line: FloatArray, s: float) -> float:
    """Return the radius of a polyline (k, 2) in ascending order of s, which continues straight beyond its ends."""
    k = 1
    while k < line.shape[0] - 1 and line[k, 0] < s:
        k += 1
    run = line[k, 0] - line[k - 1, 0]
    share = (s - line[k - 1, 0]) / run if run > 0.0 else 0.0
    return float(line[k - 1, 1] + share * (line[k, 1] - line[k - 1, 1]))


@allocating
def move_line(line: FloatArray, by: float) -> FloatArray:
    """Return a polyline moved towards the axis, (k, 2), with mitres at its corners and without the edges that vanish.

    The last point is repeated for each of these.
    """
    last = line.shape[0] - 1
    moved, edges, count = np.empty((last + 1, 2)), np.empty((last, 4)), 0
    for i in range(last):
        run, rise = line[i + 1, 0] - line[i, 0], line[i + 1, 1] - line[i, 1]
        length = math.sqrt(run * run + rise * rise)
        if length == 0.0:
            continue
        run, rise = run / length, rise / length
        s, r = line[i, 0] + by * rise, line[i, 1] - by * run
        while count > 0:
            # Where it meets the edge before, along that; behind the start of that edge nothing is left of it.
            across = edges[count - 1, 2] * rise - edges[count - 1, 3] * run
            ds, dr = s - edges[count - 1, 0], r - edges[count - 1, 1]
            along = (ds * rise - dr * run) / across if abs(across) > 1e-9 else ds
            if along > 0.0 or count == 1:
                s, r = (
                    edges[count - 1, 0] + along * edges[count - 1, 2],
                    edges[count - 1, 1] + along * edges[count - 1, 3],
                )
                break
            count -= 1
        edges[count, 0], edges[count, 1], edges[count, 2], edges[count, 3] = s, r, run, rise
        moved[count, 0], moved[count, 1] = s, r
        count += 1
    for i in range(count, last + 1):
        moved[i, 0] = line[last, 0] + by * edges[count - 1, 3]
        moved[i, 1] = line[last, 1] - by * edges[count - 1, 2]
    return moved


@compiled
def read_bore(bore: FloatArray, z: float) -> float:
    """Return the radius of a cavity (n, 2) of ascending z, 0 beyond its ends."""
    low, high = 0, bore.shape[0] - 1
    if z < bore[0, 0] or z > bore[high, 0]:
        return 0.0
    while high - low > 1:
        middle = (low + high) // 2
        if bore[middle, 0] <= z:
            low = middle
        else:
            high = middle
    run = bore[high, 0] - bore[low, 0]
    share = (z - bore[low, 0]) / run if run > 0.0 else 0.0
    return float(bore[low, 1] + share * (bore[high, 1] - bore[low, 1]))


@compiled
def _find_groove(joint: FloatArray) -> tuple[float, float]:
    """Return the ends of the bottom of a joint's groove, of which that at the plug's tip is sloped."""
    far = -(joint[LAP] + joint[WIDTH] - joint[GROOVE]) / 2.0
    return far, far + joint[WIDTH]


@compiled
def read_part(
    joint: FloatArray, lines: FloatArray, bore: FloatArray, plug: bool, s: float
) -> tuple[float, float]:
    """Return the least and the greatest radius of a part at a joint: the one with the plug, or the other.

    What continues into the wall has an infinite greatest radius; a part that is not there has an infinite least one.
    ``lines`` are the meeting surface, the plug's inner and outer surface, and the bottom of the socket, (4, k, 2).
    """
    z = joint[Z] + joint[SIDE] * s
    wall, end = read_bore(bore, z), -(joint[LAP] + joint[GAP])
    least = math.sqrt(max(0.0, joint[CORE] * joint[CORE] - z * z))
    if not plug:
        if s > 0.0:
            return math.inf, math.inf
        if s >= end:
            # The bottom of the socket, in the wall of a rabbet, and else where the cavity has a ledge.
            return max(read_line(lines[3], s), least if joint[RECESS] == 0.0 else 0.0), math.inf
        return min(wall, max(least, read_line(lines[0], s))), math.inf
    if s < -joint[LAP]:
        return math.inf, math.inf
    inner = read_line(lines[1], s)
    if s >= 0.0:
        root = min(inner, joint[BORE]) if s < joint[PLUG] else joint[BORE] + s - joint[PLUG]
        return min(wall, max(least, root)), math.inf
    outer = read_line(lines[2], s)
    if joint[RECESS] == 0.0:
        # The chamfer at the tip, and the groove of an O-ring.
        outer = min(outer, joint[TIP] - joint[LEAD] + joint[LAP] + s)
        far, near = _find_groove(joint)
        if joint[GROOVE] > 0.0 and s <= near:
            outer = min(outer, joint[TIP] - joint[GROOVE] + max(0.0, far - s))
    inner = max(inner, least)
    return (inner, outer) if outer > inner else (math.inf, math.inf)


@compiled
def _add_ring(z: float, least: float, greatest: float, width: float, out: FloatArray) -> None:
    """Add the integrals of a thin ring: its volume, its moments of z of first and second order, and its polar moment."""
    inner, outer = least * least, greatest * greatest
    volume = width * (outer - inner)
    out[0] += volume
    out[1] += volume * z
    out[2] += volume * z * z
    out[3] += volume * (outer + inner) / 2.0


@compiled
def add_joint(joint: FloatArray, lines: FloatArray, bore: FloatArray, out: FloatArray) -> None:
    """Add the integrals (mm3 to mm5) of what a joint adds to a hull, less what it removes."""
    groove, far = _find_groove(joint), joint[FURTHEST]
    ends = (-far, -joint[LAP] - joint[GAP], -joint[LAP], *groove, 0.0, joint[PLUG], far)
    first = joint[SIDE] * (bore[0, 0] - joint[Z])
    last = joint[SIDE] * (bore[bore.shape[0] - 1, 0] - joint[Z])
    for piece in range(7):
        # Nothing is added beyond the ends of the cavity, which may be flat.
        low, high = max(ends[piece], min(first, last)), min(ends[piece + 1], max(first, last))
        while low < high:
            stop = high
            for k in range(bore.shape[0] - 1):
                ledge = joint[SIDE] * (bore[k, 0] - joint[Z])
                if bore[k + 1, 0] - bore[k, 0] < 1e-9 and low + 1e-9 < ledge < stop:
                    stop = ledge
            # Nothing but slopes of 45 degrees lies beyond.
            _add_slices(joint, lines, bore, low, stop, STEP if 0 < piece < 6 else 2.0 * STEP, out)
            low = stop


@compiled
def _add_slices(
    joint: FloatArray,
    lines: FloatArray,
    bore: FloatArray,
    low: float,
    high: float,
    step: float,
    out: FloatArray,
) -> None:
    """Add the integrals of what a joint adds between two values of s, where no surface has a ledge."""
    count = max(1, int((high - low) / step))
    step = (high - low) / count
    for i in range(count):
        for k in range(2):
            s, width = low + (i + _GAUSS[k]) * step, 0.5 * math.pi * step
            z = joint[Z] + joint[SIDE] * s
            least, _ = read_part(joint, lines, bore, s > 0.0, s)
            _add_ring(z, least, read_bore(bore, z), width, out)
            inner, outer = read_part(joint, lines, bore, True, s)
            if s < 0.0 and outer < math.inf:
                _add_ring(z, inner, outer, width, out)


@allocating
def holds_core(
    joint: FloatArray, lines: FloatArray, bore: FloatArray, core: float, play: float, lift: float
) -> tuple[bool, bool]:
    """Return whether a core that moves along the axis, aft or fore, comes to rest within its play on what centres it.

    A flat end does not centre it: the core rolls aside.
    """
    reach, room = core + play, np.empty(HEIGHTS)
    for i in range(HEIGHTS):
        s = joint[SIDE] * (reach * ((2 * i + 1) / HEIGHTS - 1.0) - joint[Z])
        room[i] = min(read_part(joint, lines, bore, True, s)[0], read_part(joint, lines, bore, False, s)[0])
    return _holds(room, core, play, lift, -1.0), _holds(room, core, play, lift, 1.0)


@compiled
def _holds(room: FloatArray, core: float, play: float, lift: float, side: float) -> bool:
    if not _meets(room, core, play, 0.0, side * play):
        return False
    rest, free = PLACES, -1
    while rest - free > 1:
        middle = (rest + free) // 2
        if _meets(room, core, play, 0.0, side * play * middle / PLACES):
            rest = middle
        else:
            free = middle
    return bool(_meets(room, core, play, play, side * (play * rest / PLACES - lift)))


@compiled
def _meets(room: FloatArray, core: float, play: float, aside: float, along: float) -> bool:
    """Return whether the section of a core that is moved shares an area with the parts."""
    reach, area = core + play, 0.0
    step = 2.0 * reach / HEIGHTS
    for i in range(HEIGHTS):
        z = (i + 0.5) * step - reach - along
        if abs(z) < core:
            half = math.sqrt(core * core - z * z)
            area += step * (max(0.0, half + aside - room[i]) + max(0.0, half - aside - room[i]))
    return area > AREA


@compiled
def place_seat(
    joint: FloatArray,
    lines: FloatArray,
    bore: FloatArray,
    radius: float,
    half: float,
    overlap: float,
    side: float,
    latitude: float,
    out: FloatArray,
) -> bool:
    """Add the integrals of a seat at a latitude on one side of the core, if there is room; return whether there is.

    A strip about the ray of that latitude, ``half`` wide on either side, runs from ``radius``, that of the core with its gap, into
    the wall by ``overlap``. It must touch its own part, and keep the gap from the other one.
    """
    c, sine, gap = math.cos(latitude), math.sin(latitude), joint[GAP]
    own = (side > 0) == (joint[SIDE] > 0.0)
    straight = math.sqrt(radius * radius - half * half)
    start, low = straight * sine - half * c, radius * sine - (half + gap) * c - gap
    touched, taken, i, ends = 0.0, 0.0, 0, False
    end = -bore[0, 0] if side < 0.0 else bore[bore.shape[0] - 1, 0]
    while not ends:
        away = low + (i + 0.5) * FINE
        z, i = side * away, i + 1
        s, wall = joint[SIDE] * (z - joint[Z]), 0.0
        if away <= end + overlap:
            # Also into an end that is flat.
            wall = read_bore(bore, side * min(away, end)) + overlap
        inner, outer = (c * away - half) / sine, (c * away + half) / sine
        ends = inner - gap / sine > wall + gap
        arc = math.sqrt(max(0.0, radius * radius - away * away))
        least, greatest = read_part(joint, lines, bore, not own, s)
        taken += FINE * max(
            0.0, min(outer + gap / sine, wall + gap, greatest) - max(inner - gap / sine, arc, least)
        )
        least, greatest = read_part(joint, lines, bore, own, s)
        touched += FINE * max(0.0, min(outer, wall, greatest) - max(inner, arc, least))
    # The sections have another half on the other side of the axis.
    if 2.0 * touched < AREA or 2.0 * taken > AREA:
        return False
    end = min(end, low + i * FINE)
    count, joined = max(1, int((end - start) / STEP)), False
    step = (end - start) / count
    for j in range(count):
        for k in range(2):
            away = start + (j + _GAUSS[k]) * step
            z = side * away
            arc = math.sqrt(max(0.0, radius * radius - away * away))
            inner, outer = max(0.0, (c * away - half) / sine, arc), (c * away + half) / sine
            least, greatest = read_part(joint, lines, bore, own, joint[SIDE] * (z - joint[Z]))
            # Beyond where they meet, what is left between the seat and its part would be sealed: it is filled.
            joined = joined or (greatest > inner and outer >= least)
            outer = least if joined else outer
            if inner > read_bore(bore, z) + overlap:
                return True
            if outer > inner:
                _add_ring(z, inner, outer, 0.5 * math.pi * step, out)
    return True
