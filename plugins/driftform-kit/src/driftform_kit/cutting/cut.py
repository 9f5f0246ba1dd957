"""Choosing the cuts of a hull: one for the core, and others at joints of modules if a part is too long for the bed."""

import math
from collections.abc import Sequence
from itertools import pairwise
from operator import itemgetter
from types import ModuleType
from typing import NamedTuple

import numpy as np

from driftform.agent import distance_from
from driftform.errors import WorkFailedError
from driftform_frusta.kit_options import KitOptions
from driftform_kit.cutting import bayonet, thread
from driftform_kit.cutting.bay import core_ball
from driftform_kit.cutting.gland import choose_gland
from driftform_kit.cutting.joint import LIP, Joint, Line, plug_bore, radii_along, seal_length, trace_mouth
from driftform_kit.cutting.meridian import MM, Hull

LOCKS: dict[str, ModuleType] = {"bayonet": bayonet, "thread": thread}
"""What draws the kinds of joints that open: their ``HEIGHT`` and ``LENGTH``, ``draw_lugs`` of the socket, ``cut_tracks`` of the plug."""

STEP = 0.25
"""mm between the places that are tried for the joint beside the core."""

MIN_BORE = 0.35
"""mm: least radius of the bore of a plug."""

SLIM_BORE = 4.0
"""mm: a plug with a narrower bore is a weak joint, made only if all joints are slim."""

MAX_STEP = 3.0
"""mm: a thicker step of a rabbet is not stronger than its glue."""

_TINY = 1e-9
"""mm: rounding of sums of lengths is less than this."""

_ROUNDING = 0.01
"""mm: chords of the dome lie inside its circle by less than this."""


def choose_core_joint(hull: Hull, options: KitOptions) -> tuple[Joint, str]:
    """Return the joint of the two shells, through which the core is inserted, and the reason for the choice.

    It is a sleeve, or one that opens if that is asked for, as near to the core's equator as possible, or a rabbet at the equator. Fails if
    the requested joint, or any joint, has no room.
    """
    sleeve = None if options.joint == "rabbet" else _find_sleeve(hull, options)
    if sleeve is not None:
        away = abs(sleeve.z)
        place = (
            "at the core's equator"
            if not away
            else f"{away:g} mm {_name_side(1 if sleeve.z > 0 else -1)} of the core's equator, where the core leaves room inside"
        )
        return sleeve, f"a {sleeve.kind} of {sleeve.plug:.4g} mm {place}"
    tried = make_sleeve(0.0, 1, options, seals=True)
    no_sleeve = (
        f"no {tried.kind} of {tried.plug:.4g} mm fits beside the core: on neither side does the hull stay as wide "
        f"as the core for the {tried.lap:.4g} mm of its lap and a wall to hold it"
    )
    if tried.kind in LOCKS:
        fault = (
            f"no kit can be made: {no_sleeve}, with a cavity of {2 * (hull.room(tried.gap) + getattr(LOCKS.get(tried.kind), 'HEIGHT', 0.0)):.1f} mm or more across there. A larger radius of the hull "
            "would do, a smaller core, or a thinner cord (o_ring); or set joint to 'auto', and glue it"
        )
    elif options.joint == "sleeve":
        fault = f"{no_sleeve}; set joint to 'rabbet', or lap or sleeve to less"
    elif options.o_ring:
        fault = f"{no_sleeve}, and without a sleeve there is no groove for an O-ring: set o_ring to 0"
    else:
        return _make_rabbet(hull, options), ("joint is set to 'rabbet'" if options.joint == "rabbet" else no_sleeve)
    raise WorkFailedError(fault, violations={"kit": _find_lack(hull, options) / MM})


