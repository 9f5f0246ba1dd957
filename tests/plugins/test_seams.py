"""What a value must be to cross a seam: the limits, where a quick check must decide as a slow one."""

import numpy as np
import pytest

from driftform.errors import WorkFailedError
from driftform.plugins.seams import require_coefficients
from driftform.study import load_study
from driftform.testing.bodies import spheroid_body
from driftform.types import Coefficients

BODY = spheroid_body(0.5, 0.1)


def cross_seam(added_mass):
    model = load_study("paper").make_pipeline().hydrodynamics
    return require_coefficients(Coefficients(added_mass), BODY, model)


def make_diagonal(turning):
    return np.diag([1.0, 2.0, 2.0, 0.0, 0.5, turning])


def make_coupled(coupling):
    """An added mass whose least eigenvalue has the sign of 1 - coupling^2."""
    matrix = make_diagonal(0.5)
    matrix[1, 5] = matrix[5, 1] = coupling
    matrix[2, 4] = matrix[4, 2] = -coupling
    return matrix


@pytest.mark.parametrize("matrix", [make_diagonal(0.0), make_diagonal(-1e-8), make_coupled(0.999), np.eye(6) * 1e200])
def test_an_added_mass_may_be_semidefinite_within_rounding(matrix):
    np.testing.assert_array_equal(cross_seam(matrix).added_mass, matrix)


@pytest.mark.parametrize("matrix", [make_diagonal(-1e-4), make_coupled(1.001), np.triu(make_coupled(0.5))])
def test_an_added_mass_with_a_negative_energy_or_without_symmetry_is_refused(matrix):
    with pytest.raises(WorkFailedError, match="not symmetric and positive semi-definite"):
        cross_seam(matrix)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_an_added_mass_that_is_not_finite_is_refused(value):
    with pytest.raises(WorkFailedError, match="added_mass that is not finite"):
        cross_seam(make_diagonal(value))
