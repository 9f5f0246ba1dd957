"""Unions and inward offsets of contours, compared with the clipping of manifold3d and with closed forms."""

import math
from itertools import pairwise

import manifold3d
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from driftform.types import Module
from driftform_frusta.envelope import SIMPLIFY, offset_inward, unite_contours
from driftform_frusta.section import hull_section, lay_chains

MM = 1e3
WALL, DOME = 0.00125, 0.01145

steep_modules = st.builds(Module, st.floats(0.1, 30).map(lambda mm: mm / MM), st.floats(-88, 88).map(math.radians))
sides = st.lists(steep_modules, max_size=12)
chains = st.builds(lambda fore, aft: lay_chains(fore, aft, DOME, 0.003125), sides, sides)
# The dome, the wall, and the contour: a wall much thicker than the core may cut the cavity into parts.
walls = st.sampled_from([(DOME, WALL, 0.003125), (0.0062, 0.005, 0.0101), (0.0062, 0.005, 0.0225)])
walled = st.builds(lambda w, fore, aft: (*w[:2], lay_chains(fore, aft, w[0], w[2])), walls, sides, sides)


def contours(least):
    """Contours over x = 0, with heights from ``least`` to 5."""
    heights = st.lists(st.floats(least, 5), min_size=3, max_size=12)
    return heights.map(lambda r: np.column_stack([np.linspace(-1 - 0.1 * len(r), 2, len(r)), r]))


def height(contour, x):
    inside = (contour[0, 0] <= x) & (x <= contour[-1, 0])
    return np.where(inside, np.interp(x, *contour.T), 0.0)


def area(contour):
    x, r = contour.T
    return np.sum(np.diff(x) * (r[:-1] + r[1:]) / 2)


def section(*polygons):
    """What lies in any of these polygons, whatever their sense."""
    whole = manifold3d.CrossSection()
    for polygon in polygons:
        whole += manifold3d.CrossSection([MM * np.asarray(polygon)], manifold3d.FillRule.NonZero)
    return whole


def wall_pieces(outer, wall):
    """The strip along each edge, and the mitre at each corner that turns away from the axis, as polygons."""
    steps = np.diff(outer, axis=0)
    along = steps / np.linalg.norm(steps, axis=1, keepdims=True)
    inward = np.column_stack([along[:, 1], -along[:, 0]])
    for (a, b), n in zip(pairwise(outer), wall * inward, strict=True):
        yield a, b, b + n, a + n
    for corner, u, v, p, q in zip(outer[1:-1], along, along[1:], inward, inward[1:], strict=False):
        if u[0] * v[1] - u[1] * v[0] > 0:
            bisector = (p + q) / np.linalg.norm(p + q)
            reach = 1 / (bisector @ p)
            if reach <= 2:
                tips = [reach * bisector]
            else:
                # Cut off where the component along the bisector is one wall.
                tips = [p + u * (1 - p @ bisector) / (u @ bisector), q + v * (1 - q @ bisector) / (v @ bisector)]
            yield corner, *(corner + wall * np.array([p, *tips, q]))


@settings(max_examples=200, deadline=None)
@given(contours(0.1), contours(-5))
def test_a_union_is_as_high_as_the_higher_contour(first, second):
    united = unite_contours(first, second)
    corners = np.concatenate([first[:, 0], second[:, 0]])
    x = np.linspace(united[0, 0], united[-1, 0], 301)[1:-1]
    # At an end of a contour the union has a step.
    x = x[np.abs(x[:, None] - corners).min(axis=1) > 1e-3]
    expected = np.maximum(height(first, x), height(second, x))
    steepest = np.abs(np.concatenate([np.diff(c[:, 1]) / np.diff(c[:, 0]) for c in (first, second)])).max()
    assert height(united, x) == pytest.approx(expected, abs=SIMPLIFY * (2 + steepest))


@settings(max_examples=200, deadline=None)
@given(chains)
def test_an_outline_is_the_union_that_clipping_finds_however_steep_the_modules(contour):
    outer, _ = hull_section(contour, DOME, WALL)
    angles = np.deg2rad(np.arange(0, 181, 2.5))
    disc = DOME * np.column_stack([np.cos(angles), np.sin(angles)])
    closed = np.vstack([contour, [[contour[-1, 0], 0], [contour[0, 0], 0]]])
    assert area(outer) == pytest.approx(section(closed, disc).area() / MM**2, rel=1e-5)


@settings(max_examples=200, deadline=None)
@given(walled)
def test_a_cavity_is_what_no_piece_of_wall_covers(made):
    dome, wall, contour = made
    outer, cavity = hull_section(contour, dome, wall)
    angles = np.deg2rad(np.arange(0, 181, 2.5))
    room = (dome - wall / math.cos(math.radians(1.25))) * np.column_stack([np.cos(angles), np.sin(angles)])
    left = section(outer) - section(*wall_pieces(outer, wall)) + section(room)
    upper = left ^ manifold3d.CrossSection.square((2e4, 1e4)).translate((-1e4, 0))
    [found] = [part.area() for part in upper.decompose() if part.bounds()[0] < 0 < part.bounds()[2]]
    assert area(cavity) == pytest.approx(found / MM**2, rel=1e-5)


@pytest.mark.parametrize(("tilt", "depth"), [(30, 1 / math.cos(math.radians(30))), (59, 1.9416), (61, 1), (80, 1)])
def test_a_mitre_is_cut_off_at_one_wall_if_it_is_longer_than_two(tilt, depth):
    slope = math.tan(math.radians(tilt))
    notch = np.array([[-0.1, 0], [-0.1, 1 + 0.1 * slope], [0, 1], [0.1, 1 + 0.1 * slope], [0.1, 0]])
    offset = offset_inward(notch, 0.01)
    assert 1 - np.interp(0, *offset.T) == pytest.approx(0.01 * depth, rel=1e-4)


@pytest.mark.parametrize("twice", range(5))
def test_a_point_that_a_contour_has_twice_has_no_edge(twice):
    contour = np.array([[-1.0, 0], [-0.5, 1], [0, 0.8], [0.5, 1], [1, 0]])
    expected = offset_inward(contour, 0.1)
    np.testing.assert_array_equal(offset_inward(np.insert(contour, twice, contour[twice], axis=0), 0.1), expected)


def test_a_contour_that_does_not_cover_the_core_gives_no_union():
    beside = np.array([[0.1, 1.0], [0.2, 1.0]])
    assert len(unite_contours(beside, beside)) == 0


@pytest.mark.parametrize(("width", "is_open"), [(1e-17, False), (1e-3, True)])
def test_a_slit_is_closed_if_it_is_no_wider_than_a_rounding_error(width, is_open):
    slit = np.array([[-1.0, 1], [-width, 1], [-width, 0.5], [width, 0.5], [width, 1], [1, 1]])
    low = np.array([[-1.0, 0.1], [1.0, 0.1]])
    ends, inside = [[-1, 0], [-1, 1]], slit[1:5].tolist() if is_open else []
    np.testing.assert_allclose(unite_contours(slit, low), [*ends, *inside, [1, 1], [1, 0]], atol=1e-12)
