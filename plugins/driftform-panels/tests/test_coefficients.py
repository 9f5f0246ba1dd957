"""The model as a plugin: what it returns for bodies. And, with the paper's model, what it returns for degenerate ones."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from driftform.agent import solid_of_revolution
from driftform.testing.bodies import make_body
from driftform.types import Module, Morphology
from driftform.water import Fluid
from driftform_frusta.builder import FrustaBuilder, FrustaOptions
from driftform_panels.solve import PanelMethod, PanelOptions
from driftform_striptheory.coefficients import StripTheory, StripTheoryOptions

FLUID = Fluid(density=1024.0)
MODEL = PanelMethod(PanelOptions())
BUILDER = FrustaBuilder(FrustaOptions())

both_models = pytest.mark.parametrize("model", [MODEL, StripTheory(StripTheoryOptions())], ids=lambda model: model.name)

modules = st.lists(
    st.builds(
        Module,
        length=st.sampled_from([2.5e-3, 5e-3, 1e-2]),
        tilt=st.one_of(st.sampled_from(np.deg2rad([-20, -10, 0, 10, 20]).tolist()), st.floats(-1.39, 1.39)),
    ),
    max_size=20,
).map(tuple)
morphologies = st.builds(Morphology, fore=modules, aft=modules)


def assert_physical(model, body):
    """Symmetric, positive semi-definite, axisymmetric, with a mass that is moved in every direction."""
    matrix = model.coefficients(body, FLUID).added_mass
    size = np.array([1.0, 1.0, 1.0, *[1 / body.max_diameter] * 3])
    scaled = matrix * np.outer(size, size)
    assert np.isfinite(matrix).all()
    np.testing.assert_array_equal(matrix, matrix.T)
    assert np.linalg.eigvalsh(scaled).min() >= -1e-12 * np.abs(scaled).max()
    assert matrix[1, 1] == matrix[2, 2] > 0
    assert matrix[4, 4] == matrix[5, 5] >= 0
    assert matrix[2, 4] == -matrix[1, 5]
    assert matrix[0, 0] > 0
    return matrix


def test_coefficients_are_about_the_centre_of_buoyancy_without_damping():
    body = make_body([(0.02, 0), (0.02, 0.03), (0.12, 0)])
    coefficients = MODEL.coefficients(body, FLUID)
    np.testing.assert_allclose(coefficients.origin, [solid_of_revolution(body.outer).centroid, 0, 0])
    assert not coefficients.linear_damping.any()
    assert not coefficients.quadratic_damping.any()
    assert not coefficients.added_mass[3].any()


@both_models
@given(morphology=morphologies)
def test_any_body_has_physical_coefficients(model, morphology):
    assert_physical(model, BUILDER.build(morphology))


def test_a_nearly_straight_body_is_not_smoothed():
    """Kinks of six degrees and of four are treated alike: A11 and A22 vary evenly with the tilt."""
    found = []
    for tilt in (1.8, 2.2, 2.4, 2.6, 2.8, 3.2):
        pair = (Module(1e-2, float(np.deg2rad(tilt))), Module(1e-2, -float(np.deg2rad(tilt))))
        body = BUILDER.build(Morphology(fore=pair * 10))
        found.append(np.diag(MODEL.coefficients(body, FLUID).added_mass)[[0, 1, 5]])
    change = np.diff(np.log(found), axis=0) / np.diff([1.8, 2.2, 2.4, 2.6, 2.8, 3.2])[:, None]
    assert np.abs(change - change.mean(axis=0)).max() < 5e-3
