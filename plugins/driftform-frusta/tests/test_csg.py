"""The tree's values, and the hull as a tree."""

import math

import pytest

from driftform.errors import WorkFailedError
from driftform_frusta.hull import build_hull
from driftform_frusta.solid import to_manifold


def test_the_printed_frame_is_in_mm_with_the_fore_end_up_and_the_lowest_point_at_zero(make_body):
    cone = make_body([(-0.02, 0), (-0.02, 0.03), (0.05, 0)])
    solid = to_manifold(build_hull(cone))
    bounds = solid.bounding_box()
    assert bounds[2] == 0
    assert bounds[5] == pytest.approx(70, rel=1e-9)
    assert bounds[3] == pytest.approx(30, rel=2e-3)
    # A cone's centroid is a quarter up from its base, which is the aft end here.
    assert solid.trim_by_plane((0, 0, 1), 35).volume() == pytest.approx(solid.volume() / 8, rel=1e-6)


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
