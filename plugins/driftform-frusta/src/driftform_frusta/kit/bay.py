"""The bay: seats that hold the core at the origin if the hull itself does not.

A hull that narrows on both sides of the core holds it. If one side is wide, the core could move along the axis: a
seat is added there, a cone that runs from the wall to the core, normal to the core's surface. Its slope is at most 45
degrees, so that it prints without support with the closed end of its part on the bed.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from manifold3d import CrossSection, OpType

from driftform.errors import WorkFailedError
from driftform_frusta.kit.meridian import Hull, grow, make_disc, make_polygon, take_right

SEAT = 1.2
"""mm, thickness of a seat: three lines of the usual nozzle."""

PLAY = 0.5
"""mm that the core may move along the axis without a seat."""

PLAY_OF_SEATS = 2.0
"""Least play along the axis, in clearances: a seat at 45 degrees leaves 1.4."""

_LATITUDES_DEG = (45.0, 50.0, 55.0, 60.0, 65.0, 70.0)
"""Latitudes at which a seat may touch the core; the first that has room is taken."""

_TOUCHING = 0.01
"""mm: sections nearer than this touch."""

_AREA = 1e-3
"""mm2: sections that share less than this do not meet."""


@dataclass(frozen=True, eq=False)
class Seat:
    """A seat's section, and the index of the part that carries it."""

    section: CrossSection
    part: int


def is_held(parts: Sequence[CrossSection], core: float, side: int, gap: float) -> bool:
    """Return whether a core of radius ``core`` touches a part as soon as it moves along the axis to one side."""
    moved = make_disc(core).translate((0.0, side * max(PLAY, PLAY_OF_SEATS * gap)))
    return any((moved ^ part).area() > _AREA for part in parts)


def place_seats(hull: Hull, parts: Sequence[CrossSection], gap: float, shells: tuple[int, int]) -> list[Seat]:
    """Return the seats that keep the core at its simulated place.

    Parameters
    ----------
    hull
        the hull.
    parts
        sections of the parts as joined.
    gap
        between seat and core, mm.
    shells
        indices of the aft and the fore shell among the parts.

    Raises
    ------
    WorkFailedError
        if a seat is needed and has no room.
    """
    found = []
    for side in (-1, 1):
        if not is_held(parts, hull.core, side, gap):
            found.append(_place_seat(hull, parts, side, gap, shells[0 if side < 0 else 1]))
    return found


def _place_seat(hull: Hull, parts: Sequence[CrossSection], side: int, gap: float, part: int) -> Seat:
    others = CrossSection.batch_boolean([p for i, p in enumerate(parts) if i != part], OpType.Add)
    for latitude in _LATITUDES_DEG:
        section = _draw_cone(hull, math.radians(latitude), side, gap)
        held = (grow(section, _TOUCHING) ^ parts[part]).area() > _AREA
        clear = (grow(section, gap) ^ others).area() < _AREA
        if held and clear:
            return Seat(section, part)
    raise WorkFailedError(
        f"no kit can be made: the core is not held on its {'fore' if side > 0 else 'aft'} side, and a seat has "
        "no room beside the joint; set joint to 'rabbet', or lap to less"
    )


def _draw_cone(hull: Hull, latitude: float, side: int, gap: float) -> CrossSection:
    """The section of a cone about the ray from the origin at a latitude, from the core to the nearest wall."""
    along = np.array([math.cos(latitude), side * math.sin(latitude)])
    across = np.array([-along[1], along[0]]) * SEAT / 2
    far = 2 * float(np.abs(hull.skin).max())
    strip = make_polygon([-across, far * along - across, far * along + across, across])
    pieces = ((take_right(strip) ^ hull.inside) - make_disc(hull.core + gap)).decompose()
    nearest = min(pieces, key=_distance)
    return nearest + nearest.mirror((1.0, 0.0))


def _distance(section: CrossSection) -> float:
    return min(float(np.linalg.norm(ring, axis=1).min()) for ring in section.to_polygons())
