"""A text in the wall of a part, along the axis, of the same depth all over.

It is the intersection of the letters' prism, which is normal to the axis, and a layer of the wall.
"""

from dataclasses import dataclass

import numpy as np
from manifold3d import CrossSection

from driftform_frusta.csg import Intersection, Named, Node, Revolve, Rotate, Text, Translate, Union
from driftform_frusta.kit.joint import Joint
from driftform_frusta.kit.meridian import MM, Hull, grow, make_slab, split_pieces, take_half
from driftform_frusta.kit.options import KitOptions
from driftform_frusta.lettering import STROKE, text_length

MARGIN = 1.0
"""mm between the text and any other feature of the wall."""

SPREAD = 1.2
"""Largest height of letters over the radius of the wall: larger ones bend out of sight."""

_STEP = 0.5
"""mm between the places that are tried."""

_PROUD = 0.5
"""mm by which the layer projects from the wall, so that no skin is left."""


@dataclass(frozen=True, eq=False)
class Engraving:
    """The material that a text removes from a part, mm from the core's centre.

    Attributes
    ----------
    tool
        the solid to subtract; it projects from the wall, so that no skin is left.
    gone
        its part within the wall.
    """

    tool: Node
    gone: Node


def engrave(
    hull: Hull, low: float, high: float, taken: list[tuple[float, float]], options: KitOptions
) -> Engraving | None:
    """Return the engraving of a part, ``None`` if the text has no room.

    Parameters
    ----------
    hull
        the hull.
    low, high
        z between which the part has the hull's wall.
    taken
        ranges of z in which the wall has other features.
    options
        the text, its size, its depth and its side.
    """
    size, depth = MM * options.engrave_size, MM * options.engrave_depth
    place = _find_place(hull, low, high, taken, options)
    if place is None:
        return None
    begin, end = place
    outside = options.engrave_side == "outside"
    reach = float(hull.skin[:, 1].max()) + 1
    text = Translate((0.0, -size / 2, 0.0), Text(options.engrave, size, reach))
    # The text faces the reader: seen from -x outside, and from the axis towards +x inside.
    prism = Rotate((0.0, -90.0, 0.0), text)
    placed = Translate((0.0 if outside else reach, 0.0, begin + size * STROKE / 2), prism)
    window = make_slab(begin - MARGIN / 2, end + MARGIN / 2)

    def within(proud: float) -> Node:
        layer = take_half(_draw_layer(hull, depth, proud, outside) ^ window)
        return Intersection((placed, Union(tuple(Revolve(*rings) for rings in split_pieces(layer)))))

    return Engraving(Named(f"engraved: {options.engrave}", within(_PROUD)), within(0.0))


def _draw_layer(hull: Hull, depth: float, proud: float, outside: bool) -> CrossSection:
    if outside:
        return grow(hull.outer, proud) - grow(hull.outer, -depth)
    return grow(hull.cavity, depth) - grow(hull.cavity, -proud)


def _find_place(
    hull: Hull, low: float, high: float, taken: list[tuple[float, float]], options: KitOptions
) -> tuple[float, float] | None:
    """Return the range of z in which the wall is most nearly a cylinder and wide enough."""
    size, long = MM * options.engrave_size, text_length(options.engrave, MM * options.engrave_size)
    z, r = (hull.skin if options.engrave_side == "outside" else hull.bore).T
    best: tuple[float, float] | None = None
    least = np.inf
    for begin in np.arange(low + MARGIN, high - MARGIN - long, _STEP).tolist():
        end = begin + long
        if any(begin - MARGIN < b and a < end + MARGIN for a, b in taken):
            continue
        along = np.concatenate(([begin], z[(z > begin) & (z < end)], [end]))
        radius = np.interp(along, z, r)
        if radius.min() * SPREAD < size:
            continue
        # Steep pieces matter more than a slow taper: they bend letters.
        bend = float((np.abs(np.diff(radius))).max(initial=0.0) + np.ptp(radius))
        if bend < least - 1e-9:
            best, least = (begin, end), bend
    return best


def list_occupied(
    joints: tuple[Joint, ...], ends: list[tuple[float, float]], inside: bool
) -> list[tuple[float, float]]:
    """Return the ranges of z that joints and seats occupy on one side of the wall.

    Outside, the thin lip of a rabbet; inside, sockets, plugs with their roots, and seats.
    """
    found = []
    for joint in joints:
        if inside or joint.kind == "rabbet":
            reach = (2 * joint.lap, 3 * joint.plug) if inside else (joint.lap + joint.gap, 0.0)
            spans = sorted((joint.z - joint.side * reach[0], joint.z + joint.side * reach[1]))
            found.append((spans[0], spans[1]))
    return [*found, *ends] if inside else found
