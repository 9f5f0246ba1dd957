"""The hull's meridian plane, in which a kit is drawn: sections of (r, z) in mm, z from the core's centre towards fore.

A section covers both sides of the axis, so that an offset finds no edge along it; only :func:`take_half` cuts it
there.
"""

from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
from manifold3d import CrossSection, FillRule, JoinType, OpType

from driftform.agent import distance_from, solid_of_revolution
from driftform.errors import WorkFailedError
from driftform.types import Body, FloatArray, Moments
from driftform_frusta.csg import Point
from driftform_frusta.hull import list_pockets

MM = 1e3

OVERLAP = 0.05
"""mm by which added material reaches into the wall."""

FAR = 1e4
"""mm: beyond everything."""

SIMPLIFY = 1e-4
"""mm: vertices nearer than this to the line through their neighbours carry no shape, only slivers of a mesh."""

_CORNERS = 240
"""Corners of a disc."""

Ring: TypeAlias = FloatArray
"""A closed polygon of (r, z), the last point joined to the first: counterclockwise outside, clockwise a hole."""


@dataclass(frozen=True, eq=False)
class Hull:
    """A hull to be cut: the areas inside its outer contour and inside its cavity.

    ``bore`` and ``skin`` are the contours of the cavity and of the outside as z and r, (n, 2), from aft to fore; ``core`` is
    the core's radius, ``wall`` the nominal thickness of the wall, and ``joints`` has z of the joints of modules. ``capsule`` is
    the contour of a core that is not a ball. The material is without the trim ``pockets``.
    """

    outer: CrossSection
    cavity: CrossSection
    bore: FloatArray
    skin: FloatArray
    core: float
    wall: float
    joints: tuple[float, ...]
    capsule: FloatArray | None = None
    pockets: CrossSection = field(default_factory=CrossSection)

    def bore_radius(self, z: npt.ArrayLike) -> FloatArray:
        """Radius of the cavity, 0 beyond its ends."""
        radius: FloatArray = np.interp(
            np.asarray(z, dtype=np.float64), self.bore[:, 0], self.bore[:, 1], left=0.0, right=0.0
        )
        return radius

    @cached_property
    def bore_points(self) -> tuple[list[float], list[float]]:
        """The cavity's contour as lists of z and r."""
        z, r = self.bore.T.tolist()
        return z, r

    def bore_at(self, z: float) -> float:
        """Radius of the cavity at one height, at a ledge the lesser: in a fraction of the time of :meth:`bore_radius`."""
        heights, radii = self.bore_points
        above = bisect_right(heights, z)
        if above == 0 or z > heights[-1]:
            return 0.0
        low, radius = heights[above - 1], radii[above - 1]
        if z == low:
            return min(radii[bisect_left(heights, z) : above])
        return (radii[above] - radius) / (heights[above] - low) * (z - low) + radius

    @cached_property
    def widest(self) -> float:
        """Largest radius of the outer contour."""
        return float(self.skin[:, 1].max())

    def skin_radius(self, z: float) -> float:
        """Radius of the outer contour at one height, mm."""
        return float(np.interp(z, self.skin[:, 0], self.skin[:, 1]))

    def room(self, gap: float) -> float:
        """Radius that the core needs, mm: with a gap all round if the hull itself leaves one."""
        return min(self.core + gap, self.bore_at(0.0))

    @cached_property
    def reach(self) -> float:
        """Distance of the core's farther end from its middle."""
        return self.core if self.capsule is None else float(np.abs(self.capsule[:, 0]).max())

    def draw_core(self, gap: float = 0.0) -> CrossSection:
        """Return the core, with a gap all round."""
        if self.capsule is None:
            return make_disc(self.core + gap)
        return _mirror_contour(self.capsule).offset(gap, JoinType.Round, 2.0, _CORNERS)

    def draw_room(self, gap: float) -> CrossSection:
        """Return the room that the core needs, as :meth:`room`."""
        if self.capsule is None:
            return make_disc(self.room(gap))
        return self.draw_core(self.room(gap) - self.core)

    def beside_core(self, r: FloatArray, z: FloatArray) -> FloatArray:
        """Return the distance of points from the core's surface, negative inside, plus its radius: for a ball that from its centre."""
        if self.capsule is None:
            return np.asarray(np.hypot(r, z))
        points = np.column_stack((z, r))
        inside = r < np.interp(z, self.capsule[:, 0], self.capsule[:, 1], left=0.0, right=0.0)
        apart = distance_from(points, self.capsule)
        return np.asarray(self.core + np.where(inside, -apart, apart))

    @cached_property
    def material(self) -> CrossSection:
        """The hull itself."""
        return self.outer - self.cavity - self.pockets

    @cached_property
    def inside(self) -> CrossSection:
        """The room for added parts: the cavity and a little of the wall, so that they merge with it."""
        return grow(self.cavity, OVERLAP) ^ self.outer


