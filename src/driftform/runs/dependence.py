"""What a miss depends on: the spread of disturbed flights, divided among the quantities that were disturbed."""

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from driftform.types import FloatArray
from driftform.water.disturbances import Condition

MIN_FLIGHTS = 20
"""Fewest flights that a fit of all quantities is made from: about twice their number."""


@dataclass(frozen=True)
class Quantity:
    """A disturbed quantity.

    Attributes:
        name: for people.
        advice: what reduces its effect.
        fields: of a condition: its deviations.
    """

    name: str
    advice: str
    fields: tuple[str, ...]

    def read(self, condition: Condition) -> FloatArray:
        """Return its deviations under a condition, (n,)."""
        return np.hstack([getattr(condition, name) for name in self.fields])


QUANTITIES = tuple(
    Quantity(**row) for row in tomllib.loads(Path(__file__).with_name("quantities.toml").read_text("utf-8"))["quantity"]
)
"""The disturbed quantities; what none of them explains is due to gusts, and to effects that are not linear."""

REST = "gusts and the rest"
"""What no quantity explains."""


@dataclass(frozen=True)
class Effect:
    """The part of one quantity in the spread of the closest approach: a standard deviation, m, and what reduces it."""

    name: str
    deviation: float
    advice: str


def divide_spread(conditions: Sequence[Condition], offsets: FloatArray) -> list[Effect] | None:
    """Return the effect of each disturbed quantity on the closest approach to a target, the largest first.

    The offsets of the flights are fitted as linear functions of the deviations (least squares). The effect of a
    quantity is the root mean square of its part of the fit, less what chance alone would give it; the last entry is the
    standard deviation of the residual. For independent deviations the squares add up to the variance (first-order
    variance decomposition; Saltelli et al. 2008, Global Sensitivity Analysis, section 1.2).

    ``None`` if fewer than :data:`MIN_FLIGHTS` flights succeeded.

    Args:
        conditions: of each flight.
        offsets: vector from the target to the closest approach of each flight, m, (flights, 3); NaN for a failed
            flight.
    """
    sound = ~np.isnan(offsets[:, 0])
    if sound.sum() < MIN_FLIGHTS:
        return None
    columns = [
        np.array([quantity.read(c) for c in conditions]).reshape(len(conditions), -1)[sound] for quantity in QUANTITIES
    ]
    offsets = offsets[sound] - offsets[sound].mean(axis=0)
    deviations = np.hstack(columns)
    deviations -= deviations.mean(axis=0)
    scale = deviations.std(axis=0)
    used = scale > 0
    design = np.where(used, deviations / np.where(used, scale, 1.0), 0.0)
    slopes = np.asarray(np.linalg.lstsq(design, offsets, rcond=None)[0], dtype=np.float64)
    residual = offsets - design @ slopes
    freedom = max(1, len(offsets) - 1 - int(used.sum()))
    rest = (residual**2).sum(axis=0) / freedom
    effects, first = [], 0
    for quantity, column in zip(QUANTITIES, columns, strict=True):
        rows = slice(first, first + column.shape[1])
        first = rows.stop
        if not column.shape[1]:
            continue
        # The squared slopes less their own variance, 0 if that is larger.
        square = float(((slopes[rows] ** 2 - rest / len(offsets))[used[rows]]).sum())
        deviation = float(np.sqrt(max(0.0, square)))
        effects.append(Effect(quantity.name, deviation, quantity.advice))
    effects.sort(key=lambda effect: -effect.deviation)
    return [*effects, Effect(REST, float(np.sqrt(rest.sum())), "nothing: these are the water's own")]
