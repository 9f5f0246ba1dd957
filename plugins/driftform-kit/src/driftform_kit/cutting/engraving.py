"""A text in the wall of a part, along the axis, of the same depth all over.

It is the intersection of the letters' prism, which is normal to the axis, and a layer of the wall.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from driftform.types import FloatArray
from driftform_frusta.csg import Intersection, Named, Node, Revolve, Rotate, Text, Translate, Union
from driftform_frusta.kit_options import KitOptions
from driftform_frusta.lettering import STROKE, text_length
from driftform_frusta.solid import draw_letters
from driftform_kit.cutting.joint import Joint
from driftform_kit.cutting.meridian import MM, Hull, grow, list_rings, make_slab, split_rings, take_half

MARGIN = 1.0
"""mm between the text and any other feature of the wall."""

SPREAD = 1.2
"""Largest height of letters over the radius of the wall: larger ones bend out of sight."""

_STEP = 0.5
"""mm between the places that are tried."""

_PROUD = 0.5
"""mm by which the layer projects from the wall, so that no skin is left."""

_ROWS = 60
"""Rows of points over the height of a capital, by which the material of a text is integrated: 13 across a stroke."""


@dataclass(frozen=True, eq=False)
class Engraving:
    """The solid that a text removes from a part, mm from the core's centre: it projects from the wall, to leave no skin.

    ``volume`` (m3) and ``centroid`` (body frame, m, (3,)) are those of the material within the wall.
    """

    tool: Node
    volume: float
    centroid: FloatArray


def engrave(
    hull: Hull, low: float, high: float, taken: list[tuple[float, float]], options: KitOptions
) -> Engraving | None:
    """Return the engraving of a part, ``None`` if the text has no room.

    The part has the hull's wall between the heights ``low`` and ``high``, with other features in the ranges ``taken``; mm.
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

    if outside:
        layer = grow(hull.outer, _PROUD) - grow(hull.outer, -depth)
    else:
        layer = grow(hull.cavity, depth) - grow(hull.cavity, -_PROUD)
    pieces = [split_rings(list_rings(piece)) for piece in take_half(layer ^ window).decompose()]
    tool = Intersection((placed, Union(tuple(Revolve(*rings) for rings in pieces))))
    volume, centroid = _integrate_text(hull, begin, options)
    return Engraving(Named(f"engraved: {options.engrave}", tool), volume, centroid)


def _integrate_text(hull: Hull, begin: float, options: KitOptions) -> tuple[float, FloatArray]:
    """Return the volume (m3) and the centroid (body frame, m, (3,)) of a text from ``begin`` (z, mm) on.

    Over each point of the letters the layer is sqrt(R^2 - y^2) - sqrt(R_i^2 - y^2) thick, with the radii R and R_i of
    its two sides at that height; both are cones of the same slope as the wall.
    """
    outside = options.engrave_side == "outside"
    along, across, area = _sample_letters(options.engrave, MM * options.engrave_size)
    height = begin + MM * options.engrave_size * STROKE / 2 + along
    z, r = (hull.skin if outside else hull.bore).T
    wall = np.interp(height, z, r)
    run = np.diff(z)
    edge = np.clip(np.searchsorted(z, height) - 1, 0, len(run) - 1)
    slant = np.hypot(np.diff(r)[edge], run[edge]) / np.maximum(run[edge], 1e-12)
    other = wall + (-1 if outside else 1) * MM * options.engrave_depth * slant
    wall, other = (np.sqrt(np.maximum(radius**2 - across**2, 0.0)) for radius in (wall, other))
    weight = area * np.abs(wall - other)
    volume = float(weight.sum())
    # Outside the letters are seen from -x, inside from +x; the body's axes are z, x, y of the meridian plane.
    x = (-1 if outside else 1) * (wall + other) / 2
    centroid = np.array([weight @ height, weight @ x, weight @ across]) / volume
    return volume / MM**3, centroid / MM


@lru_cache(maxsize=16)
def _sample_letters(text: str, size: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return points of a grid in the letters, along the text and across it from its middle (mm), and their areas (mm2)."""
    letters = draw_letters(text, size)
    low_x, low_y, high_x, high_y = letters.bounds()
    step = size / _ROWS
    x = np.arange(low_x + step / 2, high_x, step)
    y = np.arange(low_y + step / 2, high_y, step)
    inside = np.zeros((len(y), len(x)), dtype=bool)
    for ring in letters.to_polygons():
        for (x0, y0), (x1, y1) in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            # Even-odd: an edge turns over all that lies to the right of it in the rows that it crosses.
            rows = np.flatnonzero((y >= min(y0, y1)) & (y < max(y0, y1)))
            if len(rows):
                crossing = x0 + (y[rows] - y0) * (x1 - x0) / (y1 - y0)
                inside[rows] ^= x >= crossing[:, None]
    row, column = np.nonzero(inside)
    area = np.full(len(row), float(letters.area()) / len(row))
    return x[column], y[row] - size / 2, area


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
