"""A pipe with parts as one flat array for compiled kernels, built once for each pipe and its flow."""

import math

import numpy as np

from driftform.dynamics.fitting_walls import (
    ANGLE,
    AXES,
    BEND,
    CENTRE,
    COSINE,
    CURVE,
    DOWNSTREAM,
    EDGE,
    EDGE_POINTS,
    END_RADIUS,
    EXIT,
    EXTENT,
    FILLET,
    HEAD,
    INNER,
    KIND,
    LENGTH,
    NARROWEST,
    ORIGIN,
    OUTSIDE,
    PART,
    RADIUS,
    REDUCER,
    SIDE,
    SINE,
    STRAIGHT,
    TEE,
    UPSTREAM,
    edge_point,
)
from driftform.geometry.pipe_parts import (
    Bend,
    Opening,
    PipePart,
    Reducer,
    Straight,
    Tee,
    exact_cosine,
    exact_sine,
)
from driftform.scenario.layout import Layout
from driftform.types import FloatArray

_WALL = 0.5
"""Thickness of wall, in radii of the bore, in which a point still belongs to its part."""


def wall_rows(layout: Layout) -> FloatArray:
    """Return the rows of the parts of a pipe without their flow, and of what lies beyond the inlet and the outlets, (k, PART)."""
    rows = [_row_of_part(placed.part) for placed in layout.parts]
    inlet = layout.inlet
    x, y, z = inlet.axes
    rows.append(_row_beyond(Opening(inlet.centre, np.stack([-x, -y, z]), inlet.radius), OUTSIDE))
    rows += [_row_beyond(outlet.opening, float(k)) for k, outlet in enumerate(layout.outlets)]
    return np.stack(rows)


def _row_of_part(part: PipePart) -> FloatArray:
    row = np.zeros(PART)
    row[ORIGIN : ORIGIN + 3], row[AXES : AXES + 9] = part.origin, part.axes.ravel()
    row[RADIUS], row[END_RADIUS], row[LENGTH] = part.radius, part.end_radius, part.length
    row[NARROWEST], row[EXIT] = min(part.radius, part.end_radius), INNER
    match part:
        case Straight():
            row[KIND] = STRAIGHT
        case Bend():
            row[KIND], row[CURVE], row[ANGLE] = BEND, part.bend_radius, part.angle
        case Reducer():
            row[KIND], row[CURVE] = REDUCER, part.arc_radius
        case Tee():
            row[KIND], row[END_RADIUS], row[FILLET] = TEE, part.branch_radius, part.fillet
            row[COSINE], row[SINE] = exact_cosine(part.angle), exact_sine(part.angle)
            row[UPSTREAM], row[DOWNSTREAM], row[SIDE] = part.legs
            flat = np.concatenate([np.zeros(HEAD), row])
            for k, phi in enumerate(np.linspace(0, math.pi, EDGE_POINTS)):
                row[EDGE + 3 * k : EDGE + 3 * k + 3] = edge_point(float(phi), flat, HEAD)[0]
    axes = part.list_axes(0.1 * part.radius)
    points = np.concatenate([axis.points for axis in axes])
    widest = max(float(axis.radii.max()) for axis in axes)
    low, high = points.min(axis=0), points.max(axis=0)
    row[CENTRE : CENTRE + 3] = 0.5 * (low + high)
    farthest = float(np.linalg.norm(points - row[CENTRE : CENTRE + 3], axis=1).max())
    row[EXTENT] = math.hypot(farthest, 0.1 * widest) + (1 + _WALL) * widest
    return row


def _row_beyond(opening: Opening, exit_: float) -> FloatArray:
    """Return the row of the bore beyond an opening: a straight part without end."""
    row = np.zeros(PART)
    row[KIND], row[EXIT] = STRAIGHT, exit_
    row[ORIGIN : ORIGIN + 3], row[AXES : AXES + 9] = opening.centre, opening.axes.ravel()
    row[RADIUS] = row[END_RADIUS] = row[NARROWEST] = opening.radius
    row[LENGTH] = row[EXTENT] = math.inf
    return row
