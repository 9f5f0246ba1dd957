"""The parts of a kit, drawn in the meridian plane as they are joined, and which way up each is printed."""

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import pairwise

from manifold3d import CrossSection

from driftform.errors import WorkFailedError
from driftform.types import Body, Detail
from driftform_frusta.csg import Revolve
from driftform_frusta.fittings import add_details
from driftform_frusta.hull import check_printable_section, hull_volume, refuse_other_volume
from driftform_frusta.kit_options import KitOptions
from driftform_frusta.solid import to_manifold, to_solid
from driftform_frusta.triangles import Mesh
from driftform_kit.checks.overhangs import TURNS, list_orientations, prints_upside_down
from driftform_kit.checks.slenderness import find_brim
from driftform_kit.cutting import meridian
from driftform_kit.cutting.bay import Ball, Seat, place_seats
from driftform_kit.cutting.cut import LOCKS, choose_bed_joints, choose_core_joint
from driftform_kit.cutting.held_ballast import HeldBall, NoWayInError, hold_ballast
from driftform_kit.cutting.joint import Joint, draw_joint, trace_mouth
from driftform_kit.cutting.meridian import MM, Hull, Ring

_HEIGHTS = 1.0, 0.8, 0.65, 0.5, 0.4, 0.3
"""Heights of parts that are tried to let a ball in by one more cut, in that of the bed."""


@dataclass(frozen=True, eq=False)
class Piece:
    """One part of a kit, such as ``fore shell``; ``fore shell 2`` is the next one outward.

    ``rings`` is its half section: (r, z) in mm, z from the core's centre towards fore; what it has, or lacks, beside its
    body of revolution are its ``details``. What joints and seats would seal off is ``filled``.
    """

    name: str
    rings: tuple[Ring, ...]
    details: tuple[Detail, ...] = ()
    filled: tuple[Ring, ...] = ()

    @cached_property
    def fore_down(self) -> bool:
        """Whether it is printed with its fore end on the bed."""
        return prints_upside_down(self.upright)

    @cached_property
    def upright(self) -> Mesh:
        """Its mesh with its fore end up, of details with those alone that it cannot stand on: mm, z as in its rings."""
        protruding = [detail for detail in self.details if detail.area]
        solid = to_solid(add_details(Revolve(*meridian.split_rings(self.rings)), protruding))
        return Mesh(solid.vertices, solid.triangles, self.name)

    @cached_property
    def mesh(self) -> Mesh:
        """The same as printed: mm, z up."""
        turn = TURNS["upside down" if self.fore_down else "as placed"]
        return replace(self.upright, vertices=self.upright.vertices @ turn)

    @cached_property
    def brim(self) -> float:
        """Width of the brim that holds it on the bed, mm; 0 if it needs none."""
        return find_brim(self.mesh)

    @cached_property
    def overhang(self) -> float:
        """Area that overhangs by more than 45 degrees as printed, mm2."""
        return list_orientations(self.mesh)[0].overhang

    @property
    def bed_end(self) -> str:
        """The end that is printed on the bed."""
        return "fore" if self.fore_down else "aft"


@dataclass(frozen=True, eq=False)
class Kit:
    """A kit in the meridian plane: the hull that was cut, its pieces from aft to fore, and the joints between them.

    The core is inserted through ``core_joint``, chosen for a ``reason``. ``seats`` are those that were added to hold the
    core and the ballast.
    """

    hull: Hull
    pieces: tuple[Piece, ...]
    joints: tuple[Joint, ...]
    core_joint: Joint
    reason: str
    seats: tuple[Seat, ...]
    ballast: tuple[HeldBall, ...]

    def find_pause(self, held: HeldBall) -> float | None:
        """Return the height above the bed at which the printer pauses for a ball, mm; ``None`` if it goes in by a joint."""
        if held.mouth is not None:
            return None
        lowest = min(float((-held.side * ring[:, 1]).min()) for ring in self.pieces[held.part].rings)
        # The top of the ball is below the next layer.
        return -held.side * held.ball.z + held.ball.radius - lowest


@lru_cache(maxsize=4)
def make_kit(body: Body, options: KitOptions) -> Kit:
    """Cut a hull into the parts of a kit.

    Raises WorkFailedError if it cannot be cut; the message has the reason.
    """
    bare, sections, ballast = _place_balls(body, options)
    hull, joints, core_joint = bare.hull, bare.joints, bare.core_joint
    found = bare.seats + tuple(held.seat for held in ballast if held.seat is not None)
    names = [_name_part(index, joints.index(core_joint)) for index in range(len(sections))]
    rings, filled = zip(*map(_take_rings, sections, names), strict=True)
    locks = _make_locks(hull, core_joint, joints.index(core_joint), sections)
    details = [own + lock for own, lock in zip(_share_details(body, joints), locks, strict=True)]
    pieces = tuple(map(Piece, names, rings, details, filled))
    return replace(bare, pieces=pieces, seats=found, ballast=ballast)


