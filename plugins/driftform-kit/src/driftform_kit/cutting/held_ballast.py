"""The seat for a ball of ballast in a part of a kit.

A ball comes to rest on the wall, or on a seat like that of the core. It goes in by a mouth of its part, before the part is
joined there, or, if a neck is in the way, while the part is printed: the printer pauses when the ball's place is done.
Only a drop of glue keeps it from falling back: a second seat would not let it in.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from operator import itemgetter

import numpy as np
from manifold3d import CrossSection

from driftform.agent import distance_from
from driftform.errors import WorkFailedError
from driftform_frusta.csg import Revolve
from driftform_frusta.solid import to_solid
from driftform_frusta.triangles import Mesh
from driftform_kit.checks.overhangs import prints_upside_down
from driftform_kit.cutting import meridian
from driftform_kit.cutting.bay import AREA, Ball, Seat, draw_seat, draw_tube, is_held
from driftform_kit.cutting.joint import Joint, takes_core_aft
from driftform_kit.cutting.meridian import Hull

_MIN_SEAT = 0.05
"""mm2: section of the least material that is a seat."""

_ROUNDING = 0.01
"""mm: chords of a contour lie inside its curve by less than this."""


@dataclass(frozen=True, eq=False)
class HeldBall:
    """A ball of ballast, the index of its part, and what holds it: a seat, or the wall.

    ``mouth`` is the index of the joint that it goes in by, ``None`` if it is put in while its part is printed. It rests on
    its ``side``: +1 fore, -1 aft; a part around it is printed on that side.
    """

    ball: Ball
    part: int
    mouth: int | None
    side: int
    seat: Seat | None


class NoWayInError(WorkFailedError):
    """A ball that cannot get to its place; another cut may let it in."""


def hold_ballast(
    hull: Hull, parts: list[CrossSection], joints: Sequence[Joint], core_joint: Joint, gap: float, balls: Sequence[Ball]
) -> tuple[HeldBall, ...]:
    """Add the seat for a ball of ballast to the sections of parts as joined, and return how it is held; nothing without a ball.

    The parts have the seats of the core; ``gap`` is that between seat and ball, mm.

    Fails if the ball has no room, cannot get to its place, or cannot be held there.
    """
    if not balls:
        return ()
    [ball] = balls
    shell, part = joints.index(core_joint) + (not takes_core_aft(core_joint)), sum(joint.z < ball.z for joint in joints)
    kept_free = _draw_path(hull, core_joint) if part == shell else hull.draw_core(-_ROUNDING)
    if (ball.draw() ^ kept_free).area() > AREA:
        raise _refuse(ball, hull, "the core is there, or passes there")
    held = _hold(hull, parts, joints, gap, ball, part, kept_free)
    if held.seat is not None:
        parts[held.part] += held.seat.section
    return (held,)


def _draw_path(hull: Hull, joint: Joint) -> CrossSection:
    """Return where the core passes in the shell that takes it, from the joint to the origin; the other shell is put over it."""
    core, held = hull.core - _ROUNDING, hull.draw_core(-_ROUNDING)
    passage = CrossSection.square((2 * core, abs(joint.z))).translate((-core, min(0.0, joint.z)))
    return held + held.translate((0.0, joint.z)) + passage


def free_radius(hull: Hull, part: CrossSection, mouth: Joint, z: float) -> float:
    """Return the radius of the largest ball that passes a part from its mouth to a height, mm; 0 outside the cavity."""
    inward = 1 if z > mouth.z else -1
    # A plug reaches out of its part; a socket begins at the cut.
    begin = mouth.tip if mouth.side == inward else mouth.z
    low, high = sorted((begin, z))
    narrowest = hull.bore[(hull.bore[:, 0] > low) & (hull.bore[:, 0] < high), 1].min(initial=np.inf)
    if min(narrowest, *hull.bore_radius([low, high]).tolist()) <= 0:
        return 0.0
    # The nearest point of a polygon is a vertex, except where an end of the passage is nearest to an edge.
    rings, ends = [np.concatenate((r, r[:1])) for r in meridian.list_rings(part)], np.array([[0.0, low], [0.0, high]])
    corners = np.concatenate(rings)
    beyond = corners[:, 1] - np.clip(corners[:, 1], low, high)
    return min(float(np.hypot(corners[:, 0], beyond).min()), *(float(distance_from(ends, r).min()) for r in rings))


def _hold(
    hull: Hull,
    parts: Sequence[CrossSection],
    joints: Sequence[Joint],
    gap: float,
    ball: Ball,
    part: int,
    kept_free: CrossSection,
) -> HeldBall:
    own, others = parts[part], [section for index, section in enumerate(parts) if index != part]
    if any((ball.draw(gap) ^ other).area() > AREA for other in others):
        raise _refuse(ball, hull, "a joint is there")
    if hull.bore_radius(ball.z) <= 0:
        raise _refuse(ball, hull, "it is not in the cavity")
    if (ball.draw(-_ROUNDING) ^ own).area() > AREA:
        raise _refuse(ball, hull, "the bore is narrower there")
    taken = meridian.unite((*others, kept_free))

    def support(side: int) -> tuple[bool, Seat | None]:
        """Return whether the ball can rest on one side, and the seat for that, ``None`` if the wall holds it."""
        if is_held([own], ball, side, gap):
            return True, None
        found = []
        for draw in (draw_seat, draw_tube):
            seat = draw(hull, ball, parts, part, taken, side, gap)
            if seat is not None and (added := seat.section - own).area() > _MIN_SEAT:
                volume = meridian.moments(meridian.list_rings(meridian.take_right(added))).volume
                found.append((volume, seat))
        return (True, min(found, key=itemgetter(0))[1]) if found else (False, None)

    mouths = (joint for joint in (part - 1, part) if 0 <= joint < len(joints))
    for mouth in sorted(mouths, key=lambda m: abs(joints[m].z - ball.z)):
        if free_radius(hull, own, joints[mouth], ball.z) >= ball.radius - _ROUNDING:
            side = 1 if ball.z > joints[mouth].z else -1
            held, seat = support(side)
            if held:
                return HeldBall(ball, part, mouth, side, seat)
    for side in (1, -1):
        # The bore narrows nowhere between the middle and the top of the ball: it fits into the unfinished part from above.
        if hull.bore_radius(ball.z - side * np.linspace(0.0, ball.radius, 20)).min() > ball.radius:
            held, seat = support(side)
            # It is printed on the end that the ball rests on.
            whole = meridian.take_half(own if seat is None else own + seat.section)
            solid = to_solid(Revolve(*meridian.split_rings(meridian.list_rings(whole))))
            if held and prints_upside_down(Mesh(solid.vertices, solid.triangles)) == (side > 0):
                return HeldBall(ball, part, None, side, seat)
    why = "it is wider than the passage to it, or a seat has no room beside joint and core"
    raise NoWayInError(str(_refuse(ball, hull, why)))


def _refuse(ball: Ball, hull: Hull, why: str) -> WorkFailedError:
    aft = float(hull.skin[0, 0])
    return WorkFailedError(
        f"no kit can be made: ballast of {2 * ball.radius:.4g} mm at x {ball.z:+.4g} mm ({ball.z - aft:.1f} mm from the aft "
        f"end) cannot be held: {why}"
    )