def _find_sleeve(hull: Hull, options: KitOptions) -> Joint | None:
    need = hull.room(MM * options.clearance) - _ROUNDING
    roomy = {side: _list_roomy(hull, side, need, options) for side in (1, -1)}
    for away in sorted(roomy[1] | roomy[-1]):
        fitting = [
            joint
            for side in (1, -1)
            if away in roomy[side]
            and _takes_core(hull, joint := make_sleeve(side * away, side, options, seals=True), need)
        ]
        if fitting:
            # The wider mouth takes a wider plug.
            return max(fitting, key=lambda joint: plug_bore(hull, joint))
    return None


def _find_lack(hull: Hull, options: KitOptions) -> float:
    """Return by how much a hull is too narrow beside its core for a plug and for the core to pass, where least, mm."""
    lacks = []
    for side in (1, -1):
        tried = make_sleeve(0.0, side, options, seals=True)
        away = np.arange(0.0, 4 * hull.reach, STEP)
        mouth, tip = hull.bore_radius(side * away), np.maximum(away - tried.lap, 0.0)
        passing = np.maximum.accumulate(hull.room(tried.gap) + _height(tried) - mouth)
        beside = hull.core + tried.gap - hull.beside_core(np.maximum(mouth - tried.gap - tried.plug, 0.0), side * tip)
        lacks.append(float(np.maximum(passing, beside).min()))
    return max(_ROUNDING, min(lacks))


def _list_roomy(hull: Hull, side: int, need: float, options: KitOptions) -> set[float]:
    """Distances from the core's equator, mm, at which a plug may leave room for the core, which passes so far."""
    tried = make_sleeve(0.0, side, options, seals=True)
    gap, plug, lap = tried.gap, tried.plug, tried.lap
    away = np.arange(0.0, 4 * hull.reach, STEP)
    mouth = hull.bore_radius(side * away)
    narrow = np.flatnonzero(mouth < need)
    reach = narrow[0] if len(narrow) else len(away) - 1
    away, mouth = away[:reach], mouth[:reach]
    # A plug is nowhere wider inside than at its mouth, and at its tip not wider than the cavity there: few places need
    # a closer look.
    tip, least = away - lap, hull.core + gap - _ROUNDING
    wide = hull.beside_core(mouth - gap - plug, side * np.maximum(tip, 0.0)) >= least
    wide &= hull.beside_core(hull.bore_radius(side * tip) - gap - plug, side * tip) >= least - _TINY
    return set(away[wide].tolist())


def make_sleeve(z: float, side: int, options: KitOptions, seals: bool = False) -> Joint:
    """Return a sleeve at a height, or, where the core goes in and it ``seals``, the bayonet or the thread that is asked for.

    With an O-ring it is thick enough for two printed lines below the groove, and long enough for all that it has.
    """
    opens = options.joint in LOCKS
    cord = MM * (options.cord if seals or not opens else 0.0)
    plug, lap, gap = MM * options.sleeve, MM * options.lap, MM * options.clearance
    if not cord:
        return Joint(z, side, "sleeve", lap, plug, gap)
    gland = choose_gland(cord)
    plug = max(plug, gland.depth - gap + max(LIP, 2 * MM * options.nozzle))
    kind = options.joint if options.joint in ("bayonet", "thread") else "sleeve"
    return Joint(
        z, side, kind, max(lap, seal_length(gland) + getattr(LOCKS.get(kind), "LENGTH", 0.0)), plug, gap, gland
    )


def _height(joint: Joint) -> float:
    """How far what locks a joint stands into its bore, mm."""
    return getattr(LOCKS.get(joint.kind), "HEIGHT", 0.0)


def _takes_core(hull: Hull, joint: Joint, need: float) -> bool:
    """Return whether the core passes the socket, whose radius must be ``need`` or more, and leaves room for the plug."""
    line = trace_mouth(hull, joint)
    if line[-1][1] - _height(joint) < need or not _is_rooted(hull, joint, line):
        return False
    if joint.gland:
        # Behind the chamfer it is a cylinder.
        line = [(0.0, line[-1][1]), line[-1]]
    passage = joint.side * joint.z
    s = np.linspace(-joint.lap, 0.0, 2 + math.ceil(joint.lap / STEP))
    inside = radii_along(line, -s) - _slant_factor(line) * (joint.gap + joint.plug)
    clear = hull.beside_core(inside, joint.side * (passage + s))
    return bool(clear.min() >= hull.core + joint.gap - _ROUNDING)


