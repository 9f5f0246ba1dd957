"""CSG tree -> manifold3d solid.

Circles become regular polygons. A regular N-gon in a circle of radius r has the area
``N/2 sin(2 pi/N) r^2``, less than the circle's; every radius is therefore scaled by :func:`area_factor`, so
that each cross-section normal to an axis of revolution has the circle's area and a mesh has the volume, and
the mass, that the closed forms give. The price is corners that stand out of the circle, by 0.08 % of the
radius at 64 segments.
"""

import math
from collections.abc import Iterable
from typing import assert_never

import numpy as np
from manifold3d import CrossSection, Error, FillRule, Manifold, Mesh64, OpType

from driftform.errors import WorkFailedError
from driftform.types import FloatArray
from driftform_frusta.csg import (
    Box,
    Difference,
    Frustum,
    Intersection,
    Named,
    Node,
    Point,
    Revolve,
    Rotate,
    Sphere,
    Text,
    Translate,
    Union,
)
from driftform_frusta.lettering import STROKE, strokes

# mm. Clipping leaves vertices some 1e-8 mm apart, which must go. With much more than this, vertices between
# almost aligned frustums go too, and the volume of a 1.25 mm wall shifts by more than 1e-6 of itself.
_SIMPLIFY = 1e-6


def area_factor(segments: int) -> float:
    """Return the factor on a radius that gives a polygon of ``segments`` corners its circle's area."""
    return 1 / math.sqrt(segments / (2 * math.pi) * math.sin(2 * math.pi / segments))


def half_segments(segments: int) -> int:
    """Return the number of chords in the half circle that a sphere is revolved from."""
    return (segments + 1) // 2


def sphere_factor(segments: int) -> float:
    """Return the factor on a sphere's radius that gives its polygonal meridian the sphere's volume.

    A half circle of n equal chords, revolved, encloses exactly ``cos^2(pi / 2n)`` of the sphere: that is what
    the volumes ``pi h (r0^2 + r0 r1 + r1^2) / 3`` of its frustums sum to.
    """
    return math.pow(math.cos(math.pi / (2 * half_segments(segments))), -2 / 3)


def to_manifold(node: Node, segments: int = 64) -> Manifold:
    """Return the solid of a tree as a mesh, mm.

    Parameters
    ----------
    node
        the tree.
    segments
        corners of every circle; a sphere's meridian has half as many chords. Volumes of frustums, spheres and
        revolved sections are exact for any number; where such solids are cut or united off their own axis,
        the error is of second order in 1/segments.

    Raises
    ------
    WorkFailedError
        where the tree has no solid: the result is empty, inside out, or not manifold.
    """
    if segments < 3:
        raise ValueError(f"a circle needs three segments or more, not {segments}")
    solid = _interpret(node, segments)
    if solid.status() != Error.NoError:
        raise WorkFailedError(f"the solid is not manifold: {solid.status().name}")
    if not solid.volume() > 0:
        raise WorkFailedError(f"the solid is empty or inside out: its volume is {solid.volume():g} mm3")
    return solid


def _interpret(node: Node, segments: int) -> Manifold:
    def solids(nodes: Iterable[Node]) -> list[Manifold]:
        return [_interpret(n, segments) for n in nodes]

    match node:
        case Frustum():
            solid = _revolved_line(_frustum_meridian(node), segments)
        case Sphere():
            solid = _revolved_line(_sphere_meridian(node.radius, segments), segments)
        case Box():
            solid = Manifold.cube(node.size)
        case Revolve():
            solid = _revolved_section(node, segments)
        case Text():
            solid = _letters(node).extrude(node.height)
        case Union():
            solid = Manifold.batch_boolean(solids(node.children), OpType.Add)
        case Difference():
            solid = Manifold.batch_boolean(solids((node.base, *node.tools)), OpType.Subtract)
        case Intersection():
            solid = Manifold.batch_boolean(solids(node.children), OpType.Intersect)
        case Translate():
            solid = _interpret(node.child, segments).translate(node.offset)
        case Rotate():
            solid = _interpret(node.child, segments).rotate(node.angles_deg)
        case Named():
            solid = _interpret(node.child, segments)
        case _:
            assert_never(node)
    return solid


