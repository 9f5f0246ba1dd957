"""A thread: a ridge that winds to the right round the bore of a socket, in a groove of the plug, until the rims meet.

The seal lies between the thread and the mouth, so that nothing passes it, and ridge and groove have flanks of 45 degrees, which
print either way up.
"""

import math

from manifold3d import CrossSection

from driftform.types import Detail
from driftform_frusta.csg import Node, Revolve, Rotate
from driftform_frusta.fittings import integrate_shared
from driftform_kit.cutting import meridian
from driftform_kit.cutting.joint import LEAD, LIP, Joint

RIDGE, TOP = 0.6, 0.4
"""mm: height of the ridge above the bore, and its width there along the axis: two layers of 0.2 mm."""

PITCH, TURNS = 2.4, 2
"""mm that a turn closes, twelve layers, and how often the ridge winds round."""

PROUD = 0.2
"""mm by which the ridge reaches into the wall, and its groove out of the plug: more than the facets of a circle leave."""


HEIGHT, LENGTH = RIDGE, LIP + 2 * RIDGE + TOP + TURNS * PITCH + LEAD
"""mm: how far the ridge stands into the bore, and the length of plug that it takes up."""


def draw_lugs(joint: Joint, bore: float, section: CrossSection) -> Detail:
    """Return the ridge of a socket whose bore has a radius (mm), and whose half section is given."""
    inside = _wind(joint, bore, 0.0, 0.0, (0.0, TURNS))
    return Detail("ridge", _wind(joint, bore, 0.0, PROUD, (0.0, TURNS)), None, integrate_shared(inside, inside))


def cut_tracks(joint: Joint, bore: float, section: CrossSection) -> tuple[Detail, ...]:
    """Return the groove that a plug lacks, in whose end the ridge has room to turn on until its flank bears."""
    play = 2 * joint.gap / PITCH
    # It leaves by the tip, which is above the ridge, or below it.
    ends = (-play, TURNS + 1.0) if joint.side < 0 else (-1.0, TURNS + play)
    groove, plug = (
        _wind(joint, bore, joint.gap, PROUD - joint.gap, ends),
        meridian.take_right(section ^ joint.draw_slab(-joint.lap, 0.0)),
    )
    lost = integrate_shared(groove, Revolve(*meridian.split_rings(meridian.list_rings(plug))))
    return (Detail("groove", None, groove, -lost),)


def _wind(joint: Joint, bore: float, gap: float, beyond: float, ends: tuple[float, float]) -> Node:
    """The ridge with a gap all round, which reaches ``beyond`` the bore (mm), between two turns."""
    low, high, (first, last) = bore - RIDGE - gap, bore + beyond, ends
    inner, outer = (TOP / 2 + r - bore + RIDGE + math.sqrt(2) * gap for r in (low, high))
    tip = joint.tip + joint.side * (LEAD + RIDGE + TOP / 2)
    # Where it begins, at its lower end.
    z = min(tip, tip + joint.side * TURNS * PITCH) + PITCH * first
    outline = (low, z - inner), (high, z - outer), (high, z + outer), (low, z + inner)
    return Rotate((0.0, 0.0, 360 * first), Revolve(outline, (), 360 * (last - first), PITCH * (last - first)))
