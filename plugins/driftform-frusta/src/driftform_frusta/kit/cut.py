"""Choosing the cuts of a hull: one for the core, and others at joints of modules if a part is too long for the bed."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from driftform.errors import WorkFailedError
from driftform.types import FloatArray
from driftform_frusta.kit.joint import Joint, plug_bore, trace_mouth
from driftform_frusta.kit.meridian import MM, Hull
from driftform_frusta.kit.options import KitOptions

STEP = 0.25
"""mm between the places that are tried for the joint beside the core."""

LEAST_BORE = 0.35
"""mm: least radius of the bore of a plug."""

SLIM_BORE = 4.0
"""mm: a plug with a narrower bore is a weak joint, made only if there is no other."""

_ROUNDING = 0.01
"""mm: chords of the dome lie inside its circle by less than this."""


@dataclass(frozen=True)
class CoreJoint:
    """The joint through which the core is inserted, and the reason for the choice."""

    joint: Joint
    reason: str


def choose_core_joint(hull: Hull, options: KitOptions) -> CoreJoint:
    """Return the joint of the two shells: a sleeve as near to the core's equator as possible, or a rabbet at the equator.

    Raises
    ------
    WorkFailedError
        if the requested joint, or any joint, has no room; the message has the reason.
    """
    sleeve = None if options.joint == "rabbet" else _find_sleeve(hull, options)
    if sleeve is not None:
        away = abs(sleeve.z)
        place = (
            "at the core's equator"
            if not away
            else f"{away:g} mm {_name_side_of(sleeve.z)} of the core's equator, where the core leaves room inside"
        )
        return CoreJoint(sleeve, f"a sleeve of {sleeve.plug:g} mm {place}")
    no_sleeve = (
        f"no sleeve of {MM * options.sleeve:g} mm fits beside the core: on neither side does the hull stay as wide "
        f"as the core for the {MM * options.lap:g} mm of its lap and a wall to hold it"
    )
    if options.joint == "sleeve":
        raise WorkFailedError(f"{no_sleeve}; set joint to 'rabbet', or lap or sleeve to less")
    if options.o_ring:
        raise WorkFailedError(
            f"{no_sleeve}, and without a sleeve there is no groove for an O-ring: set o_ring to 0"
        )
    rabbet = _make_rabbet(hull, options)
    return CoreJoint(rabbet, "joint is set to 'rabbet'" if options.joint == "rabbet" else no_sleeve)


def _find_sleeve(hull: Hull, options: KitOptions) -> Joint | None:
    need = hull.room(MM * options.clearance) - _ROUNDING
    gap, plug, lap = MM * options.clearance, MM * options.sleeve, MM * options.lap
    away = np.arange(0.0, max(_reach(hull, side, need) for side in (1, -1)), STEP)
    room = {}
    for side in (1, -1):
        # A plug is nowhere wider inside than at its mouth: most places need no closer look.
        widest = np.hypot(hull.bore_radius(side * away) - gap - plug, np.maximum(away - lap, 0.0))
        room[side] = (widest >= hull.core + gap - _ROUNDING) & (away < _reach(hull, side, need))
    for place in np.flatnonzero(room[1] | room[-1]).tolist():
        fitting = [
            joint
            for side in (1, -1)
            if room[side][place]
            and _takes_core(hull, joint := make_sleeve(side * float(away[place]), side, options), need)
        ]
        if fitting:
            # The wider mouth takes a wider plug.
            return max(fitting, key=lambda joint: plug_bore(hull, joint))
    return None


def _reach(hull: Hull, side: int, need: float) -> float:
    """Distance from the core's equator to which the core passes on one side, limited to four radii, mm."""
    away = np.arange(0.0, 4 * hull.core, STEP)
    narrow = np.flatnonzero(hull.bore_radius(side * away) < need)
    return float(away[narrow[0]]) if len(narrow) else float(away[-1])


def make_sleeve(z: float, side: int, options: KitOptions) -> Joint:
    """Return a sleeve joint at a height."""
    return Joint(
        z=z,
        side=side,
        kind="sleeve",
        lap=MM * options.lap,
        plug=MM * options.sleeve,
        gap=MM * options.clearance,
        groove=MM * options.groove if options.o_ring else 0.0,
        cord=MM * options.o_ring,
    )


def _takes_core(hull: Hull, joint: Joint, need: float) -> bool:
    """Return whether the core passes the socket, whose radius must be ``need`` or more, and leaves room for the plug."""
    line = trace_mouth(hull, joint)
    if line[-1, 1] < need or not _is_rooted(hull, joint, line):
        return False
    passage = joint.side * joint.z
    s = np.linspace(-joint.lap, 0.0, 2 + math.ceil(joint.lap / STEP))
    inside = np.interp(-s, -line[:, 0], line[:, 1]) - _slant_factor(line) * (joint.gap + joint.plug)
    return bool(np.hypot(inside, passage + s).min() >= hull.core + joint.gap - _ROUNDING)


def _slant_factor(line: FloatArray) -> float:
    """Largest radial extent of a thickness normal to the meeting surface, over that thickness."""
    steps = line[1:] - line[:-1]
    run = steps[:, 0] < 0
    return math.sqrt(1 + float(((steps[run, 1] / steps[run, 0]) ** 2).max(initial=0.0)))