def draw_hull(body: Body) -> Hull:
    """Return a body's hull in the meridian plane.

    Fails if it has no cavity, or one too small for the core, or if a contour folds back along the axis.
    """
    if not len(body.cavity):
        raise WorkFailedError("no kit can be made: the hull has no cavity for the core")
    contours = []
    for what, contour in (("outer contour", body.outer), ("cavity", body.cavity)):
        if (np.diff(contour[:, 0]) < 0).any():
            raise WorkFailedError(f"no kit can be made: the hull's {what} folds back along the axis")
        contours.append(MM * contour)
    room, capsule = float(distance_from(np.zeros((1, 2)), body.cavity)[0]), body.core.contour
    if (room < body.core.radius and not capsule) or not body.cavity[0, 0] < 0 < body.cavity[-1, 0]:
        raise WorkFailedError(
            f"no kit can be made: a core of {MM * body.core.radius:g} mm radius does not fit into the hull's cavity, whose "
            f"wall is {MM * room:.2f} mm from its centre",
            violations={"kit": max(0.0, body.core.radius - room)},
        )
    skin, bore = contours
    hull = Hull(
        outer=_mirror_contour(skin),
        cavity=_mirror_contour(bore),
        bore=bore,
        skin=skin,
        core=MM * body.core.radius,
        wall=MM * body.wall,
        joints=tuple((MM * body.joints).tolist()),
        capsule=MM * np.array(capsule) if capsule else None,
        pockets=unite(_mirror_contour(np.add(contour, (MM * body.outer[0, 0], 0.0))) for contour in list_pockets(body)),
    )
    if capsule and not (hull.draw_core() - hull.cavity).is_empty():
        raise WorkFailedError("no kit can be made: the core does not fit into the hull's cavity")
    return hull


def draw_tube(bore: float, wall: float, core: float, low: float, high: float) -> Hull:
    """Return a straight tube, open at both ends, as a hull; its radius and its wall, and its ends, mm."""
    contours = [
        np.array([[a, 0.0], [a, r], [b, r], [b, 0.0]])
        for a, b, r in ((low, high, bore + wall), (low - 1, high + 1, bore))
    ]
    outer, cavity = map(_mirror_contour, contours)
    return Hull(outer, cavity, contours[1], contours[0], core, wall, ())


def _mirror_contour(contour: FloatArray) -> CrossSection:
    z, r = contour.T
    return make_polygons([np.concatenate((np.column_stack((r, z)), np.column_stack((-r, z))[-2:0:-1]))])


def make_polygons(polygons: Sequence[npt.ArrayLike]) -> CrossSection:
    """Return the area inside any of some polygons of (r, z), each in either sense of rotation."""
    return CrossSection([np.asarray(points, dtype=np.float64) for points in polygons], FillRule.NonZero)


def make_slab(low: float, high: float) -> CrossSection:
    """Return the area between two heights."""
    return CrossSection.square((2 * FAR, high - low)).translate((-FAR, low))


@lru_cache(maxsize=16)
def make_disc(radius: float) -> CrossSection:
    """Return a disc about the origin; the polygon encloses the circle, so that no chord is nearer than the radius."""
    return CrossSection.circle(float(radius / np.cos(np.pi / _CORNERS)), _CORNERS)


def grow(section: CrossSection, by: float) -> CrossSection:
    """Return a section with its edges moved outward; a negative distance moves them inward."""
    return section.offset(by, JoinType.Miter, 2.0) if by else section


def unite(sections: Iterable[CrossSection]) -> CrossSection:
    """Return the area inside any of some sections."""
    return CrossSection.batch_boolean(list(sections), OpType.Add)


def subtract_near(section: CrossSection, hole: CrossSection) -> CrossSection:
    """Return a section less a hole, which may be out of its reach."""
    _, low, _, high = section.bounds()
    _, lowest, _, highest = hole.bounds()
    return section - hole if low < highest and lowest < high else section


def take_right(section: CrossSection) -> CrossSection:
    """Return the side of positive radii."""
    return section ^ _RIGHT


_RIGHT = CrossSection.square((FAR, 2 * FAR)).translate((0.0, -FAR))
"""All positive radii."""


def take_half(section: CrossSection) -> CrossSection:
    """Return the side of positive radii, simplified for a mesh."""
    return take_right(section).simplify(SIMPLIFY)


def list_rings(section: CrossSection) -> tuple[Ring, ...]:
    """Return the polygons of a section."""
    return tuple(np.asarray(ring, dtype=np.float64) for ring in section.to_polygons())


def split_rings(polygons: Sequence[Ring]) -> tuple[tuple[Point, ...], tuple[tuple[Point, ...], ...]]:
    """Return the outline of one piece, and its holes."""
    points = [tuple((float(r), float(z)) for r, z in ring) for ring in polygons]
    areas = [signed_area(ring) for ring in polygons]
    outline = areas.index(max(areas))
    return points[outline], tuple(p for i, p in enumerate(points) if i != outline)


def signed_area(ring: Ring) -> float:
    """Return the area inside a ring, mm2; negative for a hole."""
    r, z = np.concatenate((ring, ring[:1])).T
    return float(r[:-1] @ z[1:] - r[1:] @ z[:-1]) / 2


def moments(polygons: Sequence[Ring]) -> Moments:
    """Return the volume integrals of a revolved half section, in m, about the core's centre."""
    closed = [solid_of_revolution(np.concatenate((ring, ring[:1]))[:, ::-1] / MM) for ring in polygons]
    return sum(closed[1:], closed[0])
