"""What a kit adds to the volume of its hull, without drawing it, and where the seats of its core are.

A kit is cut in the plane by boolean operations, which is what is printed; a search weighs thousands of kits, and prints none. Here
joints and seats are integrated between the same lines, by thin slices: the mass of a kit is that of the cut one
within 2e-6 of it, and its moments alike.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from driftform.errors import WorkFailedError
from driftform.types import Body, FloatArray, Moments
from driftform_frusta.kit_options import GROOVE_WIDTH, KitOptions
from driftform_kit.cutting import kernels, meridian
from driftform_kit.cutting.bay import LATITUDES_DEG, PLAY, PLAY_OF_SEATS, SEAT
from driftform_kit.cutting.cut import CoreJoint, choose_bed_joints, choose_core_joint
from driftform_kit.cutting.joint import LEAD, Joint, plug_bore, plug_radius, trace_mouth
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
    hull = meridian.draw_hull(body)
    chosen = choose_core_joint(hull, options)
    others = choose_bed_joints(hull, chosen.joint, options)
    added, gap = np.zeros(4), MM * options.clearance
    cuts = {joint: _measure_joint(hull, joint, gap) for joint in (chosen.joint, *others)}
    for cut in cuts.values():
        kernels.add_joint(cut, added)
    seats = _place_seats(hull, cuts[chosen.joint], gap, added)
    moments = Moments(*(added / MM ** np.array([3, 4, 5, 5])).tolist())
    return Plan(hull, tuple(sorted(cuts, key=lambda joint: joint.z)), chosen, seats, moments)


def _measure_joint(hull: Hull, joint: Joint, gap: float) -> kernels.Cut:
    """Return a joint as the kernels read it."""
    mouth = trace_mouth(hull, joint)
    (end, least), root, far = mouth[-1], plug_bore(hull, joint), meridian.FAR
    # Before the socket the fill runs out at 45 degrees, and behind the cut the surface is a cylinder.
    line = np.array([(end - far, least + far), *mouth[::-1], (far, mouth[0][1])])
    bottom = kernels.move_line(line, -joint.recess)
    return kernels.Cut(
        z=float(joint.z),
        side=float(joint.side),
        lap=joint.lap,
        plug=joint.plug,
        gap=joint.gap,
        recess=float(joint.recess),
        groove=float(joint.groove),
        width=GROOVE_WIDTH * joint.cord,
        lead=LEAD,
        root=root,
        tip=plug_radius(joint, mouth),
        core=_mean_radius(hull.room(gap)),
        furthest=max(hull.widest - least - end, joint.plug + hull.widest - root),
        bore=hull.bore,
        mouth=line,
        inner=kernels.move_line(bottom, joint.gap + joint.plug),
        outer=kernels.move_line(bottom, joint.gap),
        bottom=bottom,
    )


def _place_seats(
    hull: Hull, cut: kernels.Cut, gap: float, added: FloatArray
) -> tuple[float | None, float | None]:
    """Return the latitudes of the seats, and add their integrals.

    Fails if a seat is needed and has no room.
    """
    play = max(PLAY, PLAY_OF_SEATS * gap)
    # A wall that touches at a lower latitude does not let the core aside even if it is lifted by this much.
    lift = play / math.tan(math.radians(LATITUDES_DEG[-1]))
    held = kernels.holds_core(cut, _mean_radius(hull.core), play, lift)
    strip, found = (_mean_radius(hull.core + gap), SEAT / 2, OVERLAP), list[float | None]()
    for side, is_held in zip((-1.0, 1.0), held, strict=True):
        latitudes = map(math.radians, LATITUDES_DEG)
        fitting = (each for each in latitudes if kernels.place_seat(cut, *strip, side, each, added))
        found.append(None if is_held else next(fitting, None))
        if not is_held and found[-1] is None:
            raise WorkFailedError(
                f"no kit can be made: the core is not held on its {'fore' if side > 0 else 'aft'} side, and a seat has "
                "no room beside the joint; set joint to 'rabbet', or lap to less"
            )
    return found[0], found[1]


def _mean_radius(radius: float) -> float:
    """Return the root of the mean square of the radius of a disc, whose polygon is drawn around it."""
    return radius * math.sqrt(1 + (math.pi / 240) ** 2 / 3)
