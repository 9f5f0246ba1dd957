"""Agent -> OpenSCAD source of its sealed hull, to edit: a table of modules, a wall, a core.

The source follows the builder of ``frusta``: the chains of modules and a dome over the core are united, and the
cavity is their inward offset by the wall, with the room of the core. The solid that it renders to is computed here by
the same steps, and compared with the body.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise

import numpy as np
from manifold3d import CrossSection, FillRule, JoinType

from driftform.agent import solid_of_revolution
from driftform.types import Agent, Body, Module
from driftform_frusta.csg import MM
from driftform_frusta.hull import hull_volume
from driftform_frusta.scad import fill_source, format_number
from driftform_frusta.section import DOME_STEP

_TOLERANCE = 5e-5
"""Of the volume, relative: OpenSCAD, which clips on a grid of 15 nm, adds some 2e-5, and 1e-4 is promised."""

_BESIDE = 1e-12
"""m: a step of the outline is seen from both sides of it."""

_UNLIMITED = 1e6
"""OpenSCAD's limit of a mitre, in walls."""


@dataclass(frozen=True)
class Row:
    """One module of the table, mm; ``length`` along the axis."""

    name: str
    length: float
    aft: float
    fore: float


def hull_source(agent: Agent, segments: int, title: str) -> str | None:
    """Return OpenSCAD source that renders to the sealed hull of an agent, mm, fore end up, its lowest point at z = 0.

    ``segments`` is the number of corners of every circle. Its volume is that of the closed form within 1e-4; ``None`` for a body that
    was made in another way.
    """
    body = agent.body
    # Both chains start from the dome at the core's equator.
    clearance = MM * (_radius_at(body, 0.0) - body.core.radius - body.wall)
    rows, aft = _tabulate_modules(agent)
    if rows is None or body.core.contour or not _renders_to_hull(body, rows, aft, clearance):
        return None
    count = f"{len(rows)} module{'s' if len(rows) != 1 else ''}"
    size = f"{1000 * body.length:.1f} mm long, {1000 * body.max_diameter:.1f} mm in diameter"
    table = ",\n".join(
        f'    ["{row.name}",{" " * (8 - len(row.name))}{row.length:10.6f}, {row.aft:10.6f}, {row.fore:10.6f}]'
        for row in rows
    )
    return fill_source(
        "modules",
        title=" ".join(title.split()),
        summary=f"{count} and a dome over the core, {size}",
        definitions=fill_source("definitions", segments=segments),
        wall=format_number(MM * body.wall),
        clearance=format_number(clearance),
        core=format_number(MM * body.core.radius),
        rows=table,
        aft=aft,
        step=format_number(math.degrees(DOME_STEP)),
    )


def _radius_at(body: Body, x: float) -> float:
    """Radius of the outline, m; the greater one where it has a step."""
    return float(np.interp([x - _BESIDE, x + _BESIDE], *body.outer.T).max())


def _tabulate_modules(agent: Agent) -> tuple[list[Row] | None, int]:
    """The modules as the builder would lay them, and how many lie aft; ``None`` for a body without modules."""
    body, morphology = agent.body, agent.morphology
    if morphology is None:
        return None, 0
    rows = []
    for end, modules, side in (("aft", morphology.aft, -1), ("fore", morphology.fore, 1)):
        joints = pairwise(_joints(body, modules, side))
        laid = [(f"{end} {k}", x - near, (r_near, r)[::side]) for k, ((near, r_near), (x, r)) in enumerate(joints, 1)]
        rows += [Row(name, *(round(MM * v, 6) for v in (long, *radii))) for name, long, radii in laid[::side]]
    return rows, len(morphology.aft)


def _joints(body: Body, modules: Sequence[Module], side: float) -> list[tuple[float, float]]:
    """Distance from the core's equator and radius of every joint of one side, from the core outward, m.

    Clear of the dome the radius is that of the outline, which knows the least radius of the builder; below the dome
    it follows from the tilt.
    """
    dome = _radius_at(body, 0.0)
    joints = [(0.0, dome)]
    for module in modules:
        x = joints[-1][0] + module.length * math.cos(module.tilt)
        r = joints[-1][1] + module.length * math.sin(module.tilt)
        joints.append((x, _radius_at(body, side * x) if x >= dome else r))
    return joints


def _renders_to_hull(body: Body, rows: Sequence[Row], aft: int, clearance: float) -> bool:
    wall, dome = MM * body.wall, MM * (body.core.radius + body.wall) + clearance
    if min(dome, clearance + 1e-6, wall) <= 0:
        return False
    heights = np.array([0.0, *accumulate(row.length for row in rows)])
    heights -= heights[aft]
    angles = np.arange(0, 2 * np.pi - DOME_STEP / 2, DOME_STEP)
    disc = np.column_stack([np.cos(angles), np.sin(angles)])
    frustums = [
        np.array([(-row.aft, z0), (row.aft, z0), (row.fore, z1), (-row.fore, z1)])
        for row, z0, z1 in zip(rows, heights[:-1], heights[1:], strict=True)
    ]
    outline = CrossSection([*frustums, dome * disc], FillRule.NonZero)
    room = CrossSection([(dome - wall / math.cos(DOME_STEP / 2)) * disc])
    hollow = outline.offset(-wall, JoinType.Miter, _UNLIMITED) + room
    (_, low, right, high) = outline.bounds()
    half = CrossSection.square((right + 1, high - low + 2)).translate((0.0, low - 1))
    rendered = sum(
        # Polygons run counter-clockwise, holes clockwise: up along the outside, and down along a hollow.
        solid_of_revolution(np.vstack([p, p[:1]])[:, ::-1]).volume
        for p in ((outline - hollow) ^ half).to_polygons()
    )
    expected = 1e9 * hull_volume(body)
    sizes = np.array([high - low, 2 * right]) - MM * np.array([body.length, body.max_diameter])
    return bool(abs(rendered - expected) <= _TOLERANCE * expected and np.abs(sizes).max() < 1e-4)
