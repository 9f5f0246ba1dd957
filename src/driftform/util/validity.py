"""The range of every formula: what is checked, where it holds, from which source, and what happens outside.

``validity.toml`` is the only place of these numbers: checks, warnings and docs read them from ``RANGES``.
"""

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Range:
    """Where a formula holds, by one quantity.

    Attributes:
        quantity, symbol, unit: in words, as in formulas, and SI; an empty unit for a ratio.
        low, high: ends of the range; infinite where the range is open.
        source: of the formula or of its range.
        outside: what the program does where the value lies outside.
    """

    quantity: str
    symbol: str
    low: float
    high: float
    source: str
    outside: str
    unit: str = ""

    def contains(self, value: float) -> bool:
        """Return whether a value lies in the range; ``nan`` does not."""
        return self.low <= value <= self.high

    def describe(self) -> str:
        """Return the range as text.

        >>> Range("Reynolds number", "Re_D", 4e3, math.inf, "", "").describe()
        'from 4000'
        """
        unit = f" {self.unit}" if self.unit else ""
        if math.isinf(self.low):
            return f"up to {self.high:.6g}{unit}"
        if math.isinf(self.high):
            return f"from {self.low:.6g}{unit}"
        return f"from {self.low:.6g} to {self.high:.6g}{unit}"


RANGES: dict[str, tuple[Range, ...]] = {
    formula: tuple(Range(**row) for row in rows)
    for formula, rows in tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8")).items()
}
"""The ranges of each formula, by its name."""


def find_departures(formula: str, values: Mapping[str, float]) -> list[str]:
    """Return a line for each value outside the range of a formula: quantity, value, range.

    Args:
        formula: a name in :data:`RANGES`.
        values: by the symbols of the quantities; a quantity without a value is not checked.

    >>> find_departures("logarithmic law", {"Re_D": 1000.0})
    ['logarithmic law: Reynolds number of the pipe (mean speed, diameter) Re_D = 1000; it holds from 4000 to 1e+08']
    """
    found = []
    for limit in RANGES[formula]:
        value = values.get(limit.symbol)
        if value is not None and not limit.contains(value):
            unit = f" {limit.unit}" if limit.unit else ""
            found.append(f"{formula}: {limit.quantity} {limit.symbol} = {value:.4g}{unit}; it holds {limit.describe()}")
    return found
