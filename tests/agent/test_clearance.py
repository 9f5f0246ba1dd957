"""Extents of a body against densely sampled surfaces."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from driftform.agent.clearance import farthest_from_line, lowest_along

unit = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1)
place = st.tuples(*[st.floats(-0.5, 0.5)] * 3)
contour = st.lists(st.tuples(st.floats(-0.2, 0.2), st.floats(0, 0.1)), min_size=2, max_size=6)


def surface(outer, position, axis, count):
    """Return points on the circles of a contour, world frame, m, (n, 3)."""
    aside = np.cross(axis, [1.0, 0, 0] if abs(axis[0]) < 0.8 else [0, 1.0, 0])
    aside /= np.linalg.norm(aside)
    angles = np.linspace(0, 2 * np.pi, count, endpoint=False)[:, None, None]
    around = np.cos(angles) * aside + np.sin(angles) * np.cross(axis, aside)
    return (position + outer[:, :1] * axis + outer[:, 1:] * around).reshape(-1, 3)


@given(contour, place, unit, place, unit)
def test_the_farthest_point_from_a_line_is_that_of_the_sampled_surface(points, position, axis, start, line):
    outer, position, start = (np.array(v, dtype=float) for v in (points, position, start))
    axis, line = (np.array(v) / np.linalg.norm(v) for v in (axis, line))
    off = surface(outer, position, axis, 720) - start
    sampled = np.linalg.norm(off - (off @ line)[:, None] * line, axis=1).max()
    exact = farthest_from_line(outer, position, axis, start, line)
    # A sampled circle misses its farthest point by less than half a step.
    assert sampled - 1e-9 <= exact <= sampled + 0.1 * (np.pi / 720) ** 2 * 2 + 1e-9


@given(contour, place, unit, unit)
def test_the_lowest_point_is_that_of_the_sampled_surface(points, position, axis, direction):
    outer, position = np.array(points), np.array(position)
    axis, direction = (np.array(v) / np.linalg.norm(v) for v in (axis, direction))
    sampled = (surface(outer, position, axis, 720) @ direction).min()
    assert sampled - 1e-5 <= lowest_along(outer, position, axis, direction) <= sampled + 1e-9


@pytest.mark.parametrize("pitch", [0, 20, 45, 90])
def test_a_cylinder_on_the_axis_needs_the_room_of_its_diagonal(pitch):
    """Half the length L and the radius r reach L/2 sin + r cos, seen from the side, with the corner on the plane."""
    half, r, angle = 0.1, 0.02, np.deg2rad(pitch)
    outer = np.array([[-half, 0], [-half, r], [half, r], [half, 0]])
    axis = np.array([np.cos(angle), 0, -np.sin(angle)])
    reach = farthest_from_line(outer, np.zeros(3), axis, np.zeros(3), np.array([1.0, 0, 0]))
    corner = half * np.sin(angle) + r * np.cos(angle)
    # Beyond some tilt the farthest point of the end's circle is not its corner in the plane any more.
    assert reach == pytest.approx(max(corner, np.hypot(half * np.sin(angle), r) if pitch == 90 else 0), rel=1e-12)


def test_a_body_beside_the_line_by_less_than_rounding_is_as_far_as_one_on_it():
    axis = np.array([1.0, 1e-3, 0.0]) / np.hypot(1.0, 1e-3)
    disc, line = np.array([[0.0, 0.1], [0.0, 0.05]]), (np.zeros(3), np.array([1.0, 0.0, 0.0]))
    near = [farthest_from_line(disc, np.array([0.0, 0.0, z]), axis, *line) for z in (0.0, 1e-19)]
    assert near == pytest.approx([0.1, 0.1], abs=1e-6)
