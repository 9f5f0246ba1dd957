"""The range of every formula: what is checked, where it holds, from which source, and what happens outside.

``RANGES`` is the only place of these numbers: checks, warnings and docs read it.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Range:
    """Where a formula holds, by one quantity.

    Attributes
    ----------
    quantity, symbol, unit
        in words, as in formulas, and SI; an empty unit for a ratio.
    low, high
        ends of the range; infinite where the range is open.
    source
        of the formula or of its range.
    outside
        what the program does where the value lies outside.
    """

    quantity: str
    symbol: str
    low: float
    high: float
    unit: str
    source: str
    outside: str

    def contains(self, value: float) -> bool:
        """Return whether a value lies in the range; ``nan`` does not."""
        return self.low <= value <= self.high

    def describe(self) -> str:
        """Return the range as text.

        >>> Range("Reynolds number", "Re_D", 4e3, math.inf, "", "", "").describe()
        'from 4000'
        """
        unit = f" {self.unit}" if self.unit else ""
        if math.isinf(self.low):
            return f"up to {self.high:.6g}{unit}"
        if math.isinf(self.high):
            return f"from {self.low:.6g}{unit}"
        return f"from {self.low:.6g} to {self.high:.6g}{unit}"


REYNOLDS = "Reynolds number of the pipe (mean speed, diameter)"

BODY_REYNOLDS = "Reynolds number of the body (speed through the water, diameter)"

RANGES: dict[str, tuple[Range, ...]] = {
    "laminar profile": (
        Range(
            REYNOLDS,
            "Re_D",
            0.0,
            2300.0,
            "",
            "Schlichting, Boundary-Layer Theory, chapter XX",
            "'developed' takes another profile",
        ),
    ),
    "logarithmic law": (
        Range(
            REYNOLDS,
            "Re_D",
            4e3,
            1e8,
            "",
            "Colebrook 1939; Moody 1944",
            "a warning; the friction below is that at 4000",
        ),
    ),
    "power law": (Range(REYNOLDS, "Re_D", 4e3, 3.24e6, "", "Nikuradse 1932", "a warning"),),
    "drag": (
        Range(
            BODY_REYNOLDS,
            "Re_d",
            0.0,
            2e5,
            "",
            "Clift and Gauvin 1970; Sucker and Brauer 1975; Hoelzer and Sommerfeld 2008",
            "a warning; the drag crisis is left out",
        ),
        Range(
            "length over diameter",
            "L/d",
            0.0,
            40.0,
            "",
            "White, Fluid Mechanics, table 7.3",
            "a warning; the drag across is that at 40",
        ),
    ),
    "creeping drag": (
        Range(
            "length over diameter",
            "L/d",
            0.0,
            30.0,
            "",
            "Happel and Brenner 1965; Tirado and Garcia de la Torre 1979",
            "the same formula",
        ),
    ),
    "skin friction": (
        Range(
            "Reynolds number of the body (speed through the water, length)",
            "Re_L",
            0.0,
            1e9,
            "",
            "Blasius 1908; ITTC 1957",
            "a warning",
        ),
    ),
    "friction of a spin": (
        Range(
            "Reynolds number of the spin (rate, radius squared)",
            "Re_w",
            0.0,
            1e6,
            "",
            "Theodorsen and Regier 1944",
            "the same formula",
        ),
    ),
    "no history force": (
        Range(
            BODY_REYNOLDS,
            "Re_d",
            1e3,
            math.inf,
            "",
            "Rostami et al. 2006; ten Cate et al. 2002",
            "a warning; bodies speed up, slow down and bounce too readily: spheres in oil fell up to 13 % too fast",
        ),
    ),
    "spheres that rise straight": (
        Range(
            "density of a body that is nearly a sphere, over that of the water",
            "rho_b/rho",
            0.6,
            math.inf,
            "",
            "Horowitz and Williamson 2010",
            "a warning: such bodies rise in zigzags, which no flight has",
        ),
    ),
    "a body in a bore": (
        Range(
            "diameter over that of the narrowest bore",
            "b",
            0.0,
            0.3,
            "",
            "Ellis 1964; by continuity the water beside it is a tenth faster at 0.3",
            "a warning; the body changes the flow, which has only the drag of Achenbach 1974",
        ),
    ),
    "creeping in a bore": (
        Range(
            "diameter over that of the narrowest bore, of a body with Re_d below 1",
            "b",
            0.0,
            0.02,
            "",
            "Faxen 1922: the drag is 1 / (1 - 2.1 b) times as large",
            "a warning; the drag is too small",
        ),
    ),
    "added mass below a free surface": (
        Range(
            "distance of the surface from the release, over the diameter",
            "h/d",
            2.0,
            math.inf,
            "",
            "physics.md",
            "a warning; the added mass is that in deep water, and there are no waves",
        ),
    ),
    "restitution": (
        Range(
            "Stokes number of an impact",
            "St",
            10.0,
            math.inf,
            "",
            "Joseph et al. 2001; Legendre et al. 2006",
            "less than a thirtieth of the speed returns, where nothing does",
        ),
    ),
    "shear lift": (
        Range(
            "shear times diameter over slip",
            "G d / w",
            0.0,
            1.0,
            "",
            "Auton 1987, for weak shear",
            "the same formula; the lift is small where the slip is",
        ),
    ),
    "secondary flow of bends": (
        Range(
            REYNOLDS,
            "Re_D",
            1e4,
            math.inf,
            "",
            "Squire and Winter 1951; its decay: Appl. Sci. 14 (2024), 7895",
            "the same disturbance",
        ),
    ),
}
"""The ranges of each formula, by its name."""


def find_departures(formula: str, values: Mapping[str, float]) -> list[str]:
    """Return a line for each value outside the range of a formula: quantity, value, range.

    Parameters
    ----------
    formula
        a name in :data:`RANGES`.
    values
        by the symbols of the quantities; a quantity without a value is not checked.

    >>> find_departures("logarithmic law", {"Re_D": 1000.0})
    ['logarithmic law: Reynolds number of the pipe (mean speed, diameter) Re_D = 1000; it holds from 4000 to 1e+08']
    """
    found = []
    for limit in RANGES[formula]:
        value = values.get(limit.symbol)
        if value is not None and not limit.contains(value):
            unit = f" {limit.unit}" if limit.unit else ""
            found.append(
                f"{formula}: {limit.quantity} {limit.symbol} = {value:.4g}{unit}; it holds {limit.describe()}"
            )
    return found
