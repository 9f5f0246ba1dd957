"""Compiled code: the volume that joints and seats add to a hull, and the seats that hold its core, without drawing them.

All compiled functions are in this file, because the cache of a function detects no changes of other files of this plugin.

Surfaces are polylines (k, 2) of position and radius, in ascending order; lengths are in mm.
"""

import math
from typing import NamedTuple

import numpy as np

from driftform.types import FloatArray
from driftform.util import allocating, compiled


class Cut(NamedTuple):
    """A joint: the numbers of :class:`driftform_kit.cutting.joint.Joint`, and what follows from them in a hull.

    ``width`` is that of the groove, ``lead`` the size of the chamfer, ``root`` the radius inside the plug at the cut, ``tip`` that
    outside its end, ``core`` the radius that the core needs, and ``furthest`` how far from the cut the joint may reach. The
    surfaces are those of the ``bore`` along z, and along s from the cut towards the part with the plug the ``mouth`` where
    the parts meet, the plug's ``inner`` and ``outer`` side, and the ``bottom`` of the socket.
    """

    z: float
    side: float
    lap: float
    plug: float
    gap: float
    recess: float
    groove: float
    width: float
    lead: float
    root: float
    tip: float
    core: float
    furthest: float
    bore: FloatArray
    mouth: FloatArray
    inner: FloatArray
    outer: FloatArray
    bottom: FloatArray


STEP = 0.04
"""Thickness of the slices of joints."""

FINE = 0.02
"""Thickness of the slices of seats."""

HEIGHTS = 480
"""Heights at which the least radius around the core is known."""

PLACES = 25
"""Places tried between that of the core and the end of its play."""

AREA = 1e-3
"""mm2: sections that share less than this do not meet."""

_GAUSS = (0.5 - math.sqrt(1.0 / 12.0), 0.5 + math.sqrt(1.0 / 12.0))


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
def read_radius(line: FloatArray, x: float) -> float:
    """Return the radius of a surface, 0 beyond its ends."""
    low, high = 0, line.shape[0] - 1
    if x < line[0, 0] or x > line[high, 0]:
        return 0.0
    while high - low > 1:
        middle = (low + high) // 2
        if line[middle, 0] <= x:
            low = middle
        else:
            high = middle
    run = line[high, 0] - line[low, 0]
    share = (x - line[low, 0]) / run if run > 0.0 else 0.0
    return float(line[low, 1] + share * (line[high, 1] - line[low, 1]))


@compiled
def _find_groove(cut: Cut) -> tuple[float, float]:
    """Return the ends of the bottom of a joint's groove, of which that at the plug's tip is sloped."""
    far = -(cut.lap + cut.width - cut.groove) / 2.0
    return far, far + cut.width


@compiled
def read_part(cut: Cut, plug: bool, s: float) -> tuple[float, float]:
    """Return the least and the greatest radius of a part at a joint: the one with the plug, or the other.

    What continues into the wall has an infinite greatest radius; a part that is not there has an infinite least one.
    """
    z = cut.z + cut.side * s
    wall, end = read_radius(cut.bore, z), -(cut.lap + cut.gap)
    least = math.sqrt(max(0.0, cut.core * cut.core - z * z))
    if not plug:
        if s > 0.0:
            return math.inf, math.inf
        if s >= end:
            # The bottom of the socket, in the wall of a rabbet, and else where the cavity has a ledge.
            return max(read_radius(cut.bottom, s), least if cut.recess == 0.0 else 0.0), math.inf
        return min(wall, max(least, read_radius(cut.mouth, s))), math.inf
    if s < -cut.lap:
        return math.inf, math.inf
    inner = read_radius(cut.inner, s)
    if s >= 0.0:
        root = min(inner, cut.root) if s < cut.plug else cut.root + s - cut.plug
        return min(wall, max(least, root)), math.inf
    outer = read_radius(cut.outer, s)
    if cut.recess == 0.0:
        # The chamfer at the tip, and the groove of an O-ring.
        outer = min(outer, cut.tip - cut.lead + cut.lap + s)
        far, near = _find_groove(cut)
        if cut.groove > 0.0 and s <= near:
            outer = min(outer, cut.tip - cut.groove + max(0.0, far - s))
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


