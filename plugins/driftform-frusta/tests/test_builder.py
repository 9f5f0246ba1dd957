"""Bodies from modules: the section, its wall, and the mesh of the same body."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from driftform.agent import hull_mass, solid_of_revolution
from driftform.types import Module, Morphology
from driftform_frusta.builder import FrustaBuilder, FrustaOptions
from driftform_frusta.hull import hull_volume

WALL, DOME = 0.00125, 0.01145
modules = st.builds(
    Module, st.sampled_from([0.0025, 0.005, 0.01]), st.sampled_from([-20, -10, 0, 10, 20]).map(np.deg2rad)
)
sides = st.lists(modules, max_size=20).map(tuple)
morphologies = st.builds(Morphology, sides, sides)


def build(morphology, **options):
    return FrustaBuilder(FrustaOptions(**options)).build(morphology)


def cylinder(fore, aft=0):
    return Morphology(fore=(Module(0.01, 0.0),) * fore, aft=(Module(0.01, 0.0),) * aft)


def distance_to_polyline(points, line):
    """Distance of each point from a polyline: by projection on every edge."""
    a, b = line[:-1], line[1:]
    edge = b - a
    square = np.maximum((edge**2).sum(axis=1), 1e-300)
    along = np.clip(((points[:, None] - a) * edge).sum(axis=2) / square, 0, 1)
    foot = a + along[..., None] * edge
    return np.linalg.norm(points[:, None] - foot, axis=2).min(axis=1)


def test_a_bare_core_is_a_dome_all_around():
    body = build(Morphology())
    assert body.length == pytest.approx(2 * DOME, rel=1e-9)
    assert body.max_diameter == pytest.approx(2 * DOME, rel=1e-9)
    # Revolved, an inscribed polygon of step s lacks s^2 / 4 of the sphere's volume: 4.8e-4 at 2.5 degrees.
    sphere = 4 / 3 * np.pi * DOME**3
    lack = 1 - solid_of_revolution(body.outer).volume / sphere
    assert lack == pytest.approx(np.deg2rad(2.5) ** 2 / 4, rel=1e-3)


def test_untilted_modules_make_a_capped_tube():
    body = build(cylinder(5, 5))
    outer = np.pi * DOME**2 * 0.1
    cavity = np.pi * (DOME - WALL) ** 2 * (0.1 - 2 * WALL)
    assert solid_of_revolution(body.outer).volume == pytest.approx(outer, rel=1e-7)
    assert hull_volume(body) == pytest.approx(outer - cavity, rel=1e-6)


def test_a_one_sided_agent_is_closed_by_the_dome():
    body = build(cylinder(5))
    half_dome = 2 / 3 * np.pi * DOME**3
    assert solid_of_revolution(body.outer).volume == pytest.approx(np.pi * DOME**2 * 0.05 + half_dome, rel=2e-4)
    assert body.outer[0] == pytest.approx([-DOME, 0], abs=1e-9)


def test_the_paper_s_figure_2_word_narrows_twice_and_widens_once():
    aft = (Module(0.005, np.deg2rad(-10)), Module(0.0025, np.deg2rad(-20)), Module(0.01, np.deg2rad(10)))
    body = build(Morphology(aft=aft))
    x = -np.cumsum([0.005 * np.cos(np.deg2rad(10)), 0.0025 * np.cos(np.deg2rad(20)), 0.01 * np.cos(np.deg2rad(10))])
    r = DOME + np.cumsum(
        [-0.005 * np.sin(np.deg2rad(10)), -0.0025 * np.sin(np.deg2rad(20)), 0.01 * np.sin(np.deg2rad(10))]
    )
    assert body.joints == pytest.approx([*x[::-1], 0], abs=1e-12)
    assert body.outer[1] == pytest.approx([x[-1], r[-1]], abs=1e-8)


def test_the_radius_stops_at_its_least_and_the_module_keeps_its_axial_length():
    tilt = np.deg2rad(-20)
    body = build(Morphology(fore=(Module(0.01, tilt),) * 6))
    assert body.outer[-1, 0] == pytest.approx(6 * 0.01 * np.cos(tilt), abs=1e-8)
    assert body.outer[-2, 1] == pytest.approx(0.0025 + WALL / 2, abs=1e-8)


@settings(max_examples=60, deadline=None)
@given(morphologies)
def test_the_wall_is_nowhere_thinner_than_asked(morphology):
    body = build(morphology)
    assert distance_to_polyline(body.cavity, body.outer).min() >= WALL - 1e-7


@settings(max_examples=60, deadline=None)
@given(morphologies)
def test_away_from_the_mitres_the_wall_is_just_as_thick_as_asked(morphology):
    body = build(morphology)
    edges = np.diff(body.cavity, axis=0)
    along = np.concatenate([[0], np.cumsum(np.linalg.norm(edges, axis=1))])
    stations = np.linspace(0, along[-1], 500)
    points = np.column_stack([np.interp(stations, along, body.cavity[:, i]) for i in range(2)])
    thickness = distance_to_polyline(points, body.outer)
    # A mitre at a turn of 40 degrees is 1 / cos(20 deg) = 1.064 walls deep, and short.
    assert np.median(thickness) == pytest.approx(WALL, rel=1e-3)
    assert np.quantile(thickness, 0.9) <= 1.07 * WALL


def test_the_paper_s_wall_has_the_mass_of_eq_18s_frusta_and_weightless_ends():
    body = build(Morphology(fore=(Module(0.01, np.deg2rad(10)),) * 3), wall_model="paper")
    radial = WALL / np.cos(np.deg2rad(10))
    h = 0.03 * np.cos(np.deg2rad(10))
    mid = DOME - radial / 2 + np.array([0, 0.03 * np.sin(np.deg2rad(10))])
    tube = 2 * np.pi * radial * h * mid.mean()
    half_dome = 2 / 3 * np.pi * (DOME**3 - (DOME - WALL) ** 3)
    assert hull_mass(body) == pytest.approx(1050 * (tube + half_dome), rel=2e-3)


@pytest.mark.parametrize(("length", "tilt"), [(0.0, 0.0), (float("nan"), 0.0), (0.01, np.pi / 2), (0.01, 2.0)])
def test_a_module_that_cannot_be_built_is_named(length, tilt):
    sound = Module(0.01, 0.1)
    with pytest.raises(ValueError, match="module 2 aft of the core cannot be built: it is"):
        FrustaBuilder(FrustaOptions()).build(Morphology((sound,), (sound, Module(length, tilt), sound)))
