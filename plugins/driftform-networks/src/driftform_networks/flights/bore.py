"""The cross-section of a bore: the band where a body is, and the streamtubes that carry it into the outlets of a junction.

Coordinates are relative to the bore's radius, to the right and upward as seen downstream. The bands divide the disc
that the body's centre can take: a middle disc of a third of its radius, and a ring of eight sectors, all of the same
area. Sector 1 is at the top, and the others follow clockwise; a body that has settled is in the middle of sector 1
or 5.

The ideal flow through a tee divides the water of the inlet by a surface; upstream, where the flow is plug flow, that
surface is taken as flat, and its distance from the axis follows from continuity: the water beyond it is the share of
the branch. For several outlets, linear functions divide the cross-section, so that each outlet takes the water nearest
to the side where it leaves: a power diagram, whose weights follow from the shares (Aurenhammer, Hoffmann and Aronov,
Minkowski-type theorems and least-squares clustering, Algorithmica 20, 1998, doi:10.1007/PL00009187).
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


_ROUNDS = 40


def divide_bore(points: FloatArray, directions: FloatArray, shares: FloatArray) -> FloatArray:
    """Return the probability that the water at each point of the bore flows into each outlet, (n, outlets).

    Outlets that leave at the same side share the water there in proportion to their flows.

    Args:
        points: to the right and upward as seen downstream, relative to the radius of the bore, (n, 2).
        directions: unit vectors towards the side where each outlet leaves, to the right and upward as seen
            downstream; zero for an outlet straight ahead, (outlets, 2).
        shares: of the water, with the sum 1, (outlets,).
    """
    sides, side = np.unique(directions.round(6), axis=0, return_inverse=True)
    together = np.asarray(np.bincount(side, shares, len(sides)), np.float64)
    chosen = np.argmax(points @ sides.T + weigh_outlets(sides, together), axis=1)
    within = np.where(side == np.arange(len(sides))[:, None], shares, 0.0) / together[:, None]
    return np.asarray(within[chosen])


def divide_mixed(directions: FloatArray, shares: FloatArray, room: float) -> FloatArray:
    """Return the probability that a body which is anywhere in the bore enters each outlet, (outlets,).

    All water carries the body, also that within its radius of the wall: there its centre is as near as it can be.

    Args:
        directions, shares: those of :func:`divide_bore`.
        room: radius of the disc that its centre can take, relative to that of the bore.
    """
    across = tuple((directions[0] - directions[1]).round(6).tolist())
    if len(shares) != 2 or across == (0.0, 0.0):
        return np.asarray(divide_bore(_crowd(room), directions, shares).mean(axis=0))
    weight = _between(_sort_heights(across, 1.0), shares[1])
    taken = float(np.searchsorted(_sort_heights(across, room), weight)) / len(spread_points(1.0))
    return np.array([1 - taken, taken])


def _crowd(room: float) -> FloatArray:
    """Return points that fill the bore evenly; those beyond ``room`` are moved back to it."""
    points = spread_points(1.0)
    return np.asarray(points * np.minimum(1.0, room / np.linalg.norm(points, axis=1))[:, None])


@cache
def _sort_heights(across: tuple[float, float], room: float) -> FloatArray:
    """Return such points' coordinates along a direction, sorted: the same for all junctions of a kind."""
    return np.sort(_crowd(room) @ np.array(across))


def weigh_outlets(directions: FloatArray, shares: FloatArray) -> FloatArray:
    """Return the weights w with which the points x of the bore where n_i . x + w_i is greatest flow into outlet i.

    ``directions`` n must differ from each other; they and ``shares`` are those of :func:`divide_bore`.
    """
    points = spread_points(1.0)
    height = points @ directions.T
    weights = np.zeros(len(shares))
    for _ in range(_ROUNDS if len(shares) > 2 else 1):
        before = weights.copy()
        for outlet in range(1, len(shares)):
            # The outlet takes the points where it is above the highest of the others: their share decides its weight.
            others = np.delete(height + weights, outlet, axis=1).max(axis=1)
            lead = np.sort(others - height[:, outlet])
            weights[outlet] = _between(lead, shares[outlet])
        if np.abs(weights - before).max() < 1e-6:
            break
    return weights


def _between(lead: FloatArray, share: float) -> float:
    """Return a number that a share of sorted numbers lie below, in the middle between two of them."""
    count = round(share * len(lead))
    if count <= 0:
        return float(lead[0] - 1e-3)
    if count >= len(lead):
        return float(lead[-1] + 1e-3)
    return float((lead[count - 1] + lead[count]) / 2)


def smallest_share(size: float) -> float:
    """Return the share of a branch below which a neutral sphere cannot enter it; it may need twice that share and more.

    Its centre is never nearer to the wall than its radius, so that it stays on the other side of a flat dividing
    surface in plug flow: [acos(1 - s) - (1 - s) sqrt(2 s - s^2)] / pi.

    Args:
        size: radius of the sphere over that of the bore, from 0 to 1.

    >>> [round(100 * smallest_share(size), 2) for size in (0.05, 0.1, 0.2, 0.3)]
    [0.67, 1.87, 5.2, 9.41]
    """
    return float((np.arccos(1 - size) - (1 - size) * np.sqrt(2 * size - size**2)) / np.pi)
