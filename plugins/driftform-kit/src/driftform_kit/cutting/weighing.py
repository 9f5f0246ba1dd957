"""What a kit adds to the volume of its hull, without drawing it, and where the seats of its core are.

A kit is cut in the plane by boolean operations, which is what is printed; a search weighs thousands of kits, and prints none. Here
joints and seats are integrated between the same lines by slices of 0.05 mm: the mass of a kit is that of the cut one
within 1e-6 of it, and its moments alike.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from driftform.errors import WorkFailedError
from driftform.types import Body, FloatArray, Moments
from driftform_frusta.kit_options import GROOVE_WIDTH, KitOptions
from driftform_frusta.printable import check_printable_section
from driftform_kit.cutting import kernels, meridian
from driftform_kit.cutting.bay import LATITUDES_DEG, PLAY, PLAY_OF_SEATS, SEAT
from driftform_kit.cutting.cut import CoreJoint, choose_bed_joints, choose_core_joint
from driftform_kit.cutting.joint import LEAD, Joint, plug_bore, trace_mouth
from driftform_kit.cutting.meridian import MM, OVERLAP, Hull


@dataclass(frozen=True, eq=False)
class Plan:
    """How a hull is to be cut: its joints from aft to fore, the core's among them, and the latitudes of its seats.

    ``seats`` has the latitude (rad) at which the seat aft and the one fore touch the core, ``None`` where the hull itself holds it;
    ``added`` are the volume integrals of joints and seats.
    """

    hull: Hull
    joints: tuple[Joint, ...]
    core_joint: CoreJoint
    seats: tuple[float | None, float | None]
    added: Moments


@lru_cache(maxsize=4)
def plan_kit(body: Body, options: KitOptions) -> Plan:
    """Return how a hull is to be cut into the parts of a kit.

    Raises
    ------
    WorkFailedError
        if it cannot be cut; the message has the reason.
    """
    # A hull that cannot be printed whole cannot be cut either.
    check_printable_section(body)
    hull = meridian.draw_hull(body)
    chosen = choose_core_joint(hull, options)
    others = choose_bed_joints(hull, chosen.joint, options)
    added, gap = np.zeros(4), MM * options.clearance
    rows = {joint: _measure_joint(hull, joint, gap) for joint in (chosen.joint, *others)}
    for row, lines in rows.values():
        kernels.add_joint(row, lines, hull.bore, added)
    seats = _place_seats(hull, *rows[chosen.joint], gap, added)
    moments = Moments(*(added / MM ** np.array([3, 4, 5, 5])).tolist())
    return Plan(hull, tuple(sorted(rows, key=lambda joint: joint.z)), chosen, seats, moments)


def _measure_joint(hull: Hull, joint: Joint, gap: float) -> tuple[FloatArray, FloatArray]:
    """Return numbers and lines of a joint, as the kernels read them."""
    mouth = trace_mouth(hull, joint)
    end, least = mouth[-1]
    tip = float(np.interp(joint.lap, [-s for s, _ in mouth], [r for _, r in mouth])) - joint.gap
    bore, far = plug_bore(hull, joint), meridian.FAR
    furthest = max(hull.widest - least - end, joint.plug + hull.widest - bore)
    numbers = [joint.z, joint.side, joint.lap, joint.plug, joint.gap, joint.recess, joint.groove]
    numbers += [GROOVE_WIDTH * joint.cord, LEAD, bore, tip, _mean_radius(hull.room(gap)), furthest]
    # Before the socket the fill runs out at 45 degrees, and behind the cut the surface is a cylinder.
    line = np.array([(end - far, least + far), *mouth[::-1], (far, mouth[0][1])])
    bottom = kernels.move_line(line, -joint.recess)
    inner, outer = (kernels.move_line(bottom, by) for by in (joint.gap + joint.plug, joint.gap))
    return np.array(numbers), np.array((line, inner, outer, bottom))


def _place_seats(
    hull: Hull, row: FloatArray, lines: FloatArray, gap: float, added: FloatArray
) -> tuple[float | None, float | None]:
    """Return the latitudes of the seats, and add their integrals.

    Fails if a seat is needed and has no room.
    """
    play = max(PLAY, PLAY_OF_SEATS * gap)
    # A wall that touches at a lower latitude does not let the core aside even if it is lifted by this much.
    lift = play / math.tan(math.radians(LATITUDES_DEG[-1]))
    held = kernels.holds_core(row, lines, hull.bore, _mean_radius(hull.core), play, lift)
    found: list[float | None] = []
    for side, is_held in zip((-1.0, 1.0), held, strict=True):
        latitudes = (
            latitude
            for latitude in map(math.radians, LATITUDES_DEG)
            if kernels.place_seat(
                row,
                lines,
                hull.bore,
                _mean_radius(hull.core + gap),
                SEAT / 2,
                OVERLAP,
                side,
                latitude,
                added,
            )
        )
        found.append(None if is_held else next(latitudes, math.nan))
        if not is_held and math.isnan(found[-1] or 0.0):
            raise WorkFailedError(
                f"no kit can be made: the core is not held on its {'fore' if side > 0 else 'aft'} side, and a seat has "
                "no room beside the joint; set joint to 'rabbet', or lap to less"
            )
    return found[0], found[1]


def _mean_radius(radius: float) -> float:
    """Return the root of the mean square of the radius of a disc, whose polygon is drawn around it."""
    return radius * math.sqrt(1 + (math.pi / 240) ** 2 / 3)
