"""A bayonet: lugs in a socket that enter slots of the plug, pass a bead in a turn to the right, and stop at the end of a track.

The seal lies between the lugs and the mouth, so that nothing passes it, and lugs and tracks have flanks of 45 degrees, which
print either way up. All of it repeats three times round the axis: what it weighs is a body of revolution's share.
"""

import math
from dataclasses import astuple

from manifold3d import CrossSection

from driftform.types import Detail, Moments
from driftform_frusta.csg import Node, Revolve, Rotate, Translate, Union
from driftform_kit.cutting import meridian
from driftform_kit.cutting.joint import LEAD, LIP, Joint

LUG, CREST = 0.8, 1.0
"""mm: height of a lug above the bore, and length of its crest along the axis: two printed lines of the usual nozzle, and more."""

LUGS, LUG_ANGLE = 3, 30.0
"""Lugs, and degrees that one takes up."""

BEAD, BITE = 0.5, 0.15
"""mm: radius of a bead, and by how much a lug is bent when it passes the bead: the turn clicks."""


def track_length() -> float:
    """Length of plug that the tracks take up, with the land towards the tip, mm."""
    return 2 * LUG + CREST + LIP + LEAD


def draw_lugs(joint: Joint, bore: float, section: CrossSection) -> Detail:
    """Return the lugs of a socket whose bore has a radius (mm), and whose half section is given."""
    # They reach into the wall, to merge with it.
    lug = _draw_flanks(joint, bore, meridian.OVERLAP, 0.0)
    gained = _share(lug - meridian.take_right(section), LUGS * LUG_ANGLE)
    return Detail("lugs", _repeat(lug, 0.0, LUG_ANGLE, joint), None, gained.matrix())


def cut_tracks(joint: Joint, bore: float, section: CrossSection) -> tuple[Detail, Detail]:
    """Return the tracks and slots that a plug lacks, and the beads in the tracks."""
    plug, bottom = meridian.take_right(section), bore - LUG - joint.gap
    track = _draw_flanks(joint, bore, 1.0, joint.gap)
    low, high = sorted((joint.z - joint.side * (_depth(joint) - CREST / 2), joint.tip - joint.side))
    slot = track + CrossSection.square((bore + 1.0 - bottom, high - low)).translate((bottom, low))
    play = math.degrees(joint.gap / bottom)
    room = math.degrees(2 * BEAD / bottom) + play
    ends = -play, LUG_ANGLE + room - play, 2 * LUG_ANGLE + room + play
    tool = Union((_repeat(track, ends[0], ends[1] + 1.0, joint), _repeat(slot, ends[1], ends[2], joint)))
    lost = _share(track ^ plug, LUGS * (ends[1] - ends[0])) + _share(slot ^ plug, LUGS * (ends[2] - ends[1]))
    return Detail("tracks", None, tool, -lost.matrix()), _place_beads(joint, bottom, LUG_ANGLE + room / 2)


def _place_beads(joint: Joint, bottom: float, at: float) -> Detail:
    top = bottom + joint.gap + BITE
    middle, height = top - BEAD, CREST + 2 * joint.gap
    low = joint.z - joint.side * _depth(joint) - height / 2
    pin = Revolve(((0.0, low), (BEAD, low), (BEAD, low + height), (0.0, low + height)))
    beads = [Rotate((0.0, 0.0, angle), Translate((middle, 0.0, 0.0), pin)) for angle in _angles(at, at, joint)]
    # The part of a bead's circle outside that of the bottom.
    half = math.acos((BEAD**2 + middle**2 - bottom**2) / (2 * BEAD * middle))
    other = math.acos((bottom**2 + middle**2 - BEAD**2) / (2 * bottom * middle))
    shared = half * BEAD**2 + other * bottom**2 - middle * BEAD * math.sin(half)
    volume = LUGS * (math.pi * BEAD**2 - shared) * height / meridian.MM**3
    x, r = (low + height / 2) / meridian.MM, bottom / meridian.MM
    gained = Moments(volume, volume * x, volume * x * x, volume * r * r)
    return Detail("beads", Union(tuple(beads)), None, gained.matrix())


def _depth(joint: Joint) -> float:
    """Distance of the lugs' middle from the cut."""
    return joint.lap - track_length() + LUG + CREST / 2


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


def _share(section: CrossSection, degrees: float) -> Moments:
    """Volume integrals of what a half section sweeps in some degrees, repeated evenly round the axis."""
    whole = meridian.moments(meridian.list_rings(section))
    return Moments(*(degrees / 360 * value for value in astuple(whole)))
