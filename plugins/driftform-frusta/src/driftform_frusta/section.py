"""The meridian section of a hull: chains and dome united, the wall offset inward."""

import math
import re
from collections.abc import Sequence
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

_ABOVE = re.compile(b"\0\1+(?=\0)")
"""Points above the axis (1) in a row, and the point before them; the point after them may be that before the next."""


def lay_chains(
    fore: Sequence[Module], aft: Sequence[Module], start_radius: float, least_radius: float
) -> FloatArray:
    """Return the contour of the modules on both sides of the core, from aft to fore, (n, 2), m.

    On each side they lie end to end from the equator outward. Lengths run along the slant. If the radius would fall below
    ``least_radius`` it stays at that, and the module keeps its axial length.
    """
    ahead, radii = _lay_modules(fore, start_radius, least_radius)
    behind, radii_behind = _lay_modules(aft, start_radius, least_radius)
    return np.array([[*[-x for x in behind[:0:-1]], *ahead], [*radii_behind[:0:-1], *radii]]).T


def _lay_modules(
    modules: Sequence[Module], start_radius: float, least_radius: float
) -> tuple[list[float], list[float]]:
    """Distance of each end of a module from the core's equator, and outer radius there, from the core outward; m."""
    x, r = [0.0], [start_radius]
    for module in modules:
        x.append(x[-1] + module.length * math.cos(module.tilt))
        radius = r[-1] + module.length * math.sin(module.tilt)
        r.append(radius if radius > least_radius else least_radius)
    return x, r


def hull_section(chains: FloatArray, dome: float, wall: float) -> tuple[FloatArray, FloatArray]:
    """Return outer contour and cavity of a closed hull, (n, 2) and (m, 2), m.

    The cavity is the mitred inward offset of the outline by ``wall``: the wall is nowhere thinner than that,
    and flat ends become caps of the same thickness. If a mitre would reach into the room of the core,
    the room is kept.

    The section continues below the axis, so that the offset finds no edge along it; parts deeper than the
    longest mitre have no effect above. Nowhere may the chains be thinner than that.
    """
    depth = MITRE_LIMIT * wall
    outline = _unite_outline(chains, dome, depth)
    hollow = outline.offset(-wall * MM, manifold3d.JoinType.Miter, MITRE_LIMIT)
    room = _unite_disc(dome - wall / math.cos(DOME_STEP / 2), depth)
    return _extract_contour(outline), _extract_contour((hollow + room).simplify(SIMPLIFY))


def open_section(chains: FloatArray, dome: float, wall: float) -> tuple[FloatArray, FloatArray]:
    """Return outer contour and cavity by the paper's wall, (n, 2) and (m, 2), m.

    Each frustum's wall has the constant radial thickness wall/cos(tilt) that eq. 18 assumes, and the ends have
    no wall: the cavity reaches through them.
    """
    hollow = [_make_disc(dome - wall)]
    for (x0, r0), (x1, r1) in pairwise(chains.tolist()):
        radial = wall * math.hypot(x1 - x0, r1 - r0) / (x1 - x0)
        hollow.append(_close(np.array([(x0, max(r0 - radial, 0.0)), (x1, max(r1 - radial, 0.0))])))
    return _extract_contour(_unite_outline(chains, dome)), _extract_contour(_unite(hollow))


def _unite_outline(chains: FloatArray, dome: float, depth: float = 0.0) -> manifold3d.CrossSection:
    """The chains and the dome united, down to at least ``depth`` (m) below the axis; mm."""
    return _unite([_close(chains, depth), _make_disc(dome, depth)]).simplify(SIMPLIFY)


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
    polygon = np.concatenate((contour[:1], contour[-1:], contour[::-1]))
    polygon[:2, 1] = -depth
    return MM * polygon


def _unite(polygons: Sequence[FloatArray]) -> manifold3d.CrossSection:
    return manifold3d.CrossSection(polygons, manifold3d.FillRule.Positive)


def _extract_contour(section: manifold3d.CrossSection) -> FloatArray:
    """The part of a section above the axis and around the core as a contour from aft to fore, m."""
    for polygon in section.to_polygons():
        # Polygons run counter-clockwise, over the top from fore to aft. Twice round, each stretch is in one piece.
        points = np.concatenate((polygon, polygon))
        for stretch in _ABOVE.finditer((points[:, 1] > ON_AXIS).tobytes()):
            path = points[stretch.start() : stretch.end() + 1][::-1] / MM
            aft, fore = _meet_axis(*path[:2].tolist()), _meet_axis(*path[:-3:-1].tolist())
            # A cavity of several parts would leave some without the core: the one around the core is the cavity.
            if aft <= 0.0 <= fore:
                path[0] = aft, 0.0
                path[-1] = fore, 0.0
                return path
    raise ValueError("the section does not contain the core")


def _meet_axis(first: Sequence[float], second: Sequence[float]) -> float:
    """Where the line through two points meets the axis."""
    (x0, r0), (x1, r1) = first, second
    return x0 - r0 * (x1 - x0) / (r1 - r0)
