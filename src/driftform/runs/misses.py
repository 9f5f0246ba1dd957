"""The misses of one agent over many disturbed flights: their median, the miss that 9 of 10 stay within, and what it depends on."""

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from driftform.types import FloatArray
from driftform.water.disturbances import Condition

MIN_FLIGHTS = 20
"""Fewest flights that a fit of all quantities is made from: about twice their number."""


@dataclass(frozen=True)
class Quantity:
    """A disturbed quantity: its name, what reduces its effect, and its fields of a condition."""

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


PROMISED = 0.9
"""Share of the flights that stay within the promised miss."""


def estimate_quantile(values: FloatArray, share: float) -> FloatArray:
    """Return the value that a further draw stays below with probability ``share``, (columns,), of values (n, columns).

    The k-th smallest of n draws has the expected probability k / (n + 1) (Weibull 1939; type 6 of Hyndman and Fan 1996,
    Sample quantiles in statistical packages, doi:10.2307/2684934), whatever the distribution; between two of them the
    quantile is linear in k. It is infinite where it lies beyond a value that is infinite.

    >>> estimate_quantile(np.array([[3.0], [1.0], [2.0]]), 0.5)
    array([2.])
    """
    ordered = np.sort(values, axis=0)
    rank = min(max(share * (len(ordered) + 1), 1.0), float(len(ordered))) - 1
    low, part = int(rank), rank % 1
    if not part:
        return np.asarray(ordered[low])
    # Not low + part (high - low), which is not a number between two infinite values.
    return np.asarray((1 - part) * ordered[low] + part * ordered[low + 1])


@dataclass(frozen=True, eq=False)
class Misses:
    """How far an agent's disturbed flights miss; a flight that failed says nothing, and counts as failed.

    Attributes:
        conditions: of each flight.
        offsets: vector from each target to the closest approach of each flight, world frame, m, (flights, targets,
            3); NaN for a failed flight. In a pipe with parts it is as long as the path through the water.
        known: the same in the same gusts, but as ``[gusts]`` describes them; ``None`` if they are not in doubt.
    """

    conditions: Sequence[Condition]
    offsets: FloatArray
    known: FloatArray | None = None

    @cached_property
    def distances(self) -> FloatArray:
        """Distance of each closest approach, m, (flights, targets); NaN for a failed flight."""
        return np.asarray(np.linalg.norm(self.offsets, axis=2))

    @property
    def count(self) -> int:
        """Number of flights."""
        return len(self.offsets)

    @property
    def median(self) -> FloatArray:
        """Median miss of the sound flights, m, (targets,); infinite without any."""
        return self._estimate(0.5)

    @property
    def promised(self) -> FloatArray:
        """Miss that 9 of 10 sound flights stay within, m, (targets,); infinite without any."""
        return self._estimate(PROMISED)

    @property
    def promised_in_known_gusts(self) -> FloatArray | None:
        """The same of the flights in known gusts; ``None`` if the gusts are not in doubt."""
        return None if self.known is None else Misses(self.conditions, self.known).promised

    def _estimate(self, share: float) -> FloatArray:
        sound = [column[~np.isnan(column)] for column in self.distances.T]
        return np.array([estimate_quantile(d[:, None], share)[0] if len(d) else np.inf for d in sound])

    def describe(self, target: int) -> dict[str, Any]:
        """Return numbers of flights and failures, and median and promised miss of a target (m), ``None`` if infinite.

        If the gusts are in doubt, the promised miss in known gusts is the last.
        """
        known = self.promised_in_known_gusts
        return {
            "flights": self.count,
            "failed": int(np.isnan(self.distances[:, target]).sum()),
            "median": finite_or_none(self.median[target]),
            "p90": finite_or_none(self.promised[target]),
            **({} if known is None else {"p90_known_gusts": finite_or_none(known[target])}),
        }

    def list_effects(self, target: int) -> list[Effect] | None:
        """Return what the miss of a target depends on, the largest part first; ``None`` if too few flights succeeded."""
        return divide_spread(self.conditions, self.offsets[:, target])


def finite_or_none(value: float) -> float | None:
    """Return a number, or ``None`` if it is infinite, which JSON cannot hold."""
    return float(value) if np.isfinite(value) else None
