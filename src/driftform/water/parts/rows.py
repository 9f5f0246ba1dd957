"""The walls of a pipe as rows of numbers for compiled kernels: :mod:`driftform.water.parts.walls` explains them."""

import math

import numpy as np

from driftform.types import FloatArray
from driftform.water.parts import walls as wall
from driftform.water.parts.layout import BEYOND, Layout
from driftform.water.parts.shapes import Bend, Opening, PipePart, Reducer, Straight, Tee, exact_cosine, exact_sine
from driftform.water.parts.tee_wall import fill_edge

UNSEEN_DEPTH = 2e-4
"""Depth (m) to which a wall may bulge between two rims of a body without touching one: about that of a contact."""

MIN_RIM_SPACING = 2e-3
"""Least distance between additional rims, m."""

_WALL = 0.5
"""Thickness of wall, in radii of the bore, in which a point still belongs to its part."""

_OPEN_WATER = 1e7
"""Radius of the bore that stands for open water, m."""


def wall_rows(layout: Layout) -> FloatArray:
    """Return the rows of the parts of a pipe without their flow, and of what lies beyond the inlet and the outlets, (k, PART)."""
    rows = [_row_of_part(placed.part) for placed in layout.parts]
    inlet = layout.inlet
    before = inlet.centre - BEYOND * inlet.radius * inlet.axes[0]
    rows.append(_row_beyond(Opening(before, inlet.axes, inlet.radius), wall.OUTSIDE))
    rows += [_row_beyond(outlet.opening, float(k)) for k, outlet in enumerate(layout.outlets)]
    return np.stack(rows)


def _row_of_part(part: PipePart) -> FloatArray:
    row = np.zeros(wall.PART)
    row[wall.ORIGIN : wall.ORIGIN + 3], row[wall.AXES : wall.AXES + 9] = part.origin, part.axes.ravel()
    row[wall.RADIUS], row[wall.END_RADIUS], row[wall.LENGTH] = part.radius, part.end_radius, part.length
    row[wall.NARROWEST], row[wall.EXIT] = part.narrowest, wall.INNER
    match part:
        case Straight():
            row[wall.KIND] = wall.STRAIGHT
        case Bend():
            row[wall.KIND], row[wall.CURVE], row[wall.ANGLE] = wall.BEND, part.bend_radius, part.angle
        case Reducer():
            row[wall.KIND], row[wall.CURVE] = wall.REDUCER, part.bulge
        case Tee():
            row[wall.KIND], row[wall.END_RADIUS], row[wall.FILLET] = wall.TEE, part.branch_radius, part.fillet
            row[wall.COSINE], row[wall.SINE] = exact_cosine(part.angle), exact_sine(part.angle)
            row[wall.UPSTREAM], row[wall.DOWNSTREAM], row[wall.SIDE] = part.legs
            fill_edge(row)
    axes = part.list_axes(0.1 * part.radius)
    points = np.concatenate([axis.points for axis in axes])
    widest = max(float(axis.radii.max()) for axis in axes)
    low, high = points.min(axis=0), points.max(axis=0)
    row[wall.CENTRE : wall.CENTRE + 3] = 0.5 * (low + high)
    farthest = float(np.linalg.norm(points - row[wall.CENTRE : wall.CENTRE + 3], axis=1).max())
    row[wall.EXTENT] = math.hypot(farthest, 0.1 * widest) + (1 + _WALL) * widest
    return row


def _row_beyond(opening: Opening, exit_: float) -> FloatArray:
    """Return the row of the bore beyond an opening."""
    row = np.zeros(wall.PART)
    row[wall.KIND], row[wall.EXIT] = wall.STRAIGHT, exit_
    row[wall.ORIGIN : wall.ORIGIN + 3], row[wall.AXES : wall.AXES + 9] = opening.centre, opening.axes.ravel()
    row[wall.RADIUS] = row[wall.END_RADIUS] = row[wall.NARROWEST] = opening.radius
    row[wall.LENGTH] = BEYOND * opening.radius
    row[wall.CENTRE : wall.CENTRE + 3] = opening.centre + 0.5 * row[wall.LENGTH] * opening.axes[0]
    row[wall.EXTENT] = 0.5 * row[wall.LENGTH] + (1 + _WALL) * opening.radius
    return row


def greatest_curvature(layout: Layout) -> float:
    """Return by how much the curvatures of a wall across and along the pipe differ at most, 1/m.

    The rounded edge of a tee is left out: bodies do not lie on it with a flat end.
    """
    parts = [placed.part for placed in layout.parts]
    bends = (1 / part.narrowest + (0.0 if isinstance(part, Tee) else 1 / part.bulge) for part in parts)
    return max(bends, default=0.0)


def rim_spacing(layout: Layout) -> float:
    """Return the greatest distance (m) between the rims of a body: a wall of the radius rho rises by s^2 / (8 rho) between two."""
    bulge = min((placed.part.bulge for placed in layout.parts), default=math.inf)
    return max(MIN_RIM_SPACING, math.sqrt(8 * UNSEEN_DEPTH * bulge))


def open_water_rows() -> FloatArray:
    """Return the row of a bore without end that stands for open water, (1, PART)."""
    centre = np.array([-_OPEN_WATER, 0.0, 0.0])
    return _row_beyond(Opening(centre, np.eye(3), _OPEN_WATER), wall.INNER)[None]