def _is_rooted(hull: Hull, joint: Joint, line: FloatArray) -> bool:
    """Return whether the cavity continues behind the plug, and whether the plug, in its mouth ``line``, has a bore."""
    held = joint.z + joint.side * joint.plug * np.arange(4)
    if hull.bore_radius(held).min() <= 0:
        return False
    return float(line[-1, 1]) - _slant_factor(line) * (joint.gap + joint.plug) >= LEAST_BORE


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
    return float((hull.bore_radius(joint.z - joint.side * s) - np.interp(s, -line[:, 0], line[:, 1])).max())


def choose_bed_joints(hull: Hull, first: Joint, options: KitOptions) -> tuple[Joint, ...]:
    """Return the joints that cut shells further until each part fits the bed, from aft to fore; the fewest.

    Parameters
    ----------
    hull
        the hull.
    first
        the joint beside the core.
    options
        the bed, and the sleeves.

    Raises
    ------
    WorkFailedError
        if a part is wider than the bed, or too high even if every joint of modules that takes a sleeve is cut.
    """
    width, depth, height = (MM * side for side in options.bed)
    if 2 * hull.skin[:, 1].max() > min(width, depth):
        raise WorkFailedError(
            f"no kit can be made: the hull is {2 * hull.skin[:, 1].max():.1f} mm wide, the bed {width:g} x {depth:g} mm, "
            "and parts are cut across the axis only"
        )
    aft = _cut_side(hull, first, -1, height, options)
    fore = _cut_side(hull, first, 1, height, options)
    return (*aft[::-1], *fore)


def _seat_end(hull: Hull, side: int) -> float:
    """Largest distance of a seat from the core's equator, mm: a cone of 45 degrees ends at the wall."""
    away = np.arange(0.0, side * float(hull.bore[-1 if side > 0 else 0, 0]) + 2 * STEP, STEP)
    return float(away[np.argmax(hull.bore_radius(side * away) <= away)])


def _cut_side(hull: Hull, first: Joint, side: int, height: float, options: KitOptions) -> tuple[Joint, ...]:
    """Cuts on one side, from the core outward, beyond the core's seat."""
    end = float(hull.skin[-1 if side > 0 else 0, 0])
    # On the bed, a part extends from the tip of its plug to the beginning of its neighbour.
    start = first.tip if first.side == side else first.z
    if side * (end - start) <= height:
        return ()
    margin = 2 * (MM * options.lap + 3 * MM * options.sleeve)
    keep = max(_seat_end(hull, side), side * first.z) + margin
    places = sorted(side * z for z in hull.joints if keep <= side * z <= side * end - 2 * MM * options.sleeve)
    sleeves = [make_sleeve(side * z, side, options) for z in places]
    joints = [joint for joint in sleeves if _is_rooted(hull, joint, trace_mouth(hull, joint))]
    return _choose_fewest(hull, joints, side * start, side * end, height, margin, _name_side(side))


@dataclass(frozen=True)
class _Way:
    """Cuts from the core outward: how many, how many of them slim, and the highest part that they leave."""

    cuts: int
    slim: int
    highest: float
    joints: tuple[Joint, ...]

    def rank(self) -> tuple[int, int, float]:
        """Key to sort by: the best way has the least."""
        return self.cuts, self.slim, self.highest


def _choose_fewest(
    hull: Hull, joints: Sequence[Joint], start: float, end: float, height: float, margin: float, what: str
) -> tuple[Joint, ...]:
    """The fewest cuts that leave no part higher than the bed; of those the sturdiest, then the most even.

    Heights are counted outward; a part that follows a cut begins with its plug.
    """
    # Best way to a part that begins at each start: cuts so far, slim ones, highest part so far, the cuts.
    reached: list[_Way | None] = [_Way(0, 0, 0.0, ())]
    starts, cuts = [start], [0.0]
    for joint in joints:
        z, slim = abs(joint.z), plug_bore(hull, joint) < SLIM_BORE
        ways = [
            _Way(way.cuts + 1, way.slim + slim, max(way.highest, z - begin), (*way.joints, joint))
            for way, begin, cut in zip(reached, starts, cuts, strict=True)
            if way is not None and z - begin <= height and (not way.joints or z - cut >= margin)
        ]
        reached.append(min(ways, key=_Way.rank) if ways else None)
        starts.append(z - joint.lap)
        cuts.append(z)
    ends = [
        _Way(way.cuts, way.slim, max(way.highest, end - begin), way.joints)
        for way, begin in zip(reached, starts, strict=True)
        if way is not None and end - begin <= height
    ]
    if not ends:
        raise WorkFailedError(
            f"no kit can be made: the {what} side is {end - start:.1f} mm long, the bed takes {height:g} mm, and too "
            "few joints of modules have room for a sleeve to cut it into parts that fit"
        )
    return min(ends, key=_Way.rank).joints


def _name_side(side: int) -> str:
    return "fore" if side > 0 else "aft"


def _name_side_of(z: float) -> str:
    return _name_side(1 if z > 0 else -1)
