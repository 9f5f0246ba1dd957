"""The tree's values, and the hull as a tree."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from driftform.errors import WorkFailedError
from driftform_frusta.csg import (
    Box,
    Difference,
    Frustum,
    Intersection,
    Named,
    Revolve,
    Rotate,
    Sphere,
    Translate,
    Union,
)
from driftform_frusta.hull import build_hull, build_hull_of_frustums
from driftform_frusta.solid import to_manifold

TRIANGLE = ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))


@pytest.mark.parametrize(
    "make",
    [
        lambda: Frustum(0, 1, 1),
        lambda: Frustum(-1, 1, 1),
        lambda: Frustum(math.inf, 1, 1),
        lambda: Frustum(1, -1, 1),
        lambda: Frustum(1, 0, 0),
        lambda: Frustum(1, math.nan, 1),
        lambda: Sphere(0),
        lambda: Sphere(math.nan),
        lambda: Box((1, 0, 1)),
        lambda: Revolve(TRIANGLE[:2]),
        lambda: Revolve(TRIANGLE, (TRIANGLE[:2],)),
        lambda: Revolve(((0, 0), (-1, 0), (0, 1))),
        lambda: Revolve(((0, 0), (math.inf, 0), (0, 1))),
        lambda: Union(()),
        lambda: Intersection(()),
        lambda: Translate((0, 0, math.nan), Sphere(1)),
        lambda: Rotate((math.inf, 0, 0), Sphere(1)),
    ],
)
def test_numbers_that_describe_no_solid_are_refused(make):
    with pytest.raises(ValueError, match=r"must|needs"):
        make()


def test_trees_are_plain_values_that_compare_and_hash():
    def tree():
        return Named("ball in a box", Difference(Box((4, 4, 4)), (Translate((2, 2, 2), Sphere(1)),)))

    assert tree() == tree()
    assert len({tree(), tree()}) == 1
    with pytest.raises(dataclasses.FrozenInstanceError):
        tree().label = "other"


@pytest.mark.parametrize("route", [build_hull, build_hull_of_frustums])
def test_the_printed_frame_is_in_mm_with_the_fore_end_up_and_the_lowest_point_at_zero(route, make_body):
    cone = make_body([(-0.02, 0), (-0.02, 0.03), (0.05, 0)])
    solid = to_manifold(route(cone))
    bounds = solid.bounding_box()
    assert bounds[2] == 0
    assert bounds[5] == pytest.approx(70, rel=1e-9)
    assert bounds[3] == pytest.approx(30, rel=2e-3)
    # A cone's centroid is a quarter up from its base, which is the aft end here.
    assert solid.trim_by_plane((0, 0, 1), 35).volume() == pytest.approx(solid.volume() / 8, rel=1e-6)


def test_frustums_and_the_revolved_section_are_the_same_solid(body):
    assert_same_solid(body, segments=64)


@settings(max_examples=8, deadline=None)
@given(
    modules=st.lists(
        st.tuples(st.sampled_from([2.5e-3, 5e-3, 10e-3]), st.integers(-45, 45)), min_size=40, max_size=40
    )
)
def test_frustums_and_the_revolved_section_are_the_same_solid_for_any_chain(modules, make_chain):
    radii = [0.012]
    for length, tilt in modules:
        radii.append(max(0.004, radii[-1] + length * math.tan(math.radians(tilt))))
    assert_same_solid(make_chain([length for length, _ in modules], radii), segments=16)


def assert_same_solid(body, segments):
    revolved = to_manifold(build_hull(body), segments)
    frustums = to_manifold(build_hull_of_frustums(body), segments)
    assert frustums.volume() == pytest.approx(revolved.volume(), rel=1e-6)
    assert np.allclose(frustums.bounding_box(), revolved.bounding_box(), atol=1e-6)
    difference = (frustums - revolved).volume() + (revolved - frustums).volume()
    assert difference < 1e-6 * revolved.volume()
    assert len(frustums.decompose()) == len(revolved.decompose())


def test_faces_normal_to_the_axis_need_no_frustum(make_body):
    stepped = make_body([(-0.05, 0), (-0.05, 0.01), (0, 0.01), (0, 0.03), (0.05, 0.03), (0.05, 0)])
    outside = build_hull_of_frustums(stepped).child
    assert outside == Named(
        "outside",
        Union((Translate((0, 0, 0), Frustum(50, 10, 10)), Translate((0, 0, 50), Frustum(50, 30, 30)))),
    )


@pytest.mark.parametrize("route", [build_hull, build_hull_of_frustums])
@pytest.mark.parametrize(
    ("outer", "cavity", "why"),
    [
        ([(-1, 0), (-1, 1), (1, 1)], (), "outer contour does not begin and end on the axis"),
        ([(-1, 0), (1, 0)], (), "outer contour has 2 points"),
        ([(-1, 0), (0, 0), (1, 0)], (), "outer contour never leaves the axis"),
        ([(-1, 0), (0, math.nan), (1, 0)], (), "outer contour has coordinates that are not finite"),
        ([(-1, 0), (0, 1), (1, 0)], [(-0.5, 0.1), (0, 0.2), (0.5, 0)], "cavity does not begin and end"),
    ],
)
def test_a_contour_that_encloses_nothing_is_refused(route, outer, cavity, why, make_body):
    with pytest.raises(WorkFailedError, match=why):
        route(make_body(outer, cavity))


def test_a_contour_that_folds_back_is_no_chain_of_frustums(make_body):
    folded = make_body([(-1, 0), (-1, 1), (1, 1), (1, 2), (0, 2), (2, 3), (2, 0)])
    with pytest.raises(WorkFailedError, match="folds back"):
        build_hull_of_frustums(folded)
