"""Solids as triangles in mm: what a CSG tree describes, and the mesh of it that files hold.

A surface of revolution takes no modelling: each point of its profile sweeps a ring of vertices, or is a pole on the
axis, and two neighbours are joined by a band of triangles. So the mesh is closed by the way it is numbered, each
vertex is where the profile has it to the last bit, and two profiles that share a point share its ring. manifold3d does
the rest.
"""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import assert_never

import numpy as np
from manifold3d import CrossSection, Error, FillRule, Manifold, OpType

from driftform.errors import WorkFailedError
from driftform.types import FloatArray
from driftform_frusta import csg
from driftform_frusta.csg import Node
from driftform_frusta.triangles import Mesh

# mm. Clipping leaves vertices some 1e-8 mm apart, which must go. With much more than this, vertices between
# almost aligned frustums go too, and the volume of a 1.25 mm wall shifts by more than 1e-6 of itself.
_SIMPLIFY = 1e-6


@dataclass(frozen=True, eq=False)
class Solid(Mesh):
    """A solid of positive volume: vertices, mm, (n, 3), and triangles, counterclockwise seen from outside, (m, 3).

    ``shells`` are the volumes inside each closed surface, mm3, (k,): negative for that of a hollow, which faces inward. Raises
    WorkFailedError if it is empty or inside out.
    """

    shells: FloatArray = field(default_factory=lambda: np.empty(0))

    def __post_init__(self) -> None:
        if not self.volume > 0:
            raise WorkFailedError(f"the solid is empty or inside out: its volume is {self.volume:g} mm3")

    @classmethod
    def from_manifold(cls, solid: Manifold) -> "Solid":
        """Return the boundary of a solid of manifold3d."""
        mesh = solid.to_mesh64()
        return cls(
            np.asarray(mesh.vert_properties)[:, :3],
            np.asarray(mesh.tri_verts, dtype=np.int64),
            shells=np.array([shell.volume() for shell in solid.decompose()]),
        )

    @cached_property
    def volume(self) -> float:
        """Volume of the material, mm3."""
        return float(self.shells.sum())

    @property
    def pieces(self) -> int:
        """Number of disconnected solids: each has an outside, and any number of hollows."""
        return int((self.shells > 0).sum())

    def turn_over(self) -> "Solid":
        """Return the solid turned by half a turn about the x axis."""
        return replace(self, vertices=self.vertices * np.array([1.0, -1.0, -1.0]))

    def to_manifold(self) -> Manifold:
        """Return the solid for manifold3d, which unites, cuts and measures solids.

        Raises WorkFailedError if its surfaces are not closed.
        """
        solid = super().to_manifold()
        if solid.status() != Error.NoError:
            raise WorkFailedError(f"the solid is not manifold: {solid.status().name}")
        return solid


def to_solid(node: Node, segments: int = 64) -> Solid:
    """Return the solid of a tree as a mesh with ``segments`` corners in every circle.

    Volumes of revolved sections are exact for any number; where such solids are cut or united off their own axis, the error is
    of second order in 1/segments.

    Raises WorkFailedError if the tree has no solid: the result is empty, inside out, or not manifold.
    """
    match node:
        case csg.Translate():
            return to_solid(node.child, segments).translate(node.offset)
        case csg.Revolve(angle_deg=360.0, rise=0.0):
            return revolve_profiles(half_section(node), segments)
        case _:
            return Solid.from_manifold(to_manifold(node, segments))


def to_manifold(node: Node, segments: int = 64) -> Manifold:
    """Return the same for manifold3d, which unites, cuts and measures solids; slower where all is revolved, mm."""
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
        case csg.Revolve():
            whole = node.angle_deg == 360 and not node.rise
            solid = to_solid(node, segments).to_manifold() if whole else _revolve_sector(node, segments)
        case csg.Extrude():
            solid = _draw_section(node).extrude(node.height)
        case csg.Union():
            solid = Manifold.batch_boolean(solids(node.children), OpType.Add)
        case csg.Difference():
            solid = Manifold.batch_boolean(solids((node.base, *node.tools)), OpType.Subtract)
        case csg.Intersection():
            solid = Manifold.batch_boolean(solids(node.children), OpType.Intersect)
        case csg.Translate():
            solid = _interpret(node.child, segments).translate(node.offset)
        case csg.Rotate():
            solid = _interpret(node.child, segments).rotate(node.angles_deg)
        case _:
            assert_never(node)
    return solid


def _revolve_sector(node: csg.Revolve, segments: int) -> Manifold:
    """A part of a turn, whose radii are scaled so that it has the area of its sector."""
    steps = max(3, round(segments * node.angle_deg / 360))
    step = math.radians(node.angle_deg) / steps
    section = CrossSection(half_section(node)).scale((math.sqrt(step / math.sin(step)), 1.0))
    if not node.rise:
        return section.revolve(steps, node.angle_deg)

    def wind(points: FloatArray) -> FloatArray:
        r, z, turned = points.T
        angle = np.radians(turned)
        return np.column_stack((r * np.cos(angle), r * np.sin(angle), node.rise / node.angle_deg * turned - z))

    return section.scale((1.0, -1.0)).extrude(node.angle_deg, steps).warp_batch(wind)


