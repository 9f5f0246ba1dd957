"""Distances from a meridian polyline, against its points."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from driftform.agent.distance import distance_from

MILLIMETRES = st.tuples(st.integers(-200, 200), st.integers(0, 100))


@given(st.lists(MILLIMETRES, min_size=2, max_size=6, unique=True), MILLIMETRES)
def test_the_distance_from_a_polyline_is_that_of_its_nearest_point(corners, place):
    contour, point, share = 1e-3 * np.array(corners), 1e-3 * np.array(place), np.linspace(0, 1, 401)[:, None]
    points = np.concatenate([a + share * (b - a) for a, b in pairwise(contour)])
    nearest = np.linalg.norm(points - point, axis=1).min()
    assert distance_from(point[None], contour) == pytest.approx([nearest], abs=6e-4)
