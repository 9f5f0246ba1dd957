"""The meridian section of a hull: chains and dome united, the wall offset inward."""

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from driftform.types import FloatArray, Module

DOME_STEP = np.deg2rad(2.5)
"""The dome is an inscribed polyline of this step s; its volume is s^2 / 4 = 5e-4 below that of the sphere."""


def lay_chains(
    fore: Sequence[Module],
    aft: Sequence[Module],
    start_radius: float,
    min_radius: float,
    shoulders: tuple[float, float] = (0.0, 0.0),
    max_radius: float = math.inf,
) -> FloatArray:
    """Return the contour of the modules on both sides of the core, from aft to fore, (n, 2), m.

    On each side they lie end to end outward from the equator, or from ``shoulders``, x of the aft and of the fore one. Lengths
    run along the slant. If the radius would fall below ``min_radius``, or exceed ``max_radius``, it stays at that, and the
    module keeps its axial length.
    """
    ahead, radii = _lay_modules(fore, start_radius, min_radius, max_radius)
    back, radii_aft = _lay_modules(aft, start_radius, min_radius, max_radius)
    chains = np.empty((len(aft) + len(fore) + 1, 2))
    chains[:, 0] = [*[-x for x in back[:0:-1]], *ahead]
    chains[:, 1] = [*radii_aft[:0:-1], *radii]
    if shoulders[0] < shoulders[1]:
        chains = np.insert(chains, len(aft), chains[len(aft)], axis=0)
        chains[: len(aft) + 1, 0] += shoulders[0]
        chains[len(aft) + 1 :, 0] += shoulders[1]
    return chains


def _lay_modules(
    modules: Sequence[Module], start_radius: float, min_radius: float, max_radius: float
) -> tuple[list[float], list[float]]:
    """Distance of each end of a module from the core's equator, and outer radius there, from the core outward; m."""
    x, r = [0.0], [start_radius]
    for module in modules:
        x.append(x[-1] + module.length * math.cos(module.tilt))
        radius = r[-1] + module.length * math.sin(module.tilt)
        r.append(min(radius if radius > min_radius else min_radius, max_radius))
    return x, r


def hull_section(chains: FloatArray, dome: float | FloatArray, wall: float) -> tuple[FloatArray, FloatArray]:
    """Return outer contour and cavity of a closed hull, (n, 2) and (m, 2), m; ``dome`` is a radius, or a contour.

    The cavity is the mitred inward offset of the outline by ``wall``: the wall is nowhere thinner than that,
    and flat ends become caps of the same thickness. If a mitre would reach into the room of the core,
    the room is kept.
    """
    # Imported here: compiled code loads the compiler, and listing the plugins must not.
    from driftform_frusta.envelope import offset_inward, unite_contours

    over, room = _place_dome(dome, wall, wall / math.cos(DOME_STEP / 2))
    outer = unite_contours(chains, over)
    return _require_core(outer), _require_core(unite_contours(offset_inward(outer, wall), room))


def open_section(chains: FloatArray, dome: float | FloatArray, wall: float) -> tuple[FloatArray, FloatArray]:
    """Return outer contour and cavity by the paper's wall, (n, 2) and (m, 2), m.

    Each frustum's wall has the constant radial thickness wall/cos(tilt) that eq. 18 assumes, and the ends have
    no wall: the cavity reaches through them.
    """
    from driftform_frusta.envelope import unite_contours

    steps = np.diff(chains, axis=0)
    radial = wall * np.hypot(*steps.T) / steps[:, 0]
    # Where two frustums meet, their walls differ: both points are on one contour.
    bore = np.repeat(chains, 2, axis=0)[1:-1]
    bore[:, 1] = np.maximum(bore[:, 1] - np.repeat(radial, 2), 0.0)
    over, room = _place_dome(dome, wall, wall)
    return _require_core(unite_contours(chains, over)), _require_core(unite_contours(bore, room))


def draw_room(dome: float | FloatArray, wall: float) -> FloatArray:
    """Return the contour of the room of the core in a dome, as :func:`hull_section` keeps it."""
    return _place_dome(dome, wall, wall / math.cos(DOME_STEP / 2))[1]


def _place_dome(dome: float | FloatArray, wall: float, thick: float) -> tuple[FloatArray, FloatArray]:
    """Return the contours of a dome and of the room in it; ``thick`` is the wall of that of a radius."""
    from driftform_frusta.envelope import offset_inward

    if isinstance(dome, float):
        return _make_dome(dome), _make_dome(dome - thick)
    return dome, offset_inward(dome, wall)


def draw_capsule(diameter: float, length: float) -> FloatArray:
    """Return the contour of a capsule about the origin, or of a sphere that is as long as wide, from aft to fore, (n, 2), m."""
    dome, reach = _make_dome(diameter / 2), (length - diameter) / 2
    middle = len(dome) // 2
    shift = np.array([reach, 0.0])
    return np.vstack([dome[: middle + 1] - shift, dome[middle + (reach <= 0) :] + shift])


@lru_cache(maxsize=16)
def _make_dome(radius: float) -> FloatArray:
    """Return the contour of a sphere around the core, from aft to fore, (n, 2), m; of no radius, a point."""
    angles = DOME_STEP * np.arange(round(np.pi / DOME_STEP), -1, -1)
    dome = max(radius, 0.0) * np.column_stack([np.cos(angles), np.sin(angles)])
    dome[[0, -1], 1] = 0.0
    return dome


def _require_core(contour: FloatArray) -> FloatArray:
    if len(contour) == 0:
        raise ValueError("the section does not contain the core")
    return contour
