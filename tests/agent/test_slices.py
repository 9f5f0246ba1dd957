"""Slices of solids of revolution against the solids themselves, and against quadrature."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from driftform.agent import solid_of_revolution
from driftform.agent.slices import slice_solid
from driftform.testing.bodies import mirrored_contour, spheroid_body

counts = st.integers(1, 40)
heights = st.one_of(st.just(0.0), st.floats(1e-6, 0.1))


@st.composite
def chains(draw):
    """Frusta end to end, with steps between them, at least 2 mm thick: (n, 2), without the axis points."""
    steps = draw(
        st.lists(st.tuples(heights, st.floats(0.002, 0.1)), min_size=2, max_size=10).filter(
            lambda steps: sum(h for h, _ in steps[1:]) > 0.01
        )
    )
    x = np.cumsum([h for h, _ in steps]) + draw(st.floats(-1, 1))
    return np.column_stack([x, [r for _, r in steps]])


def capped(chain):
    return np.array([(chain[0, 0], 0.0), *chain, (chain[-1, 0], 0.0)])


@st.composite
def cups(draw):
    """A chain that is hollowed out from its fore end: the contour folds back inside, and ends on the axis there."""
    chain = draw(chains())
    bottom = draw(st.floats(chain[0, 0] + 1e-3, chain[-1, 0] - 1e-3))
    shares = sorted(draw(st.lists(st.floats(0, 1), max_size=5)))
    x = [chain[-1, 0] + share * (bottom - chain[-1, 0]) for share in (0.0, *shares, 1.0)]
    radii = draw(st.lists(st.floats(1e-4, 0.0019), min_size=len(x), max_size=len(x)))
    return np.array([(chain[0, 0], 0.0), *chain, *zip(x, radii, strict=True), (bottom, 0.0)])


solids = st.one_of(chains().map(capped), cups(), cups().map(mirrored_contour))


@given(solids, counts)
def test_slices_have_the_volume_and_the_centroid_of_the_solid_together(contour, count):
    solid = solid_of_revolution(contour)
    x, volume, width = slice_solid(contour, count).T
    # Rounding is that of what lies aft of each cut, whose moments are taken about the frame's origin.
    largest = np.abs(contour[:, 0]).max()
    swept = np.pi * np.abs(np.diff(contour[:, 0])).sum() * contour[:, 1].max() ** 2
    assert (volume >= -1e-14 * swept).all()
    assert volume.sum() == pytest.approx(solid.volume, abs=1e-13 * swept)
    assert volume @ x == pytest.approx(solid.first, abs=1e-12 * swept * max(largest, 0.01))
    assert width == pytest.approx(np.full(count, np.ptp(contour[:, 0]) / count), rel=1e-9)


@given(solids, counts)
def test_every_centroid_lies_in_its_slice(contour, count):
    x, volume, width = slice_solid(contour, count).T
    edges = np.linspace(contour[:, 0].min(), contour[:, 0].max(), count + 1)
    # In a slice with next to no volume the centroid is all rounding.
    swept = np.pi * np.abs(np.diff(contour[:, 0])).sum() * contour[:, 1].max() ** 2
    kept = volume > 1e-9 * swept
    assert (x[kept] >= edges[:-1][kept] - 1e-3 * width[kept] - 1e-9).all()
    assert (x[kept] <= edges[1:][kept] + 1e-3 * width[kept] + 1e-9).all()


@given(chains(), st.integers(1, 6))
def test_each_slice_has_the_volume_and_the_centroid_of_quadrature(chain, count):
    nodes, weights = np.polynomial.legendre.leggauss(6)
    edges = np.linspace(chain[0, 0], chain[-1, 0], count + 1)

    def integral(power, a, b):
        total = 0.0
        for (x0, r0), (x1, r1) in pairwise(chain):
            low, high = max(a, x0), min(b, x1)
            if high > low:
                x = 0.5 * (low + high) + 0.5 * (high - low) * nodes
                r = np.interp(x, [x0, x1], [r0, r1])
                total += 0.5 * (high - low) * np.pi * weights @ (x**power * r**2)
        return total

    for (x, volume, _), (a, b) in zip(slice_solid(capped(chain), count), pairwise(edges), strict=True):
        assert volume == pytest.approx(integral(0, a, b), rel=1e-9)
        assert x * volume == pytest.approx(integral(1, a, b), abs=1e-9 * volume)


@given(st.lists(st.tuples(st.integers(-1000, 1000), st.floats(0, 0.5)), min_size=2, max_size=12), counts)
def test_even_a_contour_that_crosses_itself_loses_no_volume(points, count):
    contour = np.array([(points[0][0], 0.0), *points, (points[-1][0], 0.0)]) * [1e-3, 1.0]
    swept = np.pi * np.abs(np.diff(contour[:, 0])).sum() * 0.25
    volumes = slice_solid(contour, count)[:, 1]
    assert volumes.sum() == pytest.approx(solid_of_revolution(contour).volume, abs=1e-12 * (swept + 1e-12))


def test_the_empty_slices_of_a_dumbbell_stay_in_their_places():
    # A contour that runs along the axis between two balls has no volume there, and no centroid to speak of.
    ball = spheroid_body(0.01, 0.01, edges=16).outer
    contour = np.vstack([ball - np.array([0.1, 0]), ball + np.array([0.1, 0])])
    x, volume, _ = slice_solid(contour, 11).T
    assert volume[5] == pytest.approx(0, abs=1e-20)
    assert x[5] == pytest.approx(0.0, abs=1e-12)
    assert np.isfinite(x).all()
