"""CSG tree -> solid: what is revolved is swept by :mod:`driftform_frusta.revolution`, and manifold3d does the rest."""

from collections.abc import Iterable
from typing import assert_never

import numpy as np
from manifold3d import CrossSection, Error, FillRule, Manifold, OpType

from driftform.errors import WorkFailedError
from driftform.types import FloatArray
from driftform_frusta import csg
from driftform_frusta.boundary import Solid
from driftform_frusta.csg import Node
from driftform_frusta.lettering import STROKE, draw_strokes
from driftform_frusta.revolution import revolve_profiles

# mm. Clipping leaves vertices some 1e-8 mm apart, which must go. With much more than this, vertices between
# almost aligned frustums go too, and the volume of a 1.25 mm wall shifts by more than 1e-6 of itself.
_SIMPLIFY = 1e-6


def to_solid(node: Node, segments: int = 64) -> Solid:
    """Return the solid of a tree as a mesh.

    Args:
        node: the tree.
        segments: corners of every circle. Volumes of revolved sections are exact for any number; where such solids
            are cut or united off their own axis, the error is of second order in 1/segments.

    Raises WorkFailedError if the tree has no solid: the result is empty, inside out, or not manifold.
    """
    _refuse_too_few(segments)
    match node:
        case csg.Named():
            return to_solid(node.child, segments)
        case csg.Translate():
            return to_solid(node.child, segments).translate(node.offset)
        case csg.Revolve():
            return revolve_profiles(half_section(node), segments)
        case _:
            return Solid.from_manifold(to_manifold(node, segments))


def to_manifold(node: Node, segments: int = 64) -> Manifold:
    """Return the same for manifold3d, which unites, cuts and measures solids; slower where all is revolved, mm."""
    _refuse_too_few(segments)
    solid = _interpret(node, segments)
    if solid.status() != Error.NoError:
        raise WorkFailedError(f"the solid is not manifold: {solid.status().name}")
    if not solid.volume() > 0:
        raise WorkFailedError(f"the solid is empty or inside out: its volume is {solid.volume():g} mm3")
    return solid


def _refuse_too_few(segments: int) -> None:
    if segments < 3:
        raise ValueError(f"a circle needs three segments or more, not {segments}")


def _interpret(node: Node, segments: int) -> Manifold:
    def solids(nodes: Iterable[Node]) -> list[Manifold]:
        return [_interpret(n, segments) for n in nodes]

    match node:
        case csg.Revolve():
            solid = revolve_profiles(half_section(node), segments).to_manifold()
        case csg.Text():
            solid = draw_letters(node.text, node.size).extrude(node.height)
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
        case csg.Named():
            solid = _interpret(node.child, segments)
        case _:
            assert_never(node)
    return solid


def draw_letters(text: str, size: float) -> CrossSection:
    """Return the strokes of a text united, each with a round end of eight corners, mm."""
    angle = np.arange(8) * (np.pi / 4)
    pen = size * STROKE / 2 * np.column_stack((np.cos(angle), np.sin(angle)))
    drawn = [
        CrossSection.hull_points(np.concatenate((pen + start, pen + end))) for start, end in draw_strokes(text, size)
    ]
    return CrossSection.batch_boolean(drawn, OpType.Add)


def half_section(node: csg.Revolve) -> list[FloatArray]:
    """Return the section less its holes at r >= 0, as polygons of (r, z) in mm that do not cross.

    Polygons around matter run counterclockwise, those around holes clockwise.
    """

    def section(polygon: tuple[csg.Point, ...]) -> CrossSection:
        # Even-odd, as OpenSCAD does, so that the sense of rotation does not matter.
        return CrossSection([np.array(polygon)], FillRule.EvenOdd)

    result = section(node.outline)
    for hole in node.holes:
        result -= section(hole)
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
