"""Which surfaces of a body can touch a wall: domes are found in polylines, everything else is a rim."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from driftform.motion.forces.surfaces import find_hull, touching_surfaces
from driftform.study import load_study
from driftform.testing.bodies import cylinder_body, dome_body, make_body, spheroid_body

PIPELINE = load_study("paper").make_pipeline()


def rims(body):
    """Return the vertices of the convex hull that are off the axis."""
    hull = find_hull(body.outer)
    return hull[hull[:, 1] > 0.0]


@pytest.mark.parametrize("edges", [24, 72, 144])
def test_a_sphere_is_one_dome_however_finely_it_is_divided(edges):
    assert touching_surfaces(spheroid_body(0.01, 0.01, edges)) == pytest.approx(
        np.array([[0.0, 0.0, 0.01, -1.0, 1.0]]), abs=1e-12
    )


@pytest.mark.parametrize("decimals", [3, 4])
def test_a_sphere_from_a_table_of_few_digits_is_one_dome(decimals):
    x = np.linspace(0.0, 60.0, 41)
    table = np.column_stack([x, np.sqrt(x * (60.0 - x))]).round(decimals) * 1e-3
    [dome] = touching_surfaces(make_body(table - [0.03, 0.0]))
    assert dome == pytest.approx([0.0, 0.0, 0.03, -1.0, 1.0], abs=1e-6)


@pytest.mark.parametrize(("length", "edges"), [(0.0101, 72), (0.0101, 2000), (0.01, 10)])
def test_what_is_nearly_a_sphere_or_divided_coarsely_has_more_than_one_surface(length, edges):
    assert len(touching_surfaces(spheroid_body(length, 0.01, edges))) > 1


def test_a_half_sphere_is_a_dome_that_ends_in_a_rim():
    assert touching_surfaces(dome_body(0.02)) == pytest.approx(np.array([[0.0, 0.0, 0.02, -1.0, 0.0]]), abs=1e-12)


def test_only_vertices_of_the_convex_hull_can_touch():
    waist = make_body([(-0.1, 0), (-0.1, 0.03), (0.0, 0.01), (0.05, 0.025), (0.1, 0.03), (0.1, 0)])
    assert rims(waist) == pytest.approx(np.array([[-0.1, 0.03], [0.1, 0.03]]))
    assert touching_surfaces(waist)[:, :3] == pytest.approx(np.array([[-0.1, 0.03, 0], [0.1, 0.03, 0]]))
    cone = make_body([(-0.1, 0), (-0.1, 0.05), (0.1, 0)])
    assert rims(cone) == pytest.approx(np.array([[-0.1, 0.05]]))


def test_cylinders_and_spheroids_have_rims_only():
    assert not touching_surfaces(cylinder_body(0.1, 0.01))[:, 2:].any()
    spheroid = spheroid_body(0.06, 0.01, 24)
    assert touching_surfaces(spheroid)[:, :2] == pytest.approx(rims(spheroid))


@given(st.integers(0, 10**6))
def test_domes_and_rims_reach_as_far_as_the_contour_in_every_direction(seed):
    body = PIPELINE.make_agent(PIPELINE.grammar.random(np.random.default_rng(seed))).body
    angle = np.linspace(-np.pi / 2, np.pi / 2, 181)
    s, c = np.sin(angle), np.cos(angle)
    contour = (np.outer(s, body.outer[:, 0]) + np.outer(c, body.outer[:, 1])).max(axis=1)
    reach = np.full_like(s, -np.inf)
    for x, r, radius, aft, fore in touching_surfaces(body):
        here = np.clip(s, aft, fore) if radius else np.zeros_like(s)
        reach = np.maximum(
            reach, s * (x + radius * here) + c * (r + radius * np.sqrt(1 - here**2)) if radius else s * x + c * r
        )
    # A dome is larger than the polyline in it, by an eighth of its step squared: 2.4e-4 of its radius.
    assert (reach - contour).max() < 2.5e-4 * body.max_diameter / 2
    assert (reach - contour).min() > -1e-9
