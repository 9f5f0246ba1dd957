"""Fittings that bodies are flown through: tees, wyes, crosses, bends and reducers, and the few of them that stand for all."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from driftform_networks.flights.junctions import Junction
from driftform_networks.flights.streamtubes import smallest_share

RATIOS = {60.0: (0.5, 1.0), 90.0: (0.25, 0.5, 0.7, 1.0), 120.0: (0.5, 1.0)}
"""Angles between the branch and the run, degrees, and the bores of the branch over that of the main whose flow is stored.

A junction takes the nearest angle, and the nearest bore by factor; one with a narrow branch that of 90 degrees.
"""

NARROW_BRANCH = 0.35
"""Such a ratio below which a branch is narrow: between the two narrowest that are stored."""

MIN_RATIO = 0.2
"""Least such ratio of a junction that is flown: that of the narrowest branch whose flow driftform solves."""

MAX_LEAN_DEG = 45.0
"""Deviation of a branch from a right angle up to which it is flown, degrees."""

BENDS_DEG = (0.0, 22.5, 45.0, 90.0)
"""Turns of bends where two pipes meet, degrees; a turn takes the nearest."""

REDUCTIONS = (0.5, 0.7, 1.0, 1.4, 2.0)
"""Bore after a reducer over the bore before it; a change of bore takes the nearest by factor."""

RUN, BRANCH = range(2)
"""Outlets of a tee."""

SHARES = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95)
"""Shares of the water that the branch takes; a junction takes its two neighbours, weighted."""

MIN_MIXED_SPEED = 0.05
"""Least speed of flights of mixed bodies, m/s: slower water, which has no other way with them, takes these."""

NARROW = 0.1
"""Diameter of a mixed body over the bore of the main below which flights say what streamtubes say."""


@dataclass(frozen=True)
class Tee:
    """A tee or wye of these ladders; or a bend and a reducer, which have no branch.

    Attributes:
        bore: of the main, m.
        speed: mean speed in the main, m/s.
        ratio: bore of the branch, or after the reducer, over that of the main.
        angle_deg: between the branch and the run, or of the bend.
        clock_deg: side where branch or bend lead, as on a clock seen downstream: 0 at the top, 90 on the right.
        share: share of the water that the branch takes; ``None`` for a bend and a reducer.
    """

    bore: float
    speed: float
    ratio: float
    angle_deg: float
    clock_deg: float
    share: float | None


def find_branches(junction: Junction) -> tuple[list[int], str]:
    """Return the outlets that are branches of a tee, a wye or a cross which can be flown through, the largest share first.

    Without them, a few words say why streamtubes divide its bodies.
    """
    sideways = junction.directions.any(axis=1)
    branches = np.flatnonzero(sideways)
    ratios = junction.bores[branches] / max(junction.bore, 1e-9)
    turns = np.rad2deg(junction.turns[branches])
    reasons = (
        (junction.inlets != 1, "join"),
        (not junction.bore, "no bore upstream"),
        (len(junction.bores) > 3, "more branches"),
        ((~sideways).sum() != 1, "no straight run"),
        ((ratios > 1 + 1e-6).any(), "wide branch"),
        ((ratios < MIN_RATIO).any(), "narrow branch"),
        ((np.abs(turns - 90) > MAX_LEAN_DEG).any(), "steep branch"),
    )
    if reason := next((text for found, text in reasons if found), ""):
        return [], reason
    return sorted(branches.tolist(), key=lambda branch: -float(junction.shares[branch])), ""


def find_joint(junction: Junction, size: float) -> tuple[float, float]:
    """Return the turn of the bend, degrees, and the ratio of the reducer, that stand for two pipes which meet.

    They are 0 and 1 where there is neither. ``size`` is the diameter of the body over the bore upstream.
    """
    if junction.inlets != 1 or len(junction.bores) != 1 or not junction.bore * junction.bores[0]:
        return 0.0, 1.0
    ratio = match_ratio(float(junction.bores[0]) / junction.bore, size, REDUCTIONS)
    return match_angle(float(junction.turns[0]), BENDS_DEG), ratio


def match_angle(turn: float, angles: Sequence[float]) -> float:
    """Return the nearest of some angles, degrees, to a turn to either side, rad."""
    return min(angles, key=lambda known: abs(known - abs(float(np.rad2deg(turn)))))


def match_ratio(ratio: float, size: float, ratios: Sequence[float]) -> float:
    """Return the nearest of some ratios of bores; a wider one if a body of ``size`` fits into the branch, but not into that one.

    >>> [match_ratio(0.55, size, RATIOS[90]) for size in (0.1, 0.52, 0.7)]
    [0.5, 0.7, 0.5]
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
