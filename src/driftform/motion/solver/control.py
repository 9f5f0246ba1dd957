"""Step control: how long the next step is, and how accurate.

Gustafsson's controller uses the error of the step before as well, and so rejects few steps (Hairer, Norsett and Wanner,
Solving Ordinary Differential Equations II, 2nd ed., section IV.2).
"""

import math
from typing import NamedTuple

from driftform.util.compiled import compiled

TOLERANCE_GROWTH = 0.5
"""Rate (1/s) at which the tolerance grows along a flight: about the rate at which small differences grow.

The two integrations then take 1.6 times fewer steps than with a constant tolerance, and differ by as much.
"""

MAX_GROWTH = 100.0
"""Ratio of the tolerance at the end of a long flight to that at its release."""

LOG_MIN_ERROR = math.log(1e-4)
"""Lower bound of the logarithm of a step's error over tolerance, as used for the length of the next step."""

SHORTEST_STEP = 1e-12
"""Length of a step, s, below which an integration fails."""

SAFETY, MIN_FACTOR, MAX_FACTOR = 0.9, 0.2, 5.0
"""Share of the step that the error allows, and the smallest and largest factor from one step to the next."""


class StepControl(NamedTuple):
    """Length of the next step (s), and logarithm of the last accepted step's error over tolerance."""

    h: float
    earlier: float


@compiled
def grow_tolerance(tolerance: float, t: float) -> float:
    """Return the tolerance of a step at the time ``t`` (s) after the release, where it is ``tolerance``.

    An early error has the rest of the flight to grow, from collision to collision.
    """
    return tolerance * min(MAX_GROWTH, math.exp(TOLERANCE_GROWTH * t))


@compiled
def shorten(h: float, error: float, power: float) -> float:
    """Return the step (s) that follows a rejected one of ``h`` with this error over tolerance; ``power`` is the method's."""
    return h * (max(MIN_FACTOR, SAFETY * error ** (-1.0 / power)) if math.isfinite(error) else MIN_FACTOR)


@compiled
def continue_after(h: float, error: float, power: float, earlier: float) -> StepControl:
    """Return the control after an accepted step of ``h`` s with this error over tolerance; ``power`` is the method's."""
    now = math.log(max(error, 1e-8))
    h *= min(MAX_FACTOR, max(MIN_FACTOR, SAFETY * math.exp((0.4 * earlier - 0.7 * now) / power)))
    return StepControl(h, max(now, LOG_MIN_ERROR))