def half_section(node: csg.Revolve) -> list[FloatArray]:
    """Return the section less its holes at r >= 0, as polygons of (r, z) in mm that do not cross.

    Polygons around matter run counterclockwise, those around holes clockwise.
    """

    result = _draw_section(node)
    if result.is_empty():
        return []
    # What is revolved must not cross the axis.
    (r_min, z_min, r_max, z_max) = result.bounds()
    if r_min < 0:
        result ^= CrossSection.square((r_max, z_max - z_min)).translate((0.0, z_min))
    profiles: list[FloatArray] = result.simplify(_SIMPLIFY).to_polygons()
    for profile in profiles:
        profile[profile[:, 0] < _SIMPLIFY, 0] = 0
    return profiles


def _draw_section(node: csg.Revolve | csg.Extrude) -> CrossSection:
    # Even-odd, as OpenSCAD does, so that the sense of rotation does not matter.
    outline, *holes = (CrossSection([np.array(points)], FillRule.EvenOdd) for points in (node.outline, *node.holes))
    return CrossSection.batch_boolean([outline, *holes], OpType.Subtract)


def revolve_profiles(profiles: Iterable[FloatArray], segments: int) -> Solid:
    """Return the solid that closed profiles sweep about the z axis, with ``segments`` corners in every circle.

    Each profile is a polygon (n, 2) of (r, z) in mm with r >= 0, the last point joined to the first; counterclockwise around
    matter, clockwise around a hollow. They neither cross each other nor themselves.

    Raises WorkFailedError if the solid is empty or inside out.
    """
    vertices, triangles, shells, count = [np.empty((0, 3))], [np.empty((0, 3), dtype=np.int64)], [], 0
    for profile in profiles:
        for line, closed in split_at_axis(profile):
            mesh = Mesh.revolve(line, segments, closed)
            vertices.append(mesh.vertices)
            triangles.append(mesh.triangles + count)
            shells.append(mesh.volume)
            count += len(mesh.vertices)
    return Solid(np.concatenate(vertices), np.concatenate(triangles), shells=np.array(shells))


def split_at_axis(profile: FloatArray) -> Iterator[tuple[FloatArray, bool]]:
    """Split a profile where it is on the axis: lines from pole to pole, or itself, a ring, where it never is."""
    poles = np.flatnonzero(profile[:, 0] == 0)
    if not len(poles):
        yield profile, True
        return
    turned = np.roll(profile, -poles[0], axis=0)
    ends = np.append(poles - poles[0], len(profile))
    turned = np.append(turned, turned[:1], axis=0)
    for start, end in pairwise(ends):
        if end - start > 1:
            yield turned[start : end + 1], False


def integrate_solid(solid: Manifold) -> FloatArray:
    """Return the integral of h h^T over a solid, with h = (1, x, y, z), (4, 4), in its unit of length."""
    mesh = solid.to_mesh64()
    corners = np.asarray(mesh.vert_properties)[:, :3][np.asarray(mesh.tri_verts, dtype=np.int64)]
    # Tetrahedra between the triangles and the origin.
    points = np.zeros((len(corners), 4, 4))
    points[:, :, 0], points[:, :3, 1:] = 1.0, corners
    total = points.sum(axis=1)
    products = np.einsum("ni,nj->nij", total, total) + np.einsum("nki,nkj->nij", points, points)
    return np.asarray(np.einsum("n,nij->ij", np.linalg.det(corners) / 120, products))


def make_mesh(solid: Solid, name: str = "hull", frame: FloatArray | None = None) -> Mesh:
    """Return the mesh of a solid (mm), rounded to single precision and checked after that.

    ``frame`` is the matrix from its points to those of the mesh, (3, 3); the identity by default.

    Raises WorkFailedError if the rounded mesh is not closed, or its volume differs from the solid's by more than
    rounding explains.
    """
    points, expected = solid.vertices, solid.volume
    if frame is not None:
        points = points @ frame.T
        expected *= float(np.linalg.det(frame))
    mesh = Mesh(points.astype(np.float32), solid.triangles, name).merge_vertices()
    if not mesh.is_closed:
        raise WorkFailedError(f"the mesh of the {name} does not stay closed in single precision")
    # Rounding moves a vertex by half a unit in the last place at most, in each of three directions, and so the
    # volume by no more than the surface times that.
    spacing = float(np.spacing(np.abs(mesh.vertices).max()))
    if abs(mesh.volume - expected) > np.sqrt(3) / 2 * spacing * mesh.area:
        raise WorkFailedError(
            f"the mesh of the {name} has a volume of {mesh.volume:.6g} in single precision, its solid {expected:.6g}"
        )
    return mesh