@allocating
def add_joint(cut: Cut, out: FloatArray) -> None:
    """Add the integrals (mm3 to mm5) of what a joint adds to a hull, less what it removes."""
    count, far, near = cut.bore.shape[0], *_find_groove(cut)
    knots = np.empty(count + 6)
    for k in range(count):
        knots[k] = cut.side * (cut.bore[k, 0] - cut.z)
    # Nothing is added beyond the ends of the cavity, which may be flat.
    lowest = max(-cut.furthest, min(knots[0], knots[count - 1]))
    highest = min(cut.furthest, max(knots[0], knots[count - 1]))
    knots[count], knots[count + 1], knots[count + 2] = -cut.lap - cut.gap, -cut.lap, 0.0
    knots[count + 3], knots[count + 4], knots[count + 5] = cut.plug, far, near
    knots.sort()
    for k in range(count + 6):
        low, high = max(lowest, knots[k - 1] if k > 0 else lowest), min(highest, knots[k])
        if high > low:
            _add_slices(cut, low, high, out)
    if highest > knots[count + 5]:
        _add_slices(cut, max(lowest, knots[count + 5]), highest, out)


@compiled
def _add_slices(cut: Cut, low: float, high: float, out: FloatArray) -> None:
    """Add the integrals of what a joint adds between two values of s, where no surface has a ledge."""
    count = max(1, int((high - low) / STEP))
    step = (high - low) / count
    for i in range(count):
        for k in range(2):
            s, width = low + (i + _GAUSS[k]) * step, 0.5 * math.pi * step
            z = cut.z + cut.side * s
            least, _ = read_part(cut, s > 0.0, s)
            _add_ring(z, least, read_radius(cut.bore, z), width, out)
            inner, outer = read_part(cut, True, s)
            if s < 0.0 and outer < math.inf:
                _add_ring(z, inner, outer, width, out)


@allocating
def holds_core(cut: Cut, core: float, play: float, lift: float) -> tuple[bool, bool]:
    """Return whether a core that moves along the axis, aft or fore, comes to rest within its play on what centres it.

    A flat end does not centre it: the core rolls aside.
    """
    reach, room = core + play, np.empty(HEIGHTS)
    for i in range(HEIGHTS):
        s = cut.side * (reach * ((2 * i + 1) / HEIGHTS - 1.0) - cut.z)
        room[i] = min(read_part(cut, True, s)[0], read_part(cut, False, s)[0])
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


@allocating
def place_seat(
    cut: Cut, radius: float, half: float, overlap: float, side: float, latitude: float, out: FloatArray
) -> bool:
    """Add the integrals of a seat at a latitude on one side of the core, if there is room; return whether there is.

    A strip about the ray of that latitude, ``half`` wide on either side, runs from ``radius``, that of the core with its gap, into
    the wall by ``overlap``. It must touch its own part, and keep the gap from the other one.
    """
    c, sine, gap = math.cos(latitude), math.sin(latitude), cut.gap
    own, total = (side > 0) == (cut.side > 0.0), np.zeros(4)
    end = -cut.bore[0, 0] if side < 0.0 else cut.bore[cut.bore.shape[0] - 1, 0]
    # The cavity may have a flat end: a slice ends there.
    away = end - FINE * (0.5 + math.floor((end - radius * sine + (half + gap) * c + gap) / FINE))
    touched, taken, joined, ends, ended = 0.0, 0.0, False, False, False
    while not ends:
        s, wall = cut.side * (side * away - cut.z), read_radius(cut.bore, side * away)
        beyond = read_radius(cut.bore, side * min(away, end)) + overlap if away <= end + overlap else 0.0
        inner, outer = (c * away - half) / sine, (c * away + half) / sine
        arc = math.sqrt(max(0.0, radius * radius - away * away))
        least, greatest = read_part(cut, not own, s)
        taken += FINE * max(
            0.0, min(outer + gap / sine, beyond + gap, greatest) - max(inner - gap / sine, arc, least)
        )
        least, greatest = read_part(cut, own, s)
        touched += FINE * max(0.0, min(outer, beyond, greatest) - max(inner, arc, least))
        ends = inner - gap / sine > beyond + gap
        inner, ended = max(0.0, inner, arc), ended or inner > wall + overlap
        # Beyond where they meet, what is left between the seat and its part would be sealed: it is filled.
        joined = joined or (greatest > inner and outer >= least)
        outer = least if joined else outer
        if outer > inner and not ended:
            _add_ring(side * away, inner, outer, math.pi * FINE, total)
        away += FINE
    # The sections have another half on the other side of the axis.
    if 2.0 * touched < AREA or 2.0 * taken > AREA:
        return False
    for k in range(4):
        out[k] += total[k]
    return True
