"""Junctions that bodies are flown through: tees and wyes, and the few of them that stand for all."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from driftform.types import FloatArray
from driftform_networks.bore import BANDS
from driftform_networks.junctions import Junction
from driftform_networks.streamtubes import smallest_share

RATIOS = {60.0: (0.5, 1.0), 90.0: (0.5, 1.0), 120.0: (0.5, 1.0)}
"""Angles between the branch and the run, degrees, and the bores of the branch over that of the main whose flow is stored.

A junction takes the nearest angle, and the nearest bore by factor.
"""

NARROWEST = 0.35
"""Least such ratio of a junction that is flown."""

WIDEST_DEG = 45.0
"""Deviation of a branch from a right angle up to which it is flown, degrees."""

RUN, BRANCH = range(2)
"""Outlets of a tee."""

SHARES = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95)
"""Shares of the water that the branch takes; a junction takes its two neighbours, weighted."""

SLOWEST_MIXED = 0.05
"""Least speed of flights of mixed bodies, m/s: slower water, which has no other way with them, takes these."""

NARROW = 0.1
"""Diameter of a mixed body over the bore of the main below which flights say what streamtubes say."""


@dataclass(frozen=True)
class Tee:
    """A tee or wye of these ladders.

    Attributes:
        bore: of the main, m.
        speed: mean speed in the main, m/s.
        ratio: bore of the branch over that of the main.
        angle_deg: between the branch and the run.
        clock_deg: side where the branch leaves, as on a clock seen downstream: 0 at the top, 90 on the right.
        share: share of the water that the branch takes.
    """

    bore: float
    speed: float
    ratio: float
    angle_deg: float
    clock_deg: float
    share: float


def find_branches(junction: Junction) -> tuple[list[int], str]:
    """Return the outlets that are branches of a tee or wye which can be flown through.

    Without them, a few words say why streamtubes divide its bodies.
    """
    sideways = junction.directions.any(axis=1)
    branches = np.flatnonzero(sideways)
    ratios = junction.bores[branches] / max(junction.bore, 1e-9)
    turns = np.rad2deg(junction.turns[branches])
    reasons = (
        (junction.inlets != 1, "join"),
        (not junction.bore, "no bore upstream"),
        (len(junction.bores) > 2, "cross"),
        ((~sideways).sum() != 1, "no straight run"),
        ((ratios > 1 + 1e-6).any(), "wide branch"),
        ((ratios < NARROWEST).any(), "narrow branch"),
        ((np.abs(turns - 90) > WIDEST_DEG).any(), "steep branch"),
    )
    if reason := next((text for found, text in reasons if found), ""):
        return [], reason
    return branches.tolist(), ""


def match_ratio(ratio: float, size: float, ratios: Sequence[float]) -> float:
    """Return the nearest of some ratios of bores; a wider one if a body of ``size`` fits into the branch, but not into that one.

    >>> [match_ratio(0.6, size, (0.5, 1.0)) for size in (0.1, 0.55, 0.7)]
    [0.5, 1.0, 0.5]
    """
    nearest = min(ratios, key=lambda known: abs(np.log(known / ratio)))
    if size <= ratio:
        return min((known for known in ratios if known >= nearest and size < 0.99 * known), default=nearest)
    return nearest


def weigh_shares(share: float, size: float) -> list[tuple[float, float]]:
    """Return the shares around one at which bodies are flown, with weights of the sum 1.

    The shares 0 and 1 stand for junctions where one outlet takes no body: that is where it takes less than the smallest
    share of streamtubes that a body of ``size``, its diameter over the bore, can follow; 0 for a body that is
    anywhere.

    >>> weigh_shares(0.125, 0.0)
    [(0.1, 0.75), (0.2, 0.25)]
    >>> weigh_shares(0.02, 0.2)
    [(0.0, 1.0)]
    """
    least = smallest_share(size)
    steps = [least, *(step for step in SHARES if least < step < 1 - least), 1 - least]
    names = [0.0, *steps[1:-1], 1.0]
    above = int(np.clip(np.searchsorted(steps, share), 1, len(steps) - 1))
    weight = float(np.clip((share - steps[above - 1]) / (steps[above] - steps[above - 1]), 0, 1))
    found = [(names[above - 1], round(1 - weight, 6)), (names[above], round(weight, 6))]
    return [(step, part) for step, part in found if part > 0]


def send_all(outlet: int) -> FloatArray:
    """Return the probability of each outlet and band where all bodies take one outlet, in their bands, (bands, 2, bands)."""
    onward = np.zeros((BANDS, 2, BANDS))
    onward[:, outlet] = np.eye(BANDS)
    return onward