def _slant_factor(line: Line) -> float:
    """Largest radial extent of a thickness normal to the meeting surface, over that thickness."""
    slopes = [(r - r_before) / (s - before) for (before, r_before), (s, r) in pairwise(line) if s < before]
    return math.sqrt(1 + max((slope * slope for slope in slopes), default=0.0))


def _is_rooted(hull: Hull, joint: Joint, line: Line) -> bool:
    """Return whether the cavity continues past the plug, and whether the plug, in its mouth ``line``, has a bore."""
    if any(hull.bore_at(joint.z + joint.side * joint.plug * step) <= 0 for step in range(4)):
        return False
    return line[-1][1] - _slant_factor(line) * (joint.gap + joint.plug) >= MIN_BORE


def _make_rabbet(hull: Hull, options: KitOptions) -> Joint:
    step, gap = (hull.wall - MM * options.clearance) / 2, MM * options.clearance
    if step < MM * options.nozzle - 1e-6:
        raise WorkFailedError(
            f"no kit can be made: a rabbet in a wall of {hull.wall:g} mm leaves steps of {step:.3g} mm at a clearance "
            f"of {gap:g} mm, less than the nozzle of {MM * options.nozzle:g} mm; make the wall thicker or the "
            "clearance smaller"
        )
    lap = MM * options.lap / 2
    least = [_fill_depth(hull, Joint(0.0, side, "rabbet", lap, step, gap)) for side in (1, -1)]
    return Joint(0.0, 1 if least[0] <= least[1] else -1, "rabbet", lap, step, gap)


def _fill_depth(hull: Hull, joint: Joint) -> float:
    """Depth by which the socket is filled, mm: the cavity's radius along it less that of the mouth."""
    s = np.linspace(0.0, joint.lap, 20)
    line = trace_mouth(hull, joint)
    return float((hull.bore_radius(joint.z - joint.side * s) - radii_along(line, s)).max())


def choose_bed_joints(hull: Hull, first: Joint, options: KitOptions) -> tuple[Joint, ...]:
    """Return the fewest joints in addition to that of the core that leave parts which fit the bed, from aft to fore.

    Fails if a part is wider than the bed, or too high even if every joint of modules that takes a sleeve is cut.
    """
    width, depth, height = (MM * side for side in options.bed)
    if 2 * hull.widest > min(width, depth):
        raise WorkFailedError(
            f"no kit can be made: the hull is {2 * hull.widest:.1f} mm wide, the bed {width:g} x {depth:g} mm, "
            "and parts are cut across the axis only",
            violations={"bed": (2 * hull.widest - min(width, depth)) / MM},
        )
    aft = _cut_side(hull, first, -1, height, options)
    fore = _cut_side(hull, first, 1, height, options)
    return (*aft[::-1], *fore)


def _make_step(hull: Hull, z: float, side: int, options: KitOptions) -> Joint | None:
    """Return a rabbet as long as a sleeve in a wall that has room for twice its thickness; ``None`` if that is too thin."""
    plug, lap, gap = MM * options.sleeve, MM * options.lap, MM * options.clearance
    along = z - side * np.linspace(-plug, lap + gap, 2 * math.ceil(lap / STEP))
    line = np.column_stack((along, np.maximum(hull.bore_radius(along), hull.bore_at(z))))
    wall = float(distance_from(line, hull.skin).min())
    sealed = options.o_ring and options.joint not in LOCKS
    if sealed or not hull.bore_at(z) or wall < 2 * plug + gap:
        return None
    return Joint(z, side, "rabbet", lap, min((wall - gap) / 2, MAX_STEP), gap)


