"""A joint of two parts: a ring of one, the plug, slides along the axis into the other, the socket.

They meet in a surface that follows the cavity as long as that narrows from the mouth inward, and is a cylinder if it
would widen: such a surface admits the plug, centres it, and leaves the same gap all along. If the cavity is
wider, the socket is filled up to that surface. Outside, both rims bear on each other, so that the hull has
the simulated shape.

Undersides are sloped by 45 degrees: printed with their closed ends on the bed, parts need no support.
"""

from bisect import bisect_left, bisect_right
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from manifold3d import CrossSection

from driftform.types import FloatArray
from driftform_kit.cutting.gland import Gland, Seal
from driftform_kit.cutting.meridian import FAR, Hull, grow, make_polygons, make_slab

LEAD = 0.3
"""mm: chamfer of a sleeve's tip, which guides it into the socket."""

LIP = 0.82
"""mm: two printed lines of the usual nozzle, and what facets take: wall that is left at the mouth of a socket with a seal, below
its groove, and between its features."""

_SLOPE = 3**0.5
"""Length over depth of the chamfer that squeezes an O-ring as it goes in: 30 degrees."""

Line: TypeAlias = list[tuple[float, float]]
"""The radius of a surface along a socket: (s, r), s from the cut towards the part with the plug."""


@dataclass(frozen=True)
class Joint:
    """The place and the kind of a joint of two parts, whose outer surface is cut at ``z``; lengths in mm.

    The plug is on the part at its ``side``: +1 fore of the cut, -1 aft. It is ``lap`` long and ``plug`` thick, with a ``gap``
    to the socket all round. As a sleeve, a bayonet or a thread it lies inside the cavity; in a rabbet both share the thickness of the wall. With
    a gland for an O-ring, whose groove is in the plug, the meeting surface is a cylinder behind a chamfer.
    """

    z: float
    side: int
    kind: Literal["sleeve", "rabbet", "bayonet", "thread"]
    lap: float
    plug: float
    gap: float
    gland: Gland | None = None

    @property
    def tip(self) -> float:
        """z of the plug's end."""
        return self.z - self.side * self.lap

    @property
    def recess(self) -> float:
        """Depth of the socket in the wall, mm."""
        return self.plug + self.gap if self.kind == "rabbet" else 0.0

    def draw_slab(self, low: float, high: float) -> CrossSection:
        """Return the slab between two values of s."""
        ends = sorted((self.z + self.side * low, self.z + self.side * high))
        return make_slab(ends[0], ends[1])


def takes_core_aft(joint: Joint) -> bool:
    """Return whether the core is laid into the aft shell: the one with more of it, at the equator that with the socket."""
    return joint.z > 0 if joint.z else joint.side > 0


def trace_mouth(hull: Hull, joint: Joint) -> Line:
    """Return the radius of the cavity along the socket, decreasing from the cut inward.

    It begins at the cut, s = 0, and ends a gap beyond the tip.
    """
    end = joint.lap + joint.gap
    depths = [0.0, *_list_depths(hull, joint, end), end]
    radii = [hull.bore_at(joint.z - joint.side * depth) for depth in depths]
    if joint.gland:
        bore = seal_bore(joint.gland, min(*radii, radii[0] + hull.wall - joint.gland.proud - LIP))
        return [(0.0, bore + joint.gland.proud), (-_SLOPE * joint.gland.proud, bore), (-end, bore)]
    least = radii[0]
    line = [(0.0, least)]
    for s, before, r, r_before in zip(depths[1:], depths, radii[1:], radii, strict=False):
        if r < least:
            if r_before > least:
                share = (r_before - least) / (r_before - r)
                line.append((-(before + share * (s - before)), least))
            least = r
            line.append((-s, least))
    if line[-1][0] > -end:
        line.append((-end, least))
    return line


def seal_bore(gland: Gland, widest: float) -> float:
    """Return the largest radius of a bore, up to the ``widest``, in which a ring that is sold fits its groove, mm."""
    return gland.fit_groove(2 * (widest - gland.depth)) / 2 + gland.depth


def seal_start(gland: Gland) -> float:
    """Return the distance of the groove of a seal from the cut: the chamfer of its socket, and a lip; mm."""
    return _SLOPE * gland.proud + LIP


