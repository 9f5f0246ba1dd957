"""A capsule as the core: its place in the hull, and the outline of the hull over it."""

from functools import lru_cache
from itertools import pairwise

import numpy as np
from manifold3d import CrossSection, FillRule, OpType

from driftform.agent import solid_of_revolution
from driftform.types import Core, FloatArray
from driftform_frusta.csg import MM

STEP = np.deg2rad(2.5)
"""Around a corner of the capsule the outline is a polyline of this step, which encloses the arc."""

_WIDEST = 1e-4
"""Radii that differ from the greatest by less than this share are the greatest too."""

_MARGIN = 10.0
"""mm beyond the outline."""


@lru_cache(maxsize=16)
def place_capsule(profile: tuple[tuple[float, float], ...], mass: float, cog: float) -> Core:
    """Return a capsule as a core whose widest part has its middle at the origin; its nose is fore.

    ``profile`` are distance from the nose and radius, m; ``mass`` is in kg, and ``cog`` the distance of the centre of gravity
    from the nose, m. A hull is put over the core from both ends, so a waist needs the room of what passes there.
    """
    contour = np.array(profile)[::-1] * [-1.0, 1.0]
    contour[:, 0] -= sum(find_shoulders(contour)) / 2
    r = contour[:, 1]
    first, last = np.flatnonzero(_is_widest(r))[[0, -1]]
    room = np.concatenate(
        (np.maximum.accumulate(r[:first]), np.full(last + 1 - first, r.max()), np.maximum.accumulate(r[:last:-1])[::-1])
    )
    return Core(
        radius=float(r.max()),
        mass=mass,
        contour=tuple(zip(contour[:, 0].tolist(), room.tolist(), strict=True)),
        solid=solid_of_revolution(contour),
        cog=float(contour[-1, 0]) - cog,
    )


def find_shoulders(contour: FloatArray) -> tuple[float, float]:
    """Return x of the aft and the fore end of the widest part of a contour, m."""
    x = contour[_is_widest(contour[:, 1]), 0]
    return float(x[0]), float(x[-1])


def _is_widest(radii: FloatArray) -> FloatArray:
    return np.asarray(radii >= (1 - _WIDEST) * radii.max())


@lru_cache(maxsize=16)
def outline_core(contour: tuple[tuple[float, float], ...], distance: float) -> FloatArray:
    """Return the contour of all that is within a distance (m) of a core's contour, from aft to fore, (n, 2), m."""
    points = MM * np.array(contour)
    angle = STEP * (np.arange(round(2 * np.pi / STEP)) + 0.5)
    # Its sides touch the circle, so that along an axis or across it the distance is exact.
    disc = MM * distance / np.cos(STEP / 2) * np.column_stack((np.cos(angle), np.sin(angle)))
    swept = [CrossSection.hull_points(np.concatenate((disc + start, disc + end))) for start, end in pairwise(points)]
    inside = CrossSection([np.concatenate((points, points[-2:0:-1] * (1.0, -1.0)))], FillRule.NonZero)
    grown = CrossSection.batch_boolean([inside, *swept], OpType.Add)
    low, _, high, top = grown.bounds()
    half = CrossSection.square((high - low + 2 * _MARGIN, top + _MARGIN)).translate((low - _MARGIN, 0.0))
    # Rounded to nm, so that a flat end has one x, and without points that then are one.
    ring = np.round((grown ^ half).to_polygons()[0][::-1], 6)
    ring = ring[(ring != np.roll(ring, 1, axis=0)).any(axis=1)]
    # From the aft axis point over the top to the fore one.
    outline: FloatArray = np.roll(ring, -int(np.lexsort((ring[:, 0], ring[:, 1] > 1e-6))[0]), axis=0) / MM
    outline[[0, -1], 1] = 0.0
    outline.setflags(write=False)
    return outline
