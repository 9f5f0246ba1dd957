"""The tree's values, and the hull as a tree."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from manifold3d import Manifold, OpType

from driftform.errors import WorkFailedError
from driftform_frusta.hull import build_hull
from driftform_frusta.solid import to_manifold
from driftform_frusta.triangles import area_factor


def test_the_printed_frame_is_in_mm_with_the_fore_end_up_and_the_lowest_point_at_zero(make_body):
    cone = make_body([(-0.02, 0), (-0.02, 0.03), (0.05, 0)])
    solid = to_manifold(build_hull(cone))
    bounds = solid.bounding_box()
    assert bounds[2] == 0
    assert bounds[5] == pytest.approx(70, rel=1e-9)
    assert bounds[3] == pytest.approx(30, rel=2e-3)
    # A cone's centroid is a quarter up from its base, which is the aft end here.
    assert solid.trim_by_plane((0, 0, 1), 35).volume() == pytest.approx(solid.volume() / 8, rel=1e-6)


@settings(max_examples=8, deadline=None)
@given(
    modules=st.lists(st.tuples(st.sampled_from([2.5e-3, 5e-3, 10e-3]), st.integers(-45, 45)), min_size=40, max_size=40)
)
def test_frustums_and_the_revolved_section_are_the_same_solid_for_any_chain(modules, make_chain):
    radii = [0.012]
    for length, tilt in modules:
        radii.append(max(0.004, radii[-1] + length * math.tan(math.radians(tilt))))
    assert_same_solid(make_chain([length for length, _ in modules], radii), segments=16)


def stack_frustums(contour, segments):
    """The inside of a contour as a union of cones of manifold3d, mm from the core's centre."""
    cones = [
        Manifold.cylinder(z1 - z0, *(area_factor(segments) * np.array([r0, r1])), segments).translate((0, 0, z0))
        for (z0, r0), (z1, r1) in pairwise((1e3 * contour).tolist())
        if z1 > z0 and r0 + r1 > 0
    ]
    return Manifold.batch_boolean(cones, OpType.Add)


def assert_same_solid(body, segments):
    revolved = to_manifold(build_hull(body), segments)
    frustums = stack_frustums(body.outer, segments) - stack_frustums(body.cavity, segments)
    frustums = frustums.translate((0, 0, -1e3 * body.outer[:, 0].min()))
    assert frustums.volume() == pytest.approx(revolved.volume(), rel=1e-6)
    assert np.allclose(frustums.bounding_box(), revolved.bounding_box(), atol=1e-6)
    difference = (frustums - revolved).volume() + (revolved - frustums).volume()
    assert difference < 1e-6 * revolved.volume()
    assert len(frustums.decompose()) == len(revolved.decompose())


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
def test_a_contour_that_encloses_nothing_is_refused(outer, cavity, why, make_body):
    with pytest.raises(WorkFailedError, match=why):
        build_hull(make_body(outer, cavity))
