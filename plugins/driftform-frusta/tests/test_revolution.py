"""Revolved profiles: closed surfaces, counted and oriented as manifold3d does it, and the vertices that it has."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from manifold3d import CrossSection, FillRule

from driftform.errors import WorkFailedError
from driftform_frusta.solid import revolve_profiles
from driftform_frusta.triangles import Mesh, area_factor

CYLINDER = [(0, 0), (5, 0), (5, 7), (0, 7)]
BALLS_IN_TOUCH = [(0, 0), (3, 2), (0, 4), (3, 6), (0, 8)]
RING = [(2, 0), (5, 0), (5, 7), (2, 7)]
SHELL = [(0, 0), (5, 0), (5, 7), (0, 7), (0, 6), (4, 6), (4, 1), (0, 1)]


def sweep(*profiles, segments=16):
    return revolve_profiles([np.array(profile, dtype=float) for profile in profiles], segments)


def by_manifold(polygons, segments):
    scaled = [polygon * (area_factor(segments), 1.0) for polygon in polygons]
    return CrossSection(scaled, FillRule.EvenOdd).revolve(segments)


@pytest.mark.parametrize("profile", [CYLINDER, BALLS_IN_TOUCH, RING, SHELL])
@pytest.mark.parametrize("start", range(4))
def test_a_mesh_is_closed_wherever_its_profile_begins(profile, start):
    solid = sweep(profile[start:] + profile[:start])
    assert Mesh(solid.vertices, solid.triangles).is_closed
    assert len(np.unique(solid.triangles)) == len(solid.vertices)
    assert solid.volume == pytest.approx(by_manifold([np.array(profile)], 16).volume(), rel=1e-6)


@pytest.mark.parametrize(
    ("profile", "shells"),
    [
        (CYLINDER, [175 * math.pi]),
        (RING, [147 * math.pi]),
        (BALLS_IN_TOUCH, [12 * math.pi] * 2),
        (SHELL, [175 * math.pi, -80 * math.pi]),
    ],
)
def test_shells_have_the_volumes_of_the_formulas_and_those_of_hollows_are_negative(profile, shells):
    solid = sweep(profile, segments=7)
    assert sorted(solid.shells) == pytest.approx(sorted(shells), rel=1e-12)
    assert solid.pieces == sum(volume > 0 for volume in shells)


def test_profiles_that_share_a_point_share_its_ring_to_the_last_bit():
    lower = sweep([(0, 0), (3.1, 0), (2.7, 1.3), (0, 1.3)])
    upper = sweep([(0, 1.3), (2.7, 1.3), (1.9, 4.2), (0, 4.2)])
    rims = [{tuple(v) for v in solid.vertices if v[2] == 1.3} for solid in (lower, upper)]
    assert rims[0] == rims[1] and len(rims[0]) == 17


@pytest.mark.parametrize("profiles", [[], [CYLINDER[::-1]], [[(0, 0), (0, 3), (0, 1)]]])
def test_profiles_that_hold_nothing_are_refused(profiles):
    with pytest.raises(WorkFailedError, match="empty or inside out"):
        sweep(*profiles)


@settings(max_examples=30, deadline=None)
@given(
    heights=st.lists(st.floats(0.1, 20), min_size=2, max_size=12),
    radii=st.lists(st.one_of(st.just(0.0), st.floats(0.1, 50)), min_size=13, max_size=13),
)
def test_manifold3d_finds_any_profile_closed_and_counts_the_same_shells(heights, radii):
    z = np.concatenate(([0.0], np.cumsum(heights)))
    line = np.column_stack((radii[: len(z)], z))
    if not line[:, 0].any():
        line[0, 0] = 1.0
    solid = revolve_profiles([np.concatenate((line, [(0.0, z[-1]), (0.0, 0.0)]))], 9)
    assert Mesh(solid.vertices, solid.triangles).is_closed
    again = solid.to_manifold()
    assert again.volume() == pytest.approx(solid.volume, rel=1e-9)
    assert sorted(shell.volume() for shell in again.decompose()) == pytest.approx(sorted(solid.shells), rel=1e-9)
