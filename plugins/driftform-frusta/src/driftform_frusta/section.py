"""The meridian section of a hull: chains and dome united, the wall offset inward."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import manifold3d
import numpy as np

from driftform.types import FloatArray, Module

DOME_STEP = np.deg2rad(2.5)
"""The dome is an inscribed polyline of this step s; its volume is s^2 / 4 = 5e-4 below that of the sphere."""

MM = 1e3
"""Clipping works in millimetres, with a resolution of 1e-8 mm."""

ON_AXIS = 1e-7
"""A point nearer to the axis than this (mm) is on it: an offset leaves vertices a grid step beside it."""

SIMPLIFY = 1e-4
"""Vertices nearer than this (mm) to the line through their neighbours carry no shape, only slivers of a mesh."""

MITRE_LIMIT = 2.0
"""A mitre longer than this many walls is cut off, so that a sharp neck does not pinch the cavity."""


@dataclass(frozen=True, eq=False)
class Chain:
    """One side of the agent, from the core outward: distance from the core's equator and outer radius.

    Both have k + 1 numbers in m for k modules.
    """

    x: Sequence[float]
    r: Sequence[float]


def build_chain(modules: Sequence[Module], start_radius: float, least_radius: float) -> Chain:
    """Lay modules end to end from the equator outward.

    Lengths run along the slant. If the radius would fall below ``least_radius`` it stays at that, and the
    module keeps its axial length.
    """
    x, r = [0.0], [start_radius]
    for module in modules:
        x.append(x[-1] + module.length * math.cos(module.tilt))
        r.append(max(least_radius, r[-1] + module.length * math.sin(module.tilt)))
    return Chain(x, r)


def join_chains(fore: Chain, aft: Chain) -> FloatArray:
    """Return the contour of both chains from aft to fore, (n, 2), m."""
    return np.array([[*(-x for x in aft.x[:0:-1]), *fore.x], [*aft.r[:0:-1], *fore.r]]).T


def hull_section(fore: Chain, aft: Chain, dome: float, wall: float) -> tuple[FloatArray, FloatArray]:
    """Return outer contour and cavity of a closed hull, (n, 2) and (m, 2), m.

    The cavity is the mitred inward offset of the outline by ``wall``: the wall is nowhere thinner than that,
    and flat ends become caps of the same thickness. If a mitre would reach into the room of the core,
    the room is kept.

    The section continues below the axis, so that the offset finds no edge along it; parts deeper than the
    longest mitre have no effect above. No chain may be thinner than that.
    """
    depth = MITRE_LIMIT * wall
    outline = _unite_outline(fore, aft, dome, depth)
    hollow = outline.offset(-wall * MM, manifold3d.JoinType.Miter, MITRE_LIMIT)
    room = _unite_disc(dome - wall / math.cos(DOME_STEP / 2), depth)
    return _extract_contour(outline), _extract_contour((hollow + room).simplify(SIMPLIFY))


def open_section(fore: Chain, aft: Chain, dome: float, wall: float) -> tuple[FloatArray, FloatArray]:
    """Return outer contour and cavity by the paper's wall, (n, 2) and (m, 2), m.

    Each frustum's wall has the constant radial thickness wall/cos(tilt) that eq. 18 assumes, and the ends have
    no wall: the cavity reaches through them.
    """
    hollow = [_make_disc(dome - wall)]
    for side, sign in ((fore, 1), (aft, -1)):
        for (x0, r0), (x1, r1) in pairwise(zip(side.x, side.r, strict=True)):
            radial = wall * math.hypot(x1 - x0, r1 - r0) / (x1 - x0)
            inner = np.array([(sign * x0, max(r0 - radial, 0.0)), (sign * x1, max(r1 - radial, 0.0))])
            hollow.append(_close(inner[::sign]))
    return _extract_contour(_unite_outline(fore, aft, dome)), _extract_contour(_unite(hollow))


def _unite_outline(fore: Chain, aft: Chain, dome: float, depth: float = 0.0) -> manifold3d.CrossSection:
    """The chains and the dome united, down to at least ``depth`` (m) below the axis; mm."""
    chains = _close(join_chains(fore, aft), depth)
    return _unite([chains, _make_disc(dome, depth)]).simplify(SIMPLIFY)


@lru_cache(maxsize=16)
def _make_disc(radius: float, depth: float = 0.0) -> FloatArray:
    """A disc as a polygon, cut off at ``depth`` (m) below the axis or a little deeper; mm."""
    below = math.ceil(math.asin(depth / max(radius, depth)) / DOME_STEP)
    angles = DOME_STEP * np.arange(-below, round(np.pi / DOME_STEP) + below + 1)
    return MM * radius * np.column_stack([np.cos(angles), np.sin(angles)])


@lru_cache(maxsize=16)
def _unite_disc(radius: float, depth: float) -> manifold3d.CrossSection:
    """The same disc as a section."""
    return _unite([_make_disc(radius, depth)])


def _close(contour: FloatArray, depth: float = 0.0) -> FloatArray:
    """What lies between a contour and the line ``depth`` (m) below the axis, as a polygon; mm."""
    below = ((contour[0, 0], -depth), (contour[-1, 0], -depth))
    return MM * np.concatenate([below, contour[::-1]])


def _unite(polygons: Sequence[FloatArray]) -> manifold3d.CrossSection:
    return manifold3d.CrossSection(polygons, manifold3d.FillRule.Positive)


def _extract_contour(section: manifold3d.CrossSection) -> FloatArray:
    """The part of a section above the axis and around the core as a contour from aft to fore, m."""
    for polygon in section.to_polygons():
        # Polygons run counter-clockwise. Turned round, and begun below, they go over the top from aft to fore.
        lowest = polygon[:, 1].argmin()
        points = np.concatenate([polygon[lowest::-1], polygon[:lowest:-1], polygon[lowest : lowest + 1]])
        above = points[:, 1] > ON_AXIS
        for rise, fall in np.flatnonzero(above[1:] != above[:-1]).reshape(-1, 2):
            path = points[rise : fall + 2] / MM
            path[0] = _meet_axis(*path[0].tolist(), *path[1].tolist())
            path[-1] = _meet_axis(*path[-1].tolist(), *path[-2].tolist())
            # A cavity of several parts would leave some without the core: the one around the core is the cavity.
            if path[0, 0] <= 0.0 <= path[-1, 0]:
                return path
    raise ValueError("the section does not contain the core")


def _meet_axis(x0: float, r0: float, x1: float, r1: float) -> tuple[float, float]:
    """Where the line through two points meets the axis."""
    return x0 - r0 * (x1 - x0) / (r1 - r0), 0.0
