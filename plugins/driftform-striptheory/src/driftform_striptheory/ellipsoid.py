"""Axial added mass of a spheroid (Lamb, Hydrodynamics, 6th ed., sections 114 and 115; eq. 8 to 10)."""

import math

SERIES_BELOW = 0.06
"""|1 - d^2/L^2| below which the series is used: the closed forms lose precision like eps / beta^3."""


def axial_coefficient(slenderness: float) -> float:
    """Return k11 = alpha_0 / (2 - alpha_0) of a spheroid whose diameter is ``slenderness`` times its length.

    >>> round(axial_coefficient(1 / 6), 5)
    0.04518
    >>> round(axial_coefficient(1.0), 12)
    0.5
    """
    alpha = alpha_0(slenderness)
    return alpha / (2 - alpha)


def alpha_0(slenderness: float) -> float:
    """Return Lamb's alpha_0 for the axis of revolution; 2/3 for the sphere.

    With s = d/L:

    * prolate (s < 1), beta = sqrt(1 - s^2): eq. 9, 2 (1 - beta^2) / beta^3 (atanh beta - beta);
    * oblate (s > 1), for which eq. 10 has no real root, e = sqrt(1 - 1/s^2):
      2 (1/e^2 - sqrt(1 - e^2) asin(e) / e^3);
    * near the sphere the series of the prolate form in q = 1 - s^2, which continues into q < 0:
      2/3 - 4 sum q^n / ((2n + 1)(2n + 3)), n = 1, 2, ...

    Args:
        slenderness: largest diameter over length, d/L > 0.

    Raises ValueError if ``slenderness`` is not positive and finite.
    """
    s = slenderness
    if not (0 < s < math.inf):
        raise ValueError(f"d/L is {s}, expected a positive number")
    q = 1 - s * s
    if abs(q) < SERIES_BELOW:
        return 2 / 3 - 4 * sum(q**n / ((2 * n + 1) * (2 * n + 3)) for n in range(1, 13))
    if q > 0:
        beta = math.sqrt(q)
        return 2 * s * s / beta**3 * (math.atanh(beta) - beta)
    e = math.sqrt(1 - 1 / (s * s))
    return 2 * (1 / e**2 - math.asin(e) / (s * e**3))
