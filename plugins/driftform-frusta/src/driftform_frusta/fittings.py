"""Fittings: what plugins fit to a hull, in its contours or as details of solids, and what it then weighs and displaces."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np
from manifold3d import CrossSection, Manifold

from driftform.errors import WorkFailedError
from driftform.interfaces import Fitting
from driftform.types import Body, Detail, FloatArray
from driftform_frusta.csg import MM, Difference, Node, Revolve, Translate, Union
from driftform_frusta.hull import build_hull
from driftform_frusta.solid import half_section, integrate_solid, split_at_axis, to_manifold

_NOTHING = 1e-6
"""mm3, and mm: less is rounding."""

_THIN = 1e-3
"""mm3: what protrudes less is a sliver between facets."""

_VIEWS = ((0.0, 0.0, 0.0), (90.0, 0.0, 0.0), (0.0, 90.0, 0.0))

_TO_BODY = np.eye(4)[[0, 3, 1, 2]] / [1.0, MM, MM, MM]
"""From 1, x, y and z of a tree to those of the body, whose axis is x."""

Drawn: TypeAlias = tuple[str, Node | None, Node | None]
"""The name of a fitting, and what it adds and removes, mm, z from the origin of the body frame."""


def fit_hull(body: Body, fittings: Sequence[Fitting[Any]]) -> Body:
    """Return a body with fittings: those of revolution change its contours, the others become details.

    Raises WorkFailedError if one has no room, or opens the hull; the message names it.
    """
    solid: list[Drawn] = []
    for fitting in fittings:
        drawn = fitting.draw(body)
        if not (isinstance(drawn, tuple) and len(drawn) == 2 and all(isinstance(t, Node | None) for t in drawn)):
            raise WorkFailedError(
                f"the fitting '{fitting.name}' draws {drawn!r:.60}, not two trees of driftform_frusta.csg"
            )
        turned = _turn_into(body, (fitting.name, *drawn))
        solid += [(fitting.name, *drawn)] if turned is None else []
        body = turned or body
    return measure_details(body, solid)


def add_details(tree: Node, details: Iterable[Detail]) -> Node:
    """Return the tree of a hull, or of a part of it, with details; mm, z from the origin of the body frame."""
    for detail in details:
        tree = tree if detail.added is None else Union((tree, detail.added))
        tree = tree if detail.removed is None else Difference(tree, (detail.removed,))
    return tree


def draw_section(tree: Node | None) -> CrossSection | None:
    """Return the half section (r, z) of a tree that is a revolved section, mm; ``None`` for other trees."""
    match tree:
        case None:
            return CrossSection()
        case Revolve(angle_deg=360.0, rise=0.0):
            return CrossSection([ring.tolist() for ring in half_section(tree)])
        case Translate(offset=(0.0, 0.0, z)) if (section := draw_section(tree.child)) is not None:
            return section.translate((0.0, z))
    return None


def integrate_shared(tree: Node, other: Node) -> FloatArray:
    """Return the integral of h h^T over what two trees share, m, as :class:`Detail` has it; by facets, to a thousandth."""
    return _integrate(to_manifold(tree) ^ to_manifold(other))


def _integrate(solid: Manifold) -> FloatArray:
    return np.asarray((_TO_BODY @ integrate_solid(solid) @ _TO_BODY.T) / MM**3)


def _turn_into(body: Body, drawn: Drawn) -> Body | None:
    """Return a body with a fitting in its contours; ``None`` if that is not of revolution."""
    name, added, removed = drawn[0], *map(draw_section, drawn[1:])
    if added is None or removed is None:
        return None
    wall = CrossSection([ring.tolist() for ring in half_section(_revolve(body.outer, body.cavity))])
    profiles = (wall + added - removed).simplify(_NOTHING).to_polygons()
    for profile in profiles:
        profile[profile[:, 0] < _NOTHING, 0] = 0.0
    lines = [line[:, ::-1] / MM for profile in profiles for line, _ in split_at_axis(profile)]
    # Aft first, and the longer one first.
    lines = [line[:: 1 if line[0, 0] < line[-1, 0] else -1] for line in lines]
    outer, *cavity = sorted(lines, key=lambda line: float(line[0, 0] - line[-1, 0]))
    beside = [line for line in cavity if not outer[0, 0] < line[0, 0] < line[-1, 0] < outer[-1, 0]]
    if beside or len(cavity) != bool(len(body.cavity)):
        raise WorkFailedError(f"the fitting '{name}' opens or divides the hull, or does not touch it")
    if (np.diff(outer[:, 0]) < 0).any():
        raise WorkFailedError(f"the fitting '{name}' is undercut along the axis, which the flow model does not know")
    joints = np.concatenate((outer[:1, 0], body.joints[1:-1], outer[-1:, 0]))
    return replace(body, outer=outer, cavity=cavity[0] if cavity else body.cavity, joints=joints)


def measure_details(body: Body, drawn: Iterable[Drawn]) -> Body:
    """Return a body with details alone, added and cut out in this order.

    Raises WorkFailedError if one has no room, or opens the hull; the message names it.
    """
    angle = np.linspace(math.pi, 0.0, 65)
    core = body.core.contour or body.core.radius * np.column_stack((np.cos(angle), np.abs(np.sin(angle))))
    kept = to_manifold(Union((_revolve(core), *(_revolve(pocket.contour()) for pocket in body.pockets))))
    hull = Translate((0.0, 0.0, MM * float(body.outer[:, 0].min())), build_hull(body))
    # What weighs, and what displaces.
    solids, found = [to_manifold(hull), to_manifold(_revolve(body.outer))], []
    for name, added, removed in drawn:
        try:
            gained, lost = (Manifold() if tree is None else to_manifold(tree) for tree in (added, removed))
        except WorkFailedError as error:
            raise WorkFailedError(f"the fitting '{name}' has no solid in this hull: {error}") from None
        fitted = [solid + gained - lost for solid in solids]
        if (gained ^ kept).volume() > _NOTHING:
            raise WorkFailedError(
                f"the fitting '{name}' takes the place of the core or of a trim pocket: fit it at another place, or set "
                "builder.pockets.diameter to 0"
            )
        before, after = ([shell.volume() > 0 for shell in solid.decompose()] for solid in (solids[0], fitted[0]))
        if after.count(True) != 1 or after.count(False) < before.count(False):
            raise WorkFailedError(f"the fitting '{name}' opens or divides the hull, or does not touch it")
        beyond = gained - lost - solids[1]
        shadows = [beyond.rotate(view).project().area() if beyond.volume() > _THIN else 0.0 for view in _VIEWS]
        material, displaced = (_integrate(new) - _integrate(old) for new, old in zip(fitted, solids, strict=True))
        found.append(Detail(name, added, removed, material, displaced, math.hypot(*shadows) / MM**2))
        solids = fitted
    return replace(body, fittings=replace(body.fittings, details=tuple(found)))


def _revolve(contour: Any, *holes: FloatArray) -> Revolve:
    outline, *others = (
        tuple((MM * float(r), MM * float(x)) for x, r in line) for line in (contour, *holes) if len(line)
    )
    return Revolve(outline, tuple(others))