def _letters(node: Text) -> CrossSection:
    """The strokes united, each with a round end of eight corners."""
    angle = np.arange(8) * (np.pi / 4)
    pen = node.size * STROKE / 2 * np.column_stack((np.cos(angle), np.sin(angle)))
    drawn = [
        CrossSection.hull_points(np.concatenate((pen + start, pen + end)))
        for start, end in strokes(node.text, node.size)
    ]
    return CrossSection.batch_boolean(drawn, OpType.Add)


def _frustum_meridian(frustum: Frustum) -> FloatArray:
    corners = [
        (0.0, 0.0),
        (frustum.bottom_radius, 0.0),
        (frustum.top_radius, frustum.height),
        (0.0, frustum.height),
    ]
    return np.array([c for i, c in enumerate(corners) if i in (0, 3) or c[0] > 0])


def _sphere_meridian(radius: float, segments: int) -> FloatArray:
    angle = np.linspace(0, np.pi, half_segments(segments) + 1)
    meridian: FloatArray = radius * sphere_factor(segments) * np.column_stack((np.sin(angle), -np.cos(angle)))
    meridian[[0, -1], 0] = 0
    return meridian


def _revolved_line(meridian: FloatArray, segments: int) -> Manifold:
    """Revolve a line of (r, z) that leaves the axis at its first point, going up, and comes back at its last.

    The mesh is built here and not by revolving a cross-section, which would first be rounded to a grid: two
    frustums that share a radius must share their vertices to the last bit.
    """
    angle = np.arange(segments) * (2 * np.pi / segments)
    circle = area_factor(segments) * np.column_stack((np.cos(angle), np.sin(angle)))
    radius, z = meridian[1:-1].T
    rings = np.empty((len(radius), segments, 3))
    rings[:, :, :2] = radius[:, None, None] * circle
    rings[:, :, 2] = z[:, None]
    poles = np.array([[0, 0, meridian[0, 1]], [0, 0, meridian[-1, 1]]])

    index = np.arange(rings.shape[0] * segments).reshape(rings.shape[:2])
    following = np.roll(index, -1, axis=1)
    bottom, top = index.size, index.size + 1
    faces = [
        np.stack((np.full(segments, bottom), following[0], index[0]), axis=-1),
        np.stack((np.full(segments, top), index[-1], following[-1]), axis=-1),
        np.stack((index[:-1], following[:-1], following[1:]), axis=-1).reshape(-1, 3),
        np.stack((index[:-1], following[1:], index[1:]), axis=-1).reshape(-1, 3),
    ]
    vertices = np.concatenate((rings.reshape(-1, 3), poles))
    return Manifold(Mesh64(vert_properties=vertices, tri_verts=np.concatenate(faces).astype(np.uint64)))


def _revolved_section(node: Revolve, segments: int) -> Manifold:
    factor = area_factor(segments)

    def section(polygon: tuple[Point, ...]) -> CrossSection:
        # Even-odd, as OpenSCAD does, so that the sense of rotation does not matter.
        return CrossSection([np.array(polygon) * (factor, 1.0)], FillRule.EvenOdd)

    result = section(node.outline)
    for hole in node.holes:
        result -= section(hole)
    if result.is_empty():
        return Manifold()
    # Revolving a section that crosses the axis gives a solid of the wrong genus.
    (r_min, z_min, r_max, z_max) = result.bounds()
    if r_min < 0:
        result ^= CrossSection.square((r_max, z_max - z_min)).translate((0.0, z_min))
    return result.simplify(_SIMPLIFY).revolve(segments)
