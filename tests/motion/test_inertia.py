"""6x6 matrices: rigid bodies, the shift of their origin, and their inverse."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from driftform.motion.forces.inertia import added_mass_at, cross_matrix, rigid_body_mass, shift_origin
from driftform.motion.forces.inverse import invert_mass
from driftform.types import Coefficients, MassProperties

points = st.tuples(*[st.floats(-1, 1)] * 3).map(np.array)


def particles(seed, count=5):
    rng = np.random.default_rng(seed)
    return rng.uniform(0.1, 1, count), rng.normal(size=(count, 3))


def mass_of(masses, places):
    """Mass properties of point masses, summed up one by one."""
    total = masses.sum()
    cog = masses @ places / total
    inertia = sum(m * (r @ r * np.eye(3) - np.outer(r, r)) for m, r in zip(masses, places - cog, strict=True))
    return MassProperties(total, cog, inertia, 0.0, cog)


@given(st.integers(0, 1000), points, points)
def test_kinetic_energy_is_that_of_the_particles(seed, v, w):
    masses, places = particles(seed)
    matrix = rigid_body_mass(mass_of(masses, places))
    nu = np.concatenate([v, w])
    speeds = v + np.cross(w, places)
    assert nu @ matrix @ nu / 2 == pytest.approx((masses * (speeds**2).sum(axis=1)).sum() / 2, rel=1e-10)


@given(st.integers(0, 1000), points)
def test_moving_the_origin_gives_the_matrix_that_the_moved_particles_have(seed, offset):
    masses, places = particles(seed)
    here = rigid_body_mass(mass_of(masses, places))
    there = rigid_body_mass(mass_of(masses, places - offset))
    assert shift_origin(here, offset) == pytest.approx(there, rel=1e-9, abs=1e-12)


def test_added_mass_of_a_forward_centre_couples_heave_with_pitch_and_sway_with_yaw():
    # About a point 0.1 m aft of the centre: v_centre = v + w x (0.1, 0, 0), so M26 = 0.1 M22 and M35 = -0.1 M33.
    coefficients = Coefficients(np.diag([1.0, 2, 2, 0, 3, 3]), origin=np.array([0.1, 0, 0]))
    matrix = added_mass_at(coefficients, np.zeros(3))
    assert matrix[1, 5] == pytest.approx(0.2)
    assert matrix[2, 4] == pytest.approx(-0.2)
    assert matrix[4, 4] == pytest.approx(3 + 2 * 0.1**2)


@given(points, points)
def test_the_cross_matrix_is_a_cross_product(a, b):
    assert cross_matrix(a) @ b == pytest.approx(np.cross(a, b), abs=1e-15)


@given(st.integers(0, 1000), points, st.floats(1e-3, 1e3))
def test_the_inverse_of_a_mass_gives_the_acceleration_that_a_force_causes(seed, offset, length):
    masses, places = particles(seed)
    matrix = shift_origin(rigid_body_mass(mass_of(masses, length * places)), length * offset)
    accelerations = np.diag(np.arange(1.0, 7.0)) / np.repeat([1.0, length], 3)
    assert invert_mass(matrix, length) @ matrix @ accelerations == pytest.approx(
        accelerations, abs=1e-9 * np.abs(accelerations).max()
    )


@pytest.mark.parametrize("inertia", [0.0, 1e-30])
def test_a_direction_without_inertia_is_not_accelerated(inertia):
    inverse = invert_mass(np.diag([2.0, 4.0, 4.0, inertia, 0.1, 0.1]), 0.3)
    assert inverse == pytest.approx(np.diag([0.5, 0.25, 0.25, 0.0, 10.0, 10.0]))


def test_a_thin_hull_has_the_inverse_that_its_small_inertia_asks_for():
    # Below the limit at which eigenvalues are asked for, and above the one below which there is no inertia.
    inverse = invert_mass(np.diag([2.0, 4.0, 4.0, 1e-11, 0.1, 0.1]), 1.0)
    assert np.diag(inverse) == pytest.approx([0.5, 0.25, 0.25, 1e11, 10.0, 10.0])


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_mass_that_is_not_finite_has_no_inverse(value):
    matrix = np.eye(6)
    matrix[5, 5] = value
    assert np.isnan(invert_mass(matrix, 1.0)).all()