def _place_balls(body: Body, options: KitOptions) -> tuple[Kit, list[CrossSection], tuple[HeldBall, ...]]:
    """Cut a hull, into lower parts than the bed takes where a ball has no way in otherwise, and hold the balls of ballast."""
    balls = [Ball(MM * x, MM * diameter / 2) for x, diameter in options.ballast]
    refused: WorkFailedError | None = None
    for share in _HEIGHTS:
        bed = (*options.bed[:2], share * options.bed[2])
        try:
            # The search asks for the kits of one hull with several balls.
            bare, drawn = _cut_hull(body, options.model_copy(update={"ballast": (), "bed": bed}))
            sections = list(drawn)
            held = hold_ballast(bare.hull, sections, bare.joints, bare.core_joint, MM * options.clearance, balls)
            return bare, sections, held
        except WorkFailedError as error:
            refused = refused or error
            if not isinstance(error, NoWayInError):
                break
    assert refused
    raise refused


@lru_cache(maxsize=4)
def _cut_hull(body: Body, options: KitOptions) -> tuple[Kit, tuple[CrossSection, ...]]:
    """Return the kit of a hull without pieces and ballast, and the sections of its parts, with the seats of the core."""
    # A hull that cannot be printed whole cannot be cut either.
    check_printable_section(body)
    hull, gap = meridian.draw_hull(body), MM * options.clearance
    refuse_other_volume(
        MM**3 * meridian.moments(meridian.list_rings(meridian.take_right(hull.material))).volume,
        hull_volume(body),
        "hull",
    )
    chosen, reason = choose_core_joint(hull, options)
    others = choose_bed_joints(hull, chosen, options)
    joints = tuple(sorted((chosen, *others), key=lambda joint: joint.z))
    sections = _draw_parts(hull, joints, gap)
    inner = joints.index(chosen)
    seats = tuple(place_seats(hull, sections, gap, (inner, inner + 1)))
    for seat in seats:
        sections[seat.part] += seat.section
    return Kit(hull, (), joints, chosen, reason, seats, ()), tuple(sections)


def _share_details(body: Body, joints: tuple[Joint, ...]) -> list[tuple[Detail, ...]]:
    """Return the details of a body that each part has, from aft to fore."""
    shares: list[tuple[Detail, ...]] = [()] * (len(joints) + 1)
    for detail in body.fittings.details:
        boxes = [to_manifold(tree).bounding_box() for tree in (detail.added, detail.removed) if tree is not None]
        aft, fore = (sum(joint.z < z for joint in joints) for z in (min(b[2] for b in boxes), max(b[5] for b in boxes)))
        if aft != fore:
            raise WorkFailedError(f"no kit can be made: its {detail.name} lies across a joint; fit it at another place")
        shares[aft] += (detail,)
    return shares


def _draw_parts(hull: Hull, joints: tuple[Joint, ...], gap: float) -> list[CrossSection]:
    bounds = [-meridian.FAR, *(joint.z for joint in joints), meridian.FAR]
    sections = [hull.material ^ meridian.make_slab(low, high) for low, high in pairwise(bounds)]
    core = hull.draw_room(gap)
    for index, joint in enumerate(joints):
        pad, pocket, plug = draw_joint(hull, joint)
        with_plug, with_socket = (index + 1, index) if joint.side > 0 else (index, index + 1)
        sections[with_plug] += meridian.subtract_near(plug, core)
        sections[with_socket] += meridian.subtract_near(pad, core)
        sections[with_socket] -= pocket
    return sections


def _make_locks(hull: Hull, joint: Joint, index: int, parts: list[CrossSection]) -> list[tuple[Detail, ...]]:
    """What each part has of the bayonet or the thread of the joint with an index, if it is one."""
    locks: list[tuple[Detail, ...]] = [()] * len(parts)
    if lock := LOCKS.get(joint.kind):
        bore = trace_mouth(hull, joint)[-1][1]
        plug, socket = (index + 1, index) if joint.side > 0 else (index, index + 1)
        locks[plug], locks[socket] = (
            lock.cut_tracks(joint, bore, parts[plug]),
            (lock.draw_lugs(joint, bore, parts[socket]),),
        )
    return locks


def _name_part(index: int, inner: int) -> str:
    side, place = ("aft", inner - index) if index <= inner else ("fore", index - inner - 1)
    return f"{side} shell {place + 1}" if place else f"{side} shell"


def _take_rings(section: CrossSection, name: str) -> tuple[tuple[Ring, ...], tuple[Ring, ...]]:
    right = meridian.take_half(section)
    if len(right.decompose()) != 1:
        raise WorkFailedError(f"no kit can be made: its {name} falls into {len(right.decompose())} pieces")
    # A pocket between a plug and a seat would be sealed: it is filled.
    rings = meridian.list_rings(right)
    return tuple(r for r in rings if meridian.signed_area(r) > 0), tuple(
        r for r in rings if meridian.signed_area(r) < 0
    )
