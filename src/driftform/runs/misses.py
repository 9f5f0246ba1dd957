"""The misses of one agent over many disturbed flights: their median, and the miss that 9 of 10 flights stay within."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from driftform.runs.dependence import Effect, divide_spread
from driftform.types import FloatArray
from driftform.water.disturbances import Condition

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
    def failed(self) -> int:
        """Number of flights that failed for at least one target."""
        return int(np.isnan(self.distances).any(axis=1).sum())

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