def seal_length(gland: Gland) -> float:
    """Return the length of plug that a seal takes up, with the chamfer of its socket, mm."""
    return seal_start(gland) + gland.bottom + gland.depth + LIP


def _list_depths(hull: Hull, joint: Joint, end: float) -> list[float]:
    """Distances from the cut, less than ``end``, of the vertices of the cavity along the socket."""
    heights = hull.bore_points[0]
    low, high = sorted((joint.z, joint.z - joint.side * end))
    # One vertex more on either side: a height and a distance may round to different sides of the end.
    near = heights[max(bisect_left(heights, low) - 1, 0) : bisect_right(heights, high) + 1]
    return sorted(depth for z in near if 0 < (depth := joint.side * (joint.z - z)) < end)


def radii_along(line: Line, depths: FloatArray) -> FloatArray:
    """Return the radii of a meeting surface at some distances from the cut."""
    radii: FloatArray = np.interp(depths, [-s for s, _ in line], [r for _, r in line])
    return radii


def plug_bore(hull: Hull, joint: Joint) -> float:
    """Radius inside the plug at the cut."""
    mouth = trace_mouth(hull, joint)[-1][1] if joint.gland else hull.bore_at(joint.z)
    return mouth + joint.recess - joint.gap - joint.plug


def find_seal(hull: Hull, joint: Joint) -> Seal | None:
    """Return the seal of a joint, ``None`` for one that is glued."""
    return None if joint.gland is None else joint.gland.fit_ring(trace_mouth(hull, joint)[-1][1], joint.gap, joint.plug)


def draw_joint(hull: Hull, joint: Joint) -> tuple[CrossSection, CrossSection, CrossSection]:
    """Return the pad that is added to the socket's part, the pocket removed from it, and the plug added to the other part."""
    line = trace_mouth(hull, joint)
    end, least = line[-1]
    inner = [(0.0, FAR), (line[0][1], FAR), *((r, s) for s, r in line)]
    wide = hull.widest + 1
    # From the end of the socket the fill runs out at 45 degrees.
    inner += [(wide, end - (wide - least)), (wide, -FAR), (0.0, -FAR)]
    clear = _draw_symmetric(joint, inner)
    socket_side = joint.draw_slab(-FAR, 0.0)
    pad = (hull.inside ^ socket_side) - clear
    widened = grow(clear, joint.recess)
    pocket = widened ^ joint.draw_slab(end, 0.0)
    passage = (
        pocket + (hull.cavity ^ clear ^ socket_side) + (widened ^ joint.draw_slab(0.0, 4 * (joint.lap + joint.plug)))
    )
    outside = grow(passage, -joint.gap)
    inside = grow(widened, -joint.gap - joint.plug)
    ring = (outside - inside) ^ joint.draw_slab(-joint.lap, joint.plug)
    # The root of the plug, from the wall inward; its far side slopes by 45 degrees.
    r, height = plug_bore(hull, joint), joint.plug
    root = _draw_symmetric(joint, [(r, 0.0), (r, height), (wide, height + wide - r), (wide, 0.0)])
    plug = (ring - _draw_relief(joint, line)) + (root ^ hull.inside)
    return pad, pocket, plug ^ hull.outer


def _draw_symmetric(joint: Joint, points: list[tuple[float, float]]) -> CrossSection:
    return make_polygons([[(sign * r, joint.z + joint.side * s) for r, s in points] for sign in (1, -1)])


def _draw_relief(joint: Joint, line: Line) -> CrossSection:
    """The material removed from the plug: the chamfer at the tip, the groove of an O-ring."""
    if joint.kind == "rabbet":
        return CrossSection()
    surface = float(radii_along(line, np.array(joint.lap))) - joint.gap
    low, beyond = surface - LEAD, 5.0
    outer = surface + beyond
    chamfer = [(low - 1, -joint.lap - 1), (outer, -joint.lap + LEAD + beyond), (outer, -joint.lap - 1)]
    cut = _draw_symmetric(joint, chamfer)
    if joint.gland:
        bottom = surface + joint.gap - joint.gland.depth
        near = -seal_start(joint.gland)
        far = near - joint.gland.bottom
        # The last side overhangs when the tip is up.
        ring = [(surface + 1, near), (bottom, near), (bottom, far), (surface + 1, far - (surface + 1 - bottom))]
        cut += _draw_symmetric(joint, ring)
    return cut
