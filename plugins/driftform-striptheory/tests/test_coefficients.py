"""Added mass of whole bodies against quadrature of the strips and closed forms."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

from driftform.motion.forces.inertia import added_mass_at
from driftform.testing.bodies import make_body
from driftform.water import Fluid
from driftform_striptheory.coefficients import StripTheory, StripTheoryOptions
from driftform_striptheory.ellipsoid import axial_coefficient

FLUID = Fluid(density=1024.0)
MODEL = StripTheory(StripTheoryOptions())


def random_chain(seed):
    """A capped chain of frustums, well off the origin."""
    rng = np.random.default_rng(seed)
    x = np.cumsum(rng.uniform(2e-3, 1e-2, 21)) - rng.uniform(0, 0.1)
    r = rng.uniform(5e-3, 3e-2, 21)
    return make_body([(x[0], 0), *zip(x, r, strict=True), (x[-1], 0)])


def strips(body, power):
    """rho pi times the integral of x^power r(x)^2 dx, edge by edge."""
    x, r = body.outer[1:-1].T
    parts = [
        quad(lambda s: s**power * np.interp(s, x, r) ** 2, a, b, epsabs=0, epsrel=1e-12)[0] for a, b in pairwise(x)
    ]
    return FLUID.density * np.pi * sum(parts)


@pytest.mark.parametrize("seed", range(5))
def test_lateral_added_mass_is_the_integral_of_the_strips(seed):
    body = random_chain(seed)
    matrix = added_mass_at(MODEL.coefficients(body, FLUID), np.zeros(3))
    m22, m26, m66 = (strips(body, power) for power in (0, 1, 2))
    assert matrix[1, 1] == pytest.approx(m22, rel=1e-9)
    assert matrix[2, 2] == pytest.approx(m22, rel=1e-9)
    assert matrix[1, 5] == pytest.approx(m26, rel=1e-9)
    assert matrix[2, 4] == pytest.approx(-m26, rel=1e-9)
    assert matrix[4, 4] == pytest.approx(m66, rel=1e-9)
    assert matrix[5, 5] == pytest.approx(m66, rel=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_off_diagonals_vanish_about_the_centre_of_buoyancy(seed):
    body = random_chain(seed)
    coefficients = MODEL.coefficients(body, FLUID)
    centroid = strips(body, 1) / strips(body, 0)
    np.testing.assert_allclose(coefficients.origin, [centroid, 0, 0], rtol=1e-9)
    assert abs(centroid) > 1e-3, "about the origin itself there would be nothing to see"
    matrix = coefficients.added_mass
    assert (matrix == np.diag(np.diag(matrix))).all()
    assert abs(added_mass_at(coefficients, np.zeros(3))[1, 5]) > 1e-3 * matrix[1, 1] * body.length


@pytest.mark.parametrize("seed", range(5))
def test_axial_added_mass_is_that_of_the_equivalent_ellipsoid(seed):
    body = random_chain(seed)
    length, diameter = np.ptp(body.outer[:, 0]), 2 * body.outer[:, 1].max()
    k11 = axial_coefficient(diameter / length)
    ellipsoid = FLUID.density * np.pi / 6 * length * diameter**2
    assert MODEL.coefficients(body, FLUID).added_mass[0, 0] == pytest.approx(k11 * ellipsoid, rel=1e-12)
    volume = StripTheory(StripTheoryOptions(m11="volume")).coefficients(body, FLUID)
    assert volume.added_mass[0, 0] == pytest.approx(k11 * strips(body, 0), rel=1e-9)
    np.testing.assert_array_equal(volume.added_mass[1:, 1:], MODEL.coefficients(body, FLUID).added_mass[1:, 1:])


def test_roll_moves_no_water_and_nothing_is_damped():
    coefficients = MODEL.coefficients(random_chain(0), FLUID)
    assert not coefficients.added_mass[3].any()
    assert not coefficients.linear_damping.any()
    assert not coefficients.quadratic_damping.any()
