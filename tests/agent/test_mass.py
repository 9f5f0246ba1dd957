"""Mass properties of whole bodies against hand-worked assemblies."""

from dataclasses import replace

import numpy as np
import pytest

from driftform.agent import hull_mass, mass_properties
from driftform.agent.mass import hull_moments
from driftform.types import Body, Core, Fittings, Moments


def capsule(core_mass=0.05, shift=0.0, density=1050.0):
    """A capped tube, 100 mm long, 15 mm in radius, wall 2 mm, its middle at ``shift`` from the core."""
    a, b, r, t = shift - 0.05, shift + 0.05, 0.015, 0.002
    outer = [(a, 0), (a, r), (b, r), (b, 0)]
    cavity = [(a + t, 0), (a + t, r - t), (b - t, r - t), (b - t, 0)]
    return Body(np.array(outer), np.array(cavity), np.array([a, 0.0, b]), Core(0.01, core_mass), t, density)


def test_a_capped_tube_weighs_its_wall_its_caps_and_its_core():
    wall = np.pi * (0.015**2 - 0.013**2) * 0.096
    caps = 2 * np.pi * 0.015**2 * 0.002
    assert hull_moments(capsule()).volume == pytest.approx(wall + caps, rel=1e-12)
    assert hull_mass(capsule()) == pytest.approx(1050 * (wall + caps), rel=1e-12)
    assert mass_properties(capsule()).mass == pytest.approx(1050 * (wall + caps) + 0.05, rel=1e-12)


def test_buoyancy_acts_at_the_centroid_of_what_the_outer_contour_encloses():
    properties = mass_properties(capsule(shift=0.02))
    assert properties.volume == pytest.approx(np.pi * 0.015**2 * 0.1, rel=1e-12)
    assert properties.cob == pytest.approx([0.02, 0, 0], abs=1e-15)


def test_the_centre_of_gravity_is_the_weighted_mean_of_hull_and_core():
    body = capsule(shift=0.02)
    hull = hull_mass(body)
    assert mass_properties(body).cog == pytest.approx([0.02 * hull / (hull + 0.05), 0, 0], rel=1e-12)


def test_inertia_about_the_cog_is_that_of_tube_caps_and_core_by_steiners_theorem():
    body = capsule(shift=0.02)
    properties = mass_properties(body)

    def cylinder(r, h):
        m = 1050 * np.pi * r**2 * h
        return m, m * r**2 / 2, m * (3 * r**2 + h**2) / 12

    (mo, axial_o, across_o), (mi, axial_i, across_i) = cylinder(0.015, 0.1), cylinder(0.013, 0.096)
    core = 0.4 * 0.05 * 0.01**2
    hull, x = mo - mi, properties.cog[0]
    axial = axial_o - axial_i + core
    across = across_o - across_i + hull * (0.02 - x) ** 2 + core + 0.05 * x**2
    assert properties.inertia == pytest.approx(np.diag([axial, across, across]), rel=1e-10)


def test_a_core_off_the_origin_moves_the_centre_and_turns_with_its_parallel_axis():
    centred, moved = (
        mass_properties(replace(capsule(shift=0.02), core=Core(0.01, 0.05, cog=at))) for at in (0.0, 0.004)
    )
    assert moved.mass * moved.cog[0] - centred.mass * centred.cog[0] == pytest.approx(0.05 * 0.004, rel=1e-9)
    about_origin = [found.inertia[1, 1] + found.mass * found.cog[0] ** 2 for found in (centred, moved)]
    assert about_origin[1] - about_origin[0] == pytest.approx(0.05 * 0.004**2, rel=1e-6)


def test_fittings_weigh_with_the_hull_at_their_place():
    volume, x = 3e-6, 0.03
    ring = Moments(volume, volume * x, volume * x * x + 1e-10, 2e-10)
    bare, fitted = capsule(), replace(capsule(), fittings=Fittings(ring))
    assert hull_mass(fitted) == pytest.approx(hull_mass(bare) + 1050 * volume, rel=1e-12)
    assert mass_properties(fitted).cog[0] == pytest.approx(1050 * volume * x / mass_properties(fitted).mass, rel=1e-9)


def test_a_body_and_its_mirror_image_have_mirrored_centres_and_the_same_inertia():
    there, back = mass_properties(capsule(shift=0.013)), mass_properties(capsule(shift=-0.013))
    assert there.cog == pytest.approx(-back.cog, abs=1e-15)
    assert there.cob == pytest.approx(-back.cob, abs=1e-15)
    assert there.inertia == pytest.approx(back.inertia, rel=1e-12)
