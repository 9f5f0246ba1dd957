"""Lamb's alpha_0 and k11 against quadrature of his integral and published values."""

import math

import pytest
from scipy.integrate import quad

from driftform_striptheory.ellipsoid import alpha_0, axial_coefficient


def lambs_integral(slenderness: float) -> float:
    """alpha_0 = a b^2 int_0^inf dl / ((a^2 + l)^(3/2) (b^2 + l)), with a = 1 and b = d/L.

    With l = b^2 (e^s - 1) the integrand falls off at either end, however slender or flat the spheroid.
    """
    square = slenderness**2

    def integrand(s: float) -> float:
        return square * (1 + square * math.expm1(s)) ** -1.5

    knee = math.log1p(1 / square)
    parts = [quad(integrand, a, b, epsabs=0, epsrel=1e-12)[0] for a, b in ((0, knee), (knee, knee + 40))]
    return sum(parts)


@pytest.mark.parametrize(
    "slenderness", [0.01, 0.05, 0.1, 1 / 6, 0.25, 0.5, 0.9, 0.999, 1 - 1e-9, 1 + 1e-6, 1.04, 1.1, 1.5, 2, 4, 10, 50]
)
def test_spheroids_follow_lambs_integral(slenderness):
    assert alpha_0(slenderness) == pytest.approx(lambs_integral(slenderness), rel=1e-11)


@pytest.mark.parametrize(("ratio", "k1"), [(2, 0.2100), (4, 0.0816), (6, 0.04518), (10, 0.0207)], ids="{}:1".format)
def test_published_axial_coefficients(ratio, k1):
    places = len(str(k1).rstrip("0").partition(".")[2])
    assert axial_coefficient(1 / ratio) == pytest.approx(k1, abs=0.51 * 10.0 ** -max(places, 4))


@pytest.mark.parametrize("slenderness", [0.0, -1.0, math.nan, math.inf])
def test_an_invalid_slenderness_is_refused(slenderness):
    with pytest.raises(ValueError, match="expected a positive number"):
        alpha_0(slenderness)
