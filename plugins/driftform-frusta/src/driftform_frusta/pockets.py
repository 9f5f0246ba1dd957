"""Trim pockets: where a hull has them, and the cavity that leaves room for them.

A pocket is a bore on the axis through a flat end, in material that fills the hull around it. Half full of putty as designed, a
sealed print is trimmed either way. Its mouth is left out of the flow: a hole of a ninth of the width in a face that water
hardly passes.
"""

import numpy as np

from driftform.interfaces import Table, option
from driftform.types import Body, FloatArray, Pocket
from driftform_frusta.cores import WEIGHED

FILLED = 0.5
"""Share of a pocket that is full as designed."""

SLENDER = 2.0
"""Least depth of a pocket, over its diameter: what is shorter holds too little to be worth its mouth."""

BESIDE_CORE = 0.01
"""m between the core and the material around a pocket: room for the joint of a kit."""


class PocketOptions(Table):
    """Holes on the axis at both ends, in which putty trims a sealed print."""

    diameter: float = option(
        0.0, "diameter of a pocket in each flat end with room, half full of tungsten putty; 0: none", "m", ge=0, le=0.1
    )
    depth: float = option(0.025, "greatest depth of a trim pocket", "m", ge=0.001, le=1)


def place_pockets(body: Body, options: PocketOptions) -> tuple[Pocket, ...]:
    """Return the trim pockets of a body, aft before fore: none at an end that is not flat, or too narrow or too short."""
    found, radius = [], options.diameter / 2
    for way, core in ((1.0, body.core.ends[0]), (-1.0, body.core.ends[1])):
        (end, _), (rim, _) = body.outer[:: int(way)][:2].tolist()
        length = min(options.depth, way * (core - end) - BESIDE_CORE - body.wall)
        x = np.linspace(0.0, max(length, 0.0), 51)
        wide = np.interp(way * end + x, *(body.outer[:: int(way)] * (way, 1.0)).T) >= radius + body.wall
        # At the flat end itself the contour comes from the axis.
        depth = float(x[:-1][~wide[1:]].min(initial=length))
        if abs(rim - end) < 1e-9 and radius and depth >= SLENDER * options.diameter:
            found.append(Pocket(end, end + way * depth, radius, FILLED, WEIGHED["tungsten-putty"]))
    return tuple(found)


def clear_cavity(cavity: FloatArray, pockets: tuple[Pocket, ...], wall: float) -> FloatArray:
    """Return a cavity that begins a wall beyond the tips of pockets, (n, 2), m."""
    for pocket in pockets:
        way = 1.0 if pocket.tip > pocket.mouth else -1.0
        cavity = cut_end(cavity, pocket.tip + way * wall, int(way))
    return cavity


def cut_end(cavity: FloatArray, x: float, way: int) -> FloatArray:
    """Return a cavity that begins flat at ``x`` if it would reach farther: at its aft end (``way`` 1), or its fore end (-1)."""
    if way * x <= way * cavity[::way][0, 0] + 1e-9:
        return cavity
    beyond = way * cavity[:, 0] > way * x
    return np.vstack([[x, 0.0], [x, np.interp(x, *cavity.T)], cavity[beyond][::way]])[::way]