def _seat_end(hull: Hull, side: int) -> float:
    """Largest distance of a seat from the core's equator, mm: a cone of 45 degrees ends at the wall."""
    foot = side * core_ball(hull).find_foot(math.pi / 4, side)
    away = np.arange(0.0, side * float(hull.bore[-1 if side > 0 else 0, 0]) + 2 * STEP, STEP)
    return float(away[np.argmax(hull.bore_radius(side * away) <= away - foot)])


def _cut_side(hull: Hull, first: Joint, side: int, height: float, options: KitOptions) -> tuple[Joint, ...]:
    """Cuts on one side, from the core outward, beyond the core's seat."""
    end = float(hull.skin[-1 if side > 0 else 0, 0])
    # On the bed, a part extends from the tip of its plug to the beginning of its neighbour.
    start = first.tip if first.side == side else first.z
    if side * (end - start) <= height:
        return ()
    margin = 2 * (MM * options.lap + 3 * MM * options.sleeve)
    keep = max(_seat_end(hull, side), side * first.z) + margin
    places = [side * z for z in hull.joints if keep <= side * z <= side * end - 2 * MM * options.sleeve]
    joints = [_make_step(hull, side * z, side, options) or make_sleeve(side * z, side, options) for z in sorted(places)]
    while True:
        chosen = _choose_fewest(hull, joints, side * start, side * end, height, margin, _name_side(side))
        # Few joints are chosen, and nearly all are rooted: only those chosen are traced.
        sleeves = [joint for joint in chosen if joint.kind == "sleeve"]
        loose = [joint for joint in sleeves if not _is_rooted(hull, joint, trace_mouth(hull, joint))]
        if not loose:
            return chosen
        joints = [joint for joint in joints if joint not in loose]


class _Cuts(NamedTuple):
    """Cuts from the core outward: how many of them are slim, the highest part that they leave, and where the next begins."""

    slim: int
    highest: float
    joints: tuple[Joint, ...]
    begin: float

    def takes(self, z: float, height: float, margin: float) -> bool:
        """Return whether a joint can follow: the part before it is not too high, and has room for both its joints."""
        return z - self.begin <= height and (not self.joints or z - abs(self.joints[-1].z) >= margin)

    def add(self, z: float, joints: tuple[Joint, ...] = (), slim: bool = False) -> "_Cuts":
        """Return these cuts with a part more, which ends at ``z``; the next begins with its plug."""
        lap = sum(joint.lap for joint in joints)
        return _Cuts(self.slim + slim, max(self.highest, z - self.begin), (*self.joints, *joints), z - lap)


def _choose_fewest(
    hull: Hull, joints: Sequence[Joint], start: float, end: float, height: float, margin: float, what: str
) -> tuple[Joint, ...]:
    """The fewest cuts that leave no part higher than the bed; of those the sturdiest, then the most even.

    Heights are counted outward. Plans of one cut are made first, then those of two, until one leaves no part too high.
    """
    plans, left, best = [_Cuts(0, 0.0, (), start)], list(joints), itemgetter(0, 1)
    while plans:
        reached, beyond = list[_Cuts](), list[Joint]()
        for joint in left:
            z, slim = abs(joint.z), plug_bore(hull, joint) < SLIM_BORE
            if found := [plan.add(z, (joint,), slim) for plan in plans if plan.takes(z, height, margin)]:
                reached.append(min(found, key=best))
            else:
                beyond.append(joint)
        if last := [plan.add(end) for plan in reached if end - plan.begin <= height]:
            return min(last, key=best).joints
        plans, left = reached, beyond
    raise WorkFailedError(
        f"no kit can be made: the {what} side is {end - start:.1f} mm long, the bed takes {height:g} mm, and too "
        "few joints of modules have room for a sleeve to cut it into parts that fit",
        violations={"bed": (end - start - height) / MM},
    )


def _name_side(side: int) -> str:
    return "fore" if side > 0 else "aft"
