"""Lamb's alpha_0 and k11 against quadrature of his integral and published values."""

import math

import pytest
from scipy.integrate import quad

from driftform_striptheory.ellipsoid import SERIES_BELOW, alpha_0, axial_coefficient


def lambs_integral(slenderness):
    """alpha_0 = a b^2 int_0^inf dl / ((a^2 + l)^(3/2) (b^2 + l)), with a = 1 and b = d/L.

    With l = b^2 (e^s - 1) the integrand falls off at either end, however slender or flat the spheroid.
    """
    square = slenderness**2

    def integrand(s):
        return square * (1 + square * math.expm1(s)) ** -1.5

    knee = math.log1p(1 / square)
    parts = [quad(integrand, a, b, epsabs=0, epsrel=1e-12)[0] for a, b in ((0, knee), (knee, knee + 40))]
    return sum(parts)


@pytest.mark.parametrize("slenderness", [0.01, 0.05, 0.1, 1 / 6, 0.25, 0.5, 0.9, 0.96, 1.04, 1.1, 1.5, 2, 4, 10, 50])
def test_spheroids_follow_lambs_integral(slenderness):
    assert alpha_0(slenderness) == pytest.approx(lambs_integral(slenderness), rel=1e-10)


@pytest.mark.parametrize("deviation", [1e-9, 1e-6, 1e-4, 1e-3, 0.01, 0.02, 0.029])
@pytest.mark.parametrize("sign", [-1, 1])
def test_near_the_sphere_it_follows_lambs_integral(deviation, sign):
    slenderness = 1 + sign * deviation
    assert abs(1 - slenderness**2) < SERIES_BELOW, "the series is meant to be tried"
    assert alpha_0(slenderness) == pytest.approx(lambs_integral(slenderness), rel=1e-12)


@pytest.mark.parametrize("q", [SERIES_BELOW, -SERIES_BELOW])
def test_it_is_continuous_where_the_formula_switches(q):
    below, above = (alpha_0(math.sqrt(1 - q * (1 + step))) for step in (-1e-13, 1e-13))
    # The slope there is of order 1, so the step itself is worth about 1e-14.
    assert below == pytest.approx(above, rel=1e-11)


@pytest.mark.parametrize(("ratio", "k1"), [(2, 0.2100), (4, 0.0816), (6, 0.04518), (10, 0.0207)], ids="{}:1".format)
def test_published_axial_coefficients(ratio, k1):
    places = len(str(k1).rstrip("0").partition(".")[2])
    assert axial_coefficient(1 / ratio) == pytest.approx(k1, abs=0.51 * 10.0 ** -max(places, 4))


@pytest.mark.parametrize("slenderness", [0.0, -1.0, math.nan, math.inf])
def test_an_invalid_slenderness_is_refused(slenderness):
    with pytest.raises(ValueError, match="expected a positive number"):
        alpha_0(slenderness)
