"""The meridian section of a hull: chains and dome united, the wall offset inward."""

from collections.abc import Sequence
from dataclasses import dataclass

import manifold3d
import numpy as np

from driftform.types import FloatArray, Module

DOME_STEP = np.deg2rad(2.5)
"""The dome is an inscribed polyline of this step s; its volume is s^2 / 4 = 5e-4 below that of the sphere."""

MM = 1e3
"""Clipping works in millimetres, with a resolution of 1e-8 mm."""

SIMPLIFY = 1e-4
"""Vertices nearer than this (mm) to the line through their neighbours carry no shape, only slivers of a mesh."""

MITRE_LIMIT = 2.0
"""A mitre longer than this many walls is cut off, so that a sharp neck does not pinch the cavity."""

BOX = 1e4
"""Half the side (mm) of the box that stands for the half-plane r > 0."""


@dataclass(frozen=True, eq=False)
class Chain:
    """One side of the agent, from the core outward: distance from the core's equator, outer radius, tilts.

    ``x`` and ``r`` are (k + 1,) in m for k modules; ``tilt`` is (k,) in rad, as realised where the least radius
    cut in.
    """

    x: FloatArray
    r: FloatArray
    tilt: FloatArray


def chain(modules: Sequence[Module], start_radius: float, least_radius: float) -> Chain:
    """Lay modules end to end from the equator outward.

    Lengths run along the slant. Where the radius would fall below ``least_radius`` it stays there, and the
    module keeps its axial length.
    """
    x, r, tilts = [0.0], [start_radius], []
    for module in modules:
        run = module.length * np.cos(module.tilt)
        radius = max(least_radius, r[-1] + module.length * np.sin(module.tilt))
        tilts.append(float(np.arctan2(radius - r[-1], run)))
        x.append(x[-1] + run)
        r.append(radius)
    return Chain(np.array(x), np.array(r), np.array(tilts))


def hull_section(fore: Chain, aft: Chain, dome: float, wall: float) -> tuple[FloatArray, FloatArray]:
    """Return outer contour and cavity of a closed hull, (n, 2) and (m, 2), m.

    The cavity is the mitred inward offset of the outline by ``wall``: the wall is nowhere thinner than that,
    and flat ends become caps of the same thickness. Where a mitre would reach down into the room of the core,
    the room stays.
    """
    outline = _outline(fore, aft, dome)
    hollow = outline.offset(-wall * MM, manifold3d.JoinType.Miter, MITRE_LIMIT)
    room = _polygon(_arc(dome - wall / np.cos(DOME_STEP / 2)))
    hollow = (hollow + room).simplify(SIMPLIFY)
    return _contour(outline), _contour(hollow)


def open_section(fore: Chain, aft: Chain, dome: float, wall: float) -> tuple[FloatArray, FloatArray]:
    """Return outer contour and cavity by the paper's wall, (n, 2) and (m, 2), m.

    Each frustum's wall has the constant radial thickness wall/cos(tilt) that eq. 18 assumes, and the ends have
    none: the cavity reaches through them.
    """
    hollow = _polygon(_arc(dome - wall))
    for side, sign in ((fore, 1.0), (aft, -1.0)):
        radial = wall / np.cos(side.tilt)
        for i in range(len(side.tilt)):
            inner = np.array([[side.x[i], side.r[i] - radial[i]], [side.x[i + 1], side.r[i + 1] - radial[i]]])
            inner[:, 1] = np.maximum(inner[:, 1], 0.0)
            contour = inner * (sign, 1.0)
            hollow += _polygon(contour if sign > 0 else contour[::-1])
    return _contour(_outline(fore, aft, dome)), _contour(hollow)


def _outline(fore: Chain, aft: Chain, dome: float) -> manifold3d.CrossSection:
    """The chains and the dome united, mm."""
    after = np.column_stack([-aft.x[:0:-1], aft.r[:0:-1]])
    chains = np.vstack([after, np.column_stack([fore.x, fore.r])])
    return (_polygon(chains) + _polygon(_arc(dome))).simplify(SIMPLIFY)


def _arc(radius: float) -> FloatArray:
    angles = np.linspace(np.pi, 0, round(np.pi / DOME_STEP) + 1)
    return radius * np.column_stack([np.cos(angles), np.sin(angles)])


def _polygon(contour: FloatArray) -> manifold3d.CrossSection:
    """The contour and its mirror image below the axis, so that an offset knows no edge along the axis."""
    if len(contour) < 2 or np.ptp(contour[:, 0]) == 0:
        return manifold3d.CrossSection()
    mirrored = contour[::-1] * (1.0, -1.0)
    points = np.vstack([mirrored, contour]) * MM
    return manifold3d.CrossSection([points], manifold3d.FillRule.NonZero)


def _contour(section: manifold3d.CrossSection) -> FloatArray:
    """The upper half of a section as a contour from the aft to the fore axis point, m."""
    upper = section ^ manifold3d.CrossSection.square((2 * BOX, BOX)).translate((-BOX, 0.0))
    # A cavity of several parts would leave some without the core: the one around the core is the cavity.
    polygon = next(p for p in upper.to_polygons() if p[:, 0].min() <= 0.0 <= p[:, 0].max())
    points = np.array(polygon) / MM
    on_axis = np.flatnonzero(np.abs(points[:, 1]) < 1e-10)
    start = on_axis[np.argmin(points[on_axis, 0])]
    points = np.roll(points, -start, axis=0)
    # Polygons run counter-clockwise: from the aft axis point along the axis to the fore one. Turn them round.
    path = np.vstack([points[:1], points[:0:-1]])
    end = np.flatnonzero(np.abs(path[:, 1]) < 1e-10)[-1]
    path = path[: end + 1].copy()
    path[[0, -1], 1] = 0.0
    return path
