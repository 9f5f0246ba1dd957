"""The bands of a bore: where in the cross-section a body is.

Coordinates are relative to the bore's radius, to the right and upward as seen downstream. The bands divide the disc
that the body's centre can take: a middle disc of a third of its radius, and a ring of eight sectors, all of the same
area. Sector 1 is at the top, and the others follow clockwise; a body that has settled is in the middle of sector 1
or 5.
"""

from functools import cache

import numpy as np

from driftform.types import FloatArray
from driftform_networks.hydraulics.network import IntArray

BANDS = 9
"""Number of bands of a bore."""

MIDDLE, TOP, RIGHT, BOTTOM, LEFT = 0, 1, 3, 5, 7
"""Numbers of the band in the middle, and of those at four sides."""

MIRROR = np.array([0, 1, 8, 7, 6, 5, 4, 3, 2])
"""Band of the mirror image of each band, with right and left exchanged."""

MIXED = np.full(BANDS, 1 / BANDS)
"""Probability of each band of a body that is anywhere in the bore: the bands have the same area."""

_INNER = 1 / 3
_SECTORS = BANDS - 1


def find_band(points: FloatArray, room: float) -> IntArray:
    """Return the bands of points, (n,).

    Args:
        points: to the right and upward, relative to the radius of the bore, (n, 2).
        room: radius of the disc that the body's centre can take, relative to that of the bore.
    """
    distance = np.linalg.norm(points, axis=1)
    clock = np.arctan2(points[:, 0], points[:, 1])
    sector = np.rint(clock / (2 * np.pi / _SECTORS)).astype(np.int64) % _SECTORS
    return np.where(distance < _INNER * room, MIDDLE, 1 + sector)


@cache
def spread_points(room: float, rings: int = 18, around: int = 144) -> FloatArray:
    """Return points that fill the disc that a body's centre can take, each for the same area, (rings * around, 2).

    Each band holds the same number of them, if ``rings`` is a multiple of 9 and ``around`` one of 8.
    """
    radius = room * np.sqrt((np.arange(rings) + 0.5) / rings)
    # Half a step off, so that no point lies on the border of a sector, nor on the vertical.
    clock = 2 * np.pi * (np.arange(around) + 0.5) / around
    points = np.column_stack([np.outer(radius, np.sin(clock)).ravel(), np.outer(radius, np.cos(clock)).ravel()])
    points.flags.writeable = False
    return points


def sample_band(band: int, room: float, numbers: FloatArray) -> FloatArray:
    """Return points in a band, of equal density, from pairs of numbers in [0, 1), (n, 2)."""
    if band == MIDDLE:
        radius, clock = _INNER * room * np.sqrt(numbers[:, 0]), 2 * np.pi * numbers[:, 1]
    else:
        radius = room * np.sqrt(_INNER**2 + (1 - _INNER**2) * numbers[:, 0])
        clock = 2 * np.pi / _SECTORS * (band - 1.5 + numbers[:, 1])
    return np.column_stack([radius * np.sin(clock), radius * np.cos(clock)])
