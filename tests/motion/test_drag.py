"""Drag of strips and along the axis, against published coefficients, closed forms, and the sign of its work."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from driftform.motion.forces.drag import axial_drag, shear_lift, still_water_wrench, strip_drag
from driftform.motion.forces.drag_coefficients import (
    blockage_factor,
    crossflow_drag,
    friction_coefficient,
    sphere_excess,
    spin_coefficient,
)
from driftform.motion.forces.equations import drag_wrench
from driftform.motion.forces.model import flight_model
from driftform.testing.agents import Spheroid
from driftform.types import Drag
from driftform.water import Fluid, Scenario

RHO, NU = 1024.0, 1.05e-6
STILL = (0.0, 0.0, 0.0)

speeds = st.tuples(*[st.floats(-3, 3)] * 3)
rates = st.tuples(*[st.floats(-30, 30)] * 3)
turns = st.tuples(*[st.floats(-3, 3)] * 3)


def chain(length, diameter, count, factor=1.0, middle=0.0):
    """Equal strips of a cylinder about ``middle``."""
    width = length / count
    x = middle + width * (np.arange(count) + 0.5) - length / 2
    return np.column_stack([x, np.full(count, diameter), np.full(count, width), np.full(count, factor)])


FULL = Drag(
    chain(0.12, 0.03, 9, middle=0.02),
    friction_area=0.012,
    length=0.12,
    ahead=1e-4,
    astern=5e-4,
    round_area=2e-4,
    diameter=0.03,
    centre=0.02,
    wake_ahead=(-0.04, 3e-4),
    wake_astern=(0.08, 5e-4),
    spin=1e-8,
    creeping=(0.3, 0.4, 6e-4, 0.1),
    rubbing=1.5,
)


def model_of(drag, level=None):
    agent = Spheroid(0.06, 0.02).agent()
    agent = replace(agent, coefficients=replace(agent.coefficients, drag=drag))
    return flight_model(agent, Scenario(fluid=Fluid(density=RHO, viscosity=NU, water_level=level)))


def wrench_on(drag, moving=STILL, omega=STILL, R=None, height=0.0, level=None, shear=STILL, bore=math.inf):
    R = np.eye(3) if R is None else R
    rows = tuple(tuple(row) for row in R.tolist())
    return np.concatenate(drag_wrench(height, rows, moving, omega, shear, model_of(drag, level), bore))


# Coefficients.


@pytest.mark.parametrize(
    ("coefficient", "known", "within"),
    [
        # Wieselsberger's cylinders, read to the tenth, and the plateau of DNV-RP-C205 from 1e4 on. At Re of about 1e3 the
        # flow about a cylinder without ends has a drag of 1.0, which bodies do not have.
        (
            lambda re: crossflow_drag(re, 1.0) / re,
            [(1e2, 1.4), (1e4, 1.1), (1e4, 1.208), (3.6e4, 1.211), (1e5, 1.2)],
            0.10,
        ),
        # Lapple and Shepherd's standard drag curve, as in Perry's Handbook.
        (
            lambda re: 24 / re + sphere_excess(re),
            [(0.1, 244), (1, 26.5), (10, 4.1), (100, 1.07), (1e3, 0.46), (1e4, 0.405), (1e5, 0.48)],
            0.06,
        ),
        # 4 / Re where the friction is laminar, from the torque 4 pi mu omega r^2 of each metre.
        (spin_coefficient, [(10, 0.4)], 0.08),
        # Blasius; Prandtl and Schlichting with the transition at 5e5: 0.455 / (log10 Re)^2.58 - 1700 / Re.
        (friction_coefficient, [(1e4, 0.01328), (1e5, 0.0042), (4.9e5, 0.001897)], 1e-3),
        (friction_coefficient, [(1e7, 0.00283), (1e8, 0.00211), (1e9, 0.00157)], 0.03),
    ],
)
def test_coefficients_are_those_that_were_measured(coefficient, known, within):
    for reynolds, c in known:
        assert coefficient(reynolds) == pytest.approx(c, rel=within)


@pytest.mark.parametrize("reynolds", [1e3, 3e3, 1e4, 1e5, 1e6])
def test_a_spinning_cylinder_has_the_friction_of_theodorsen_and_regier(reynolds):
    root = math.sqrt(spin_coefficient(reynolds))
    assert 1 / root == pytest.approx(-0.6 + 4.07 * math.log10(reynolds * root), rel=0.012)


# The whole body.


@given(speeds, rates)
def test_the_force_on_many_strips_is_their_sum_at_their_places(moving, omega):
    strips = chain(0.12, 0.03, 5, factor=0.7, middle=0.02)
    forces = [strip_drag(moving, omega, STILL, 0.0, (RHO, NU, 1.0), strip) for strip in strips]
    torques = [np.cross([strip[0], 0, 0], force) for strip, force in zip(strips, forces, strict=True)]
    expected = np.concatenate([np.sum(forces, axis=0), np.sum(torques, axis=0)])
    assert wrench_on(Drag(strips), moving, omega) == pytest.approx(expected, rel=1e-9, abs=1e-12)


def test_a_spinning_chain_of_strips_has_the_moment_of_the_integral():
    # dM = 1/2 rho d C_d (r x)^2 x dx over both halves.
    length, d, r = 0.3, 0.02, 7.0
    x = (np.arange(20_000) + 0.5) * length / 40_000
    coefficients = np.array([crossflow_drag(r * a, NU / d) / (r * a) for a in x])
    moment = RHO * d * r**2 * float(coefficients @ x**3) * length / 40_000
    for axis, spin in ((5, (0.0, 0.0, r)), (4, (0.0, r, 0.0))):
        wrench = wrench_on(Drag(chain(length, d, 400)), omega=spin)
        assert wrench[axis] == pytest.approx(-moment, rel=2e-5)
        assert np.delete(wrench, axis) == pytest.approx(np.zeros(5), abs=1e-12)


@given(speeds, rates, turns, st.sampled_from([None, 0.0, 0.01, -0.02]))
def test_drag_never_does_work_on_a_body_in_still_water(moving, omega, turn, level):
    R = Rotation.from_rotvec(turn).as_matrix()
    wrench = wrench_on(FULL, moving, omega, R, level=level)
    power = wrench @ [*moving, *omega]
    assert power <= 1e-12 * np.abs(wrench).max()


@given(speeds, rates, turns, st.floats(-0.1, 0.1))
def test_drag_is_that_of_the_part_under_water(moving, omega, turn, level):
    drag = Drag(chain(0.12, 0.03, 9), friction_area=0.012, length=0.12, ahead=1e-4, astern=5e-4)
    R = Rotation.from_rotvec(turn).as_matrix()
    deep = wrench_on(drag, moving, omega, R)
    part = wrench_on(drag, moving, omega, R, level=level)
    assert 0 <= part[0] * np.sign(deep[0]) <= abs(deep[0])
    # The body of 120 mm reaches 62 mm from its middle.
    assert wrench_on(drag, moving, omega, R, level=0.07) == pytest.approx(deep, rel=1e-12, abs=1e-15)
    assert wrench_on(drag, moving, omega, R, level=-0.07) == pytest.approx(np.zeros(6), abs=0)


@pytest.mark.parametrize("speed", [5e-324, 1e-310, 1e-160, 1e-20])
def test_a_body_that_has_all_but_stopped_feels_all_but_nothing(speed):
    drag = Drag(chain(0.12, 0.03, 9), friction_area=0.012, length=0.12, ahead=1e-4, astern=5e-4)
    for moving in ((speed, 0.0, 0.0), (-speed, 0.0, 0.0), (0.0, speed, 0.0)):
        assert wrench_on(drag, moving) == pytest.approx(np.zeros(6), abs=1e-20)


# Along the axis.

AXIAL = np.array([0.012, 0.12, 1e-4, 5e-4, 0.0, 0.0])


def test_axial_drag_is_friction_and_the_blunt_end_that_goes_first():
    for speed, area in ((0.5, 1e-4), (-0.5, 5e-4)):
        c = 1.328 / math.sqrt(0.5 * 0.12 / NU)
        expected = 0.5 * RHO * (c * 0.012 + area) * 0.25
        assert axial_drag(speed, RHO, NU, AXIAL) == pytest.approx(-math.copysign(expected, speed), rel=1e-9)
    assert axial_drag(0.0, RHO, NU, AXIAL) == 0.0


@pytest.mark.parametrize(("level", "share"), [(None, 1.0), (0.0, 0.5), (-1.0, 0.0)])
def test_a_body_may_have_drag_along_its_axis_alone(level, share):
    drag = Drag(np.empty((0, 4)), friction_area=0.012, length=0.12, ahead=1e-4, astern=5e-4)
    force = axial_drag(0.7, RHO, NU, AXIAL) * share
    wrench = wrench_on(drag, (0.7, 0.2, 0.0), (0.0, 0.0, 1.0), level=level)
    assert wrench == pytest.approx([force, 0, 0, 0, 0, 0], rel=1e-12)
    assert model_of(drag).strips.size > 0, "the equations and the check of the energy ask for strips"


# The tail, the spin, the shear and the bore.


@pytest.mark.parametrize("alpha_deg", [5, 20, 45, 70, 90])
def test_the_normal_force_on_a_flat_ended_cylinder_is_jorgensens_sum_and_nothing_counts_twice(alpha_deg):
    """C_N S_b = S_b sin 2a cos(a/2) + C_dn A_p sin^2 a (NASA TN D-6996, eq. 1), with k = 1 and a given C_dn."""
    length, d, alpha, speed = 0.3, 0.03, math.radians(alpha_deg), 1.2
    base = math.pi * d**2 / 4
    drag = Drag(chain(length, d, 20), wake_ahead=(-length / 2, base), wake_astern=(length / 2, base))
    moving = (speed * math.cos(alpha), 0.0, speed * math.sin(alpha))
    C_dn = crossflow_drag(speed * math.sin(alpha), NU / d) / (speed * math.sin(alpha))
    expected = base * math.sin(2 * alpha) * math.cos(alpha / 2) + C_dn * d * length * math.sin(alpha) ** 2
    assert -wrench_on(drag, moving)[2] == pytest.approx(0.5 * RHO * speed**2 * expected, rel=1e-6)


def test_the_ends_of_a_body_that_moves_astern_are_exchanged():
    ahead, astern = (wrench_on(FULL, (u, 0.0, 0.3)) for u in (0.5, -0.5))
    without = replace(FULL, wake_ahead=(0.0, 0.0), wake_astern=(0.0, 0.0))
    lifts = [w - wrench_on(without, (u, 0.0, 0.3)) for w, u in ((ahead, 0.5), (astern, -0.5))]
    assert lifts[0][4] == pytest.approx(0.04 * lifts[0][2])
    assert lifts[1][4] == pytest.approx(-0.08 * lifts[1][2])
    assert lifts[1][2] == pytest.approx(5 / 3 * lifts[0][2])


def test_a_body_that_lags_behind_the_water_is_lifted_to_where_it_is_faster():
    # u = S z along x, and the body is slower: (u - v) x curl u / 2 = (U, 0, 0) x (0, S, 0) / 2.
    lift = shear_lift((-0.3, 0.0, 0.0), (0.0, 4.0, 0.0), 0.5 * RHO * 1e-4, 0.01)
    assert lift == pytest.approx((0.0, 0.0, 0.5 * RHO * 1e-4 * 0.3 * 4.0), rel=1e-3)


def test_a_slip_that_is_smaller_than_the_difference_over_the_body_does_not_lift_it():
    curl, mass = (0.0, 10.0, 0.0), 0.5 * RHO * 1e-4
    for slip in (1e-2, 1e-3, 0.0):
        assert abs(shear_lift((-slip, 0.0, 0.0), curl, mass, 0.05)[2]) <= 2e-3 * mass * slip * 10.0


@given(speeds, rates)
def test_in_a_narrow_bore_all_drag_grows_alike(moving, omega):
    drag = replace(FULL, wake_ahead=(0.0, 0.0), wake_astern=(0.0, 0.0), spin=0.0, blocking=0.03)
    free, narrow = wrench_on(drag, moving, omega), wrench_on(drag, moving, omega, bore=0.03)
    assert narrow == pytest.approx(blockage_factor(0.5) * free, rel=1e-9, abs=1e-15)


@given(speeds, rates)
def test_the_wrench_in_still_open_water_is_that_of_the_equations(moving, omega):
    assert still_water_wrench(FULL, moving, omega, RHO, NU) == pytest.approx(
        wrench_on(FULL, moving, omega), rel=1e-9, abs=1e-12
    )


@pytest.mark.parametrize("factor", [0.6, 1.3])
@pytest.mark.parametrize(
    "motion", [((0.4, 0, 0), (0, 0, 0)), ((-0.4, 0, 0), (0, 0, 0)), ((0, 0, 0.3), (0, 0, 0)), ((0, 0, 0), (5.0, 0, 0))]
)
def test_scaled_drag_resists_every_motion_by_that_factor(factor, motion):
    drag = replace(FULL, wake_ahead=(0.0, 0.0), wake_astern=(0.0, 0.0))
    once = still_water_wrench(drag, *motion, RHO, NU)
    scaled = still_water_wrench(drag.scale(factor), *motion, RHO, NU)
    assert np.abs(once).max() > 0
    assert scaled == pytest.approx(factor * once, rel=1e-12)
