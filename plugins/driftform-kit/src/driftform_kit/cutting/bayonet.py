"""A bayonet: lugs in a socket that enter slots of the plug, pass a bead in a turn to the right, and stop at the end of a track.

The seal lies between the lugs and the mouth, so that nothing passes it, and lugs and tracks have flanks of 45 degrees, which
print either way up. All of it repeats three times round the axis.
"""

import math

from manifold3d import CrossSection

from driftform.types import Detail
from driftform_frusta.csg import Node, Revolve, Rotate, Translate, Union
from driftform_frusta.fittings import integrate_shared
from driftform_kit.cutting import meridian
from driftform_kit.cutting.joint import LEAD, LIP, Joint

LUG, CREST = 0.8, 1.0
"""mm: height of a lug above the bore, and length of its crest along the axis: two printed lines of the usual nozzle, and more."""

LUGS, LUG_ANGLE = 3, 30.0
"""Lugs, and degrees that one takes up."""

BEAD, BITE = 0.5, 0.15
"""mm: radius of a bead, and by how much a lug is bent when it passes the bead: the turn clicks."""


HEIGHT, LENGTH = LUG, 2 * LUG + CREST + LIP + LEAD
"""mm: how far lugs stand into the bore, and the length of plug that their tracks take up, with the land at its tip."""


def draw_lugs(joint: Joint, bore: float, section: CrossSection) -> Detail:
    """Return the lugs of a socket whose bore has a radius (mm), and whose half section is given."""
    # They reach into the wall, to merge with it.
    lugs = _repeat(_draw_flanks(joint, bore, meridian.OVERLAP, 0.0), 0.0, LUG_ANGLE, joint)
    return Detail("lugs", lugs, None, integrate_shared(lugs, _draw_ring(joint, 0.0, bore)))


def cut_tracks(joint: Joint, bore: float, section: CrossSection) -> tuple[Detail, Detail]:
    """Return the tracks and slots that a plug lacks, and the beads in the tracks."""
    bottom, track = bore - LUG - joint.gap, _draw_flanks(joint, bore, 1.0, joint.gap)
    low, high = sorted((joint.z - joint.side * (_depth(joint) - CREST / 2), joint.tip - joint.side))
    slot = track + CrossSection.square((bore + 1.0 - bottom, high - low)).translate((bottom, low))
    play = math.degrees(joint.gap / bottom)
    room = math.degrees(2 * BEAD / bottom) + play
    ends = -play, LUG_ANGLE + room - play, 2 * LUG_ANGLE + room + play
    tool = Union((_repeat(track, ends[0], ends[1] + 1.0, joint), _repeat(slot, ends[1], ends[2], joint)))
    plug = meridian.take_right(section ^ joint.draw_slab(-joint.lap, 0.0))
    lost = integrate_shared(tool, Revolve(*meridian.split_rings(meridian.list_rings(plug))))
    return Detail("tracks", None, tool, -lost), _place_beads(joint, bore, bottom, LUG_ANGLE + room / 2)


def _place_beads(joint: Joint, bore: float, bottom: float, at: float) -> Detail:
    middle, height = bottom + joint.gap + BITE - BEAD, CREST + 2 * joint.gap
    low = joint.z - joint.side * _depth(joint) - height / 2
    pin = Revolve(((0.0, low), (BEAD, low), (BEAD, low + height), (0.0, low + height)))
    pins = tuple(Rotate((0.0, 0.0, angle), Translate((middle, 0.0, 0.0), pin)) for angle in _angles(at, at, joint))
    beads = Union(pins)
    return Detail("beads", beads, None, integrate_shared(beads, _draw_ring(joint, bottom, bore)))


def _draw_ring(joint: Joint, inner: float, outer: float) -> Revolve:
    """The plug's height between two radii."""
    low, high = sorted((joint.z, joint.tip))
    return Revolve(((inner, low), (outer, low), (outer, high), (inner, high)))


def _depth(joint: Joint) -> float:
    """Distance of the lugs' middle from the cut."""
    return joint.lap - LENGTH + LUG + CREST / 2


def _draw_flanks(joint: Joint, bore: float, beyond: float, gap: float) -> CrossSection:
    """The section of a lug, which reaches ``beyond`` the bore, or that of its track with a gap all round."""
    wide = CREST / 2 + LUG + beyond
    points = [(bore - LUG, -CREST / 2), (bore - LUG, CREST / 2), (bore + beyond, wide), (bore + beyond, -wide)]
    at = joint.z - joint.side * _depth(joint)
    return meridian.grow(meridian.make_polygons([[(r, at + z) for r, z in points]]), gap)


def _angles(begin: float, end: float, joint: Joint) -> list[float]:
    # The plug turns to the right, seen from its own end.
    first = -end if joint.side > 0 else begin
    return [first + 360.0 * k / LUGS for k in range(LUGS)]


def _repeat(section: CrossSection, begin: float, end: float, joint: Joint) -> Node:
    shape = Revolve(*meridian.split_rings(meridian.list_rings(section)), end - begin)
    return Union(tuple(Rotate((0.0, 0.0, angle), shape) for angle in _angles(begin, end, joint)))
