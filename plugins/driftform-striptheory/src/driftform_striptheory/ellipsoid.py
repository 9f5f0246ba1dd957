"""Axial added mass of a spheroid (Lamb, Hydrodynamics, 6th ed., sections 114 and 115; eq. 8 to 10)."""

import math


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

    Eq. 9, and its counterpart for oblate spheroids, where eq. 10 has no real root, are both 2/3 s R_D(s, s, 1) with
    s = (d/L)^2 and Carlson's integral R_D (DLMF 19.16.5); ``slenderness`` is the largest diameter over length, d/L > 0.

    Raises ValueError if ``slenderness`` is not positive and finite.
    """
    from scipy.special import elliprd

    if not (0 < slenderness < math.inf):
        raise ValueError(f"d/L is {slenderness}, expected a positive number")
    s = slenderness**2
    return 2 / 3 * s * float(elliprd(s, s, 1.0))
