"""The force law of a contact, against matrices, gradients, and a collision that is integrated apart from it."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from driftform.motion.forces.bore import smoothed_sine
from driftform.motion.forces.impact import DEEPEST, STIFF_DEPTH, common_mass, contact_law, damper, spring

OMEGA, VISCOSITY, RADIUS = 300.0, 1.05e-3, 0.015

# A body whose centre is ahead of its origin, with more added mass across than along; a roll changes nothing.
TOTAL = np.diag([0.4, 0.6, 0.6, 1e-4, 9e-4, 9e-4])
TOTAL[1, 5] = TOTAL[5, 1] = 4e-3
TOTAL[2, 4] = TOTAL[4, 2] = -4e-3
INVERSE = np.linalg.inv(TOTAL)


def law_of(restitution=0.7, viscosity=VISCOSITY, inverse=INVERSE, frequency=OMEGA):
    return contact_law(inverse, frequency, restitution, viscosity, RADIUS)


@pytest.mark.parametrize("s", [-0.95, -0.4, 0.0, 0.3, 0.8])
@pytest.mark.parametrize(("x", "r"), [(0.06, 0.012), (-0.05, 0.02), (0.03, 0.0)])
def test_a_push_at_a_rim_moves_the_mass_of_the_whole_matrix(s, x, r):
    """1 / (J M^-1 J'), with the normal in the plane of the body's x and z axes, and the rim's point that is farthest along it."""
    c = math.sqrt(1 - s * s)
    normal, point = np.array([s, 0.0, c]), np.array([x, 0.0, r])
    row = np.concatenate([normal, np.cross(point, normal)])
    mass, energy, force, _ = spring(s, x, r, 1e-7, law_of()[0])
    assert mass == pytest.approx(1 / (row @ INVERSE @ row), rel=1e-4)
    assert energy == pytest.approx(mass * OMEGA**2 * 1e-14, rel=1e-9)
    assert force == pytest.approx(mass * OMEGA**2 * 1e-7, rel=1e-9)


@pytest.mark.parametrize("depth", [1e-6, 1.5e-4, 4e-4, 0.999e-3, 1.001e-3, 3e-3])
@pytest.mark.parametrize("s", [-0.7, 0.0, 0.2, 0.6])
def test_forces_and_moments_are_half_of_the_derivatives_of_twice_the_energy(depth, s):
    law = law_of()[0]
    _, _, force, turning = spring(s, 0.06, 0.012, depth, law)
    h, a = 1e-6 * depth, 1e-6
    along = [spring(s, 0.06, 0.012, depth + d * h, law)[1] for d in (1, -1)]
    assert force == pytest.approx((along[0] - along[1]) / (4 * h), rel=1e-5)
    turned = [spring(math.sin(math.asin(s) + d * a), 0.06, 0.012, depth, law)[1] for d in (1, -1)]
    size = force * 0.06
    assert turning == pytest.approx((turned[0] - turned[1]) / (4 * a), rel=1e-4, abs=1e-6 * size)


@pytest.mark.parametrize("share", [0.25, 1.0, 2.0, 4.9])
def test_a_spring_stiffens_with_the_fourth_power_of_its_depth(share):
    law, depth = law_of()[0], share * STIFF_DEPTH
    mass, energy, force, _ = spring(0.0, 0.0, 0.01, depth, law)
    assert mass == pytest.approx(1 / INVERSE[2, 2], rel=1e-9)
    assert energy == pytest.approx(mass * OMEGA**2 * depth**2 * (1 + share**4 / 3), rel=1e-9)
    assert force == pytest.approx(mass * OMEGA**2 * depth * (1 + share**4), rel=1e-9)
    assert pytest.approx(2e-4) == STIFF_DEPTH


def test_beyond_its_deepest_a_spring_weakens_with_the_square_of_the_depth():
    law = law_of()[0]
    at = [spring(0.1, 0.06, 0.012, DEEPEST * (1 + e), law) for e in (-1e-9, 1e-9)]
    assert at[1] == pytest.approx(at[0], rel=1e-7)
    for times in (2.0, 10.0):
        assert spring(0.1, 0.06, 0.012, times * DEEPEST, law)[2] == pytest.approx(at[1][2] / times**2, rel=1e-7)
    assert pytest.approx(1e-3) == DEEPEST


def test_a_body_that_nothing_moves_has_an_infinite_mass_and_no_spring():
    assert spring(0.3, 0.05, 0.01, 1e-4, law_of(inverse=np.zeros((6, 6)))[0]) == (math.inf, 0.0, 0.0, 0.0)
    assert law_of(inverse=np.zeros((6, 6)))["greatest_mass"][0] == math.inf


def test_an_axis_along_the_normal_needs_no_root_of_a_negative_number():
    mass, *rest = spring(1.0 + 1e-15, 0.05, 0.0, 1e-4, law_of()[0])
    assert mass == pytest.approx(1 / INVERSE[0, 0], rel=1e-9)
    assert np.isfinite(rest).all()
    assert smoothed_sine(1.0) > 0.0


def test_the_law_of_a_body_is_that_of_its_matrix_and_water():
    law = law_of(0.8)[0]
    # The two directions across the axis are averaged.
    uneven = INVERSE.copy()
    uneven[2, 2], uneven[4, 4], uneven[2, 4] = 0.5 * INVERSE[1, 1], 3.0 * INVERSE[5, 5], 0.0
    other = law_of(0.8, inverse=uneven)[0]
    assert other["lateral"] == pytest.approx(0.75 * law["lateral"])
    assert other["turning"] == pytest.approx(2.0 * law["turning"])
    assert other["coupling"] == pytest.approx(0.5 * law["coupling"])
    assert law["axial"] == INVERSE[0, 0]
    assert law["greatest_mass"] == pytest.approx(max(1 / INVERSE[0, 0], 1 / INVERSE[1, 1]))
    assert law["frequency"] == OMEGA
    assert math.exp(-law["dry_loss"]) == pytest.approx(0.8)
    # 35 / St for St = m v / (6 pi mu R^2) is this over m v, but for the root of e_dry that damper() states.
    stokes_by_speed = 1.0 / (6 * math.pi * VISCOSITY * RADIUS**2)
    assert law["wet_loss"] == pytest.approx(35 * math.sqrt(0.8) / stokes_by_speed, rel=1e-12)


def test_springs_that_press_together_move_at_most_what_a_central_push_does():
    law = law_of()[0]
    most = law["greatest_mass"]
    # One spring of force f gives power f^2 / m.
    assert common_mass(3.0, 9.0 / 0.2, law) == pytest.approx(0.2)
    assert common_mass(3.0, 9.0 / (2 * most), law) == most
    assert common_mass(3.0, 0.0, law) == most


def collide(law, mass, speed):
    """Speed after a collision over that before: m dw/dt = -k d f(q, w), integrated with the spring of a shallow depth."""

    def rate(_, state):
        depth, w = state
        return [w, -(OMEGA**2) * depth * damper(OMEGA**2 * depth**2, w, mass, law)]

    def leaves(_, state):
        return state[0]

    leaves.terminal, leaves.direction = True, -1
    end = solve_ivp(rate, (0, 0.2), [1e-9 * speed, speed], events=leaves, rtol=1e-9, atol=1e-15).y[1, -1]
    return -end / speed


@pytest.mark.parametrize("restitution", [0.2, 0.5, 0.8, 1.0])
@pytest.mark.parametrize("speed", [0.01, 1.0])
def test_a_dry_collision_returns_the_restitution_whatever_its_speed(restitution, speed):
    assert collide(law_of(restitution, viscosity=0.0)[0], 0.3, speed) == pytest.approx(restitution, abs=0.006)


@pytest.mark.parametrize("restitution", [0.6, 0.97])
@pytest.mark.parametrize("stokes", [25, 60, 200, 2000])
def test_a_wet_collision_returns_what_legendre_measured(restitution, stokes):
    mass, speed = 0.3, 0.2
    viscosity = mass * speed / (6 * math.pi * RADIUS**2 * stokes)
    expected = restitution * math.exp(-35 / stokes)
    found = collide(law_of(restitution, viscosity)[0], mass, speed)
    assert found == pytest.approx(expected, abs=0.025)
