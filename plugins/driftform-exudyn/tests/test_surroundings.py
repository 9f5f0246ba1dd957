"""The pipe of a film, as cylinders that are cut open towards the viewer."""

import numpy as np
import pytest

from driftform.study import load_study
from driftform.water import Scenario
from driftform_exudyn.surroundings import list_bores, upright_axes


@pytest.fixture(scope="module")
def junction():
    return load_study("t-junction").scenario


def test_a_straight_pipe_is_one_cylinder_with_distances():
    scenario = load_study("paper").scenario
    [bore] = list_bores(scenario.pipe, upright_axes(scenario)[2])
    assert (bore.length, bore.radius) == (9.0, 1.0)


def test_the_cylinders_of_a_junction_follow_its_parts(junction):
    bores = list_bores(junction.pipe, upright_axes(junction)[2])
    assert {round(bore.radius, 9) for bore in bores} == {0.05, 0.1}
    for bore in bores:
        points = bore.point(np.linspace(0.1, 0.9, 5) * bore.length, 0.5 * bore.radius, np.pi / 2)
        assert (junction.pipe.layout.find_part(points) >= 0).all()
    ends = np.array([bore.start + bore.length * bore.axes[0] for bore in bores])
    for outlet in junction.pipe.layout.outlets:
        assert np.linalg.norm(ends - outlet.opening.centre, axis=1).min() < 1e-9


def test_the_view_shows_both_legs_of_the_main(junction):
    """None of its bores runs towards the viewer."""
    viewer = upright_axes(junction)[2]
    assert max(abs(float(bore.axes[0] @ viewer)) for bore in list_bores(junction.pipe, viewer)) < 0.95


def test_a_bore_that_runs_towards_the_viewer_shows_its_lower_half():
    scenario = Scenario.model_validate({"pipe": {"segments": [{"start": (0, 0, 0), "end": (0, 2, 0), "radius": 0.5}]}})
    [bore] = list_bores(scenario.pipe, np.array([0.0, -1.0, 0.0]))
    np.testing.assert_allclose(bore.axes[2], [0, 0, -1], atol=1e-12)
    np.testing.assert_allclose(bore.axes @ bore.axes.T, np.eye(3), atol=1e-12)
