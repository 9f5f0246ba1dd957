"""Drag of strips and along the axis, against published coefficients, closed forms, and the sign of its work."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from driftform.dynamics.drag import axial_drag, strip_drag
from driftform.dynamics.equations import drag_wrench
from driftform.dynamics.model import flight_model
from driftform.hydrodynamics.drag_coefficients import (
    LAMINAR_BELOW,
    crossflow_coefficient,
    friction_coefficient,
)
from driftform.scenario import Fluid, Scenario
from driftform.testing.agents import Spheroid
from driftform.types import Drag

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


def model_of(drag, level=None):
    agent = Spheroid(0.06, 0.02).agent()
    agent = replace(agent, coefficients=replace(agent.coefficients, drag=drag))
    return flight_model(agent, Scenario(fluid=Fluid(density=RHO, viscosity=NU, water_level=level)))


def wrench_on(drag, moving=STILL, omega=STILL, R=None, height=0.0, level=None, shear=STILL):
    R = np.eye(3) if R is None else R
    rows = tuple(tuple(row) for row in R.tolist())
    return np.concatenate(drag_wrench(height, rows, moving, omega, shear, model_of(drag, level)))


# Coefficients.


@pytest.mark.parametrize(
    # White's fit and the curve that it was fitted to (Wieselsberger's cylinders), read to the tenth.
    ("reynolds", "fit", "measured"),
    [(1.0, 11.0, 10.0), (10.0, 3.154, 2.8), (100.0, 1.464, 1.4), (1e3, 1.1, 1.0), (1e4, 1.0215, 1.1)],
)
def test_a_long_cylinder_has_the_drag_that_was_measured(reynolds, fit, measured):
    assert crossflow_coefficient(reynolds) == pytest.approx(fit, rel=5e-4)
    assert crossflow_coefficient(reynolds) == pytest.approx(measured, rel=0.15)


def test_the_drag_coefficient_falls_towards_one_and_is_infinite_at_rest():
    values = [crossflow_coefficient(10.0**k) for k in range(-3, 9)]
    assert values == sorted(values, reverse=True)
    assert values[-1] == pytest.approx(1.0, abs=1e-4)
    assert crossflow_coefficient(0.0) == math.inf


@pytest.mark.parametrize(("reynolds", "c"), [(1e4, 0.01328), (1e5, 0.0042), (4.9e5, 0.001897)])
def test_laminar_friction_is_that_of_blasius(reynolds, c):
    assert friction_coefficient(reynolds) == pytest.approx(c, rel=1e-3)


@pytest.mark.parametrize(
    ("reynolds", "line", "prandtl"),
    # ITTC 1957: 3.000, 2.083 and 1.531 thousandths. Prandtl and Schlichting, with the transition at 5e5:
    # 0.455 / (log10 Re)^2.58 - 1700 / Re.
    [(1e7, 0.003, 0.00283), (1e8, 0.002083, 0.00211), (1e9, 0.001531, 0.00157)],
)
def test_turbulent_friction_is_the_ittc_line_less_what_the_laminar_part_saves(reynolds, line, prandtl):
    c, ittc = friction_coefficient(reynolds), 0.075 / (math.log10(reynolds) - 2) ** 2
    assert ittc == pytest.approx(line, abs=1e-6)
    assert (ittc - c) * reynolds == pytest.approx(1700, rel=0.1)
    assert c == pytest.approx(prandtl, rel=0.03)


def test_friction_does_not_jump_where_the_layer_becomes_turbulent():
    below, above = (friction_coefficient(LAMINAR_BELOW * (1 + s)) for s in (-1e-9, 1e-9))
    assert above == pytest.approx(below, rel=1e-8)
    assert friction_coefficient(LAMINAR_BELOW) == pytest.approx(1.328 / math.sqrt(5e5), rel=1e-12)
    assert friction_coefficient(0.0) == math.inf


@given(st.floats(1, 9).map(lambda e: 10**e), st.floats(1.001, 2))
def test_more_speed_is_more_friction(reynolds, more):
    # The force is C_f Re^2 times what does not depend on the speed.
    assert (
        friction_coefficient(more * reynolds) * (more * reynolds) ** 2
        > friction_coefficient(reynolds) * reynolds**2
    )


# One strip.


def test_a_strip_has_the_force_worked_out_by_hand():
    # At x = 0.1, 20 mm thick and 5 mm wide, of a body that moves with (0.5, 0.3, -0.1) and turns with (2, 3, -1):
    # across the axis 0.3 + 0.1 (-1) = 0.2 and -0.1 - 0.1 x 3 = -0.4 m/s. Re = 0.4472 x 0.02 / 1.05e-6 = 8518.4,
    # C_d = 1 + 10 / 417.1 = 1.02397; 0.7 of it is 0.71678. Half of it is under water.
    # F = 512 x 0.71678 x 0.02 x 0.005 x 0.4472 x 0.5 = 0.0082063 N s/m times the velocity.
    force = strip_drag(
        (0.5, 0.3, -0.1), (2.0, 3.0, -1.0), STILL, 0.0, (RHO, NU, 0.5), np.array([0.1, 0.02, 0.005, 0.7])
    )
    assert force == pytest.approx((0.0, -0.0082063 * 0.2, 0.0082063 * 0.4), rel=2e-4)


def test_a_strip_in_shear_meets_the_water_that_is_there():
    # The water at the strip moves 0.03 m further ahead of where ``moving`` is relative to: 5 x 0.03 more.
    strip, there = np.array([0.05, 0.02, 0.01, 1.0]), (RHO, NU, 1.0)
    sheared = strip_drag((0.0, 0.4, 0.2), STILL, (9.0, 5.0, -2.0), 0.02, there, strip)
    moved = strip_drag((0.0, 0.4 - 0.15, 0.2 + 0.06), STILL, STILL, 0.02, there, strip)
    assert sheared == pytest.approx(moved, rel=1e-12)
    assert strip_drag((1.0, 0.15, -0.06), STILL, (9.0, 5.0, -2.0), 0.02, there, strip)[0] == 0.0


def test_a_strip_at_rest_in_the_water_feels_nothing():
    assert strip_drag((3.0, 0.0, 0.0), (5.0, 0.0, 0.0), STILL, 0.0, (RHO, NU, 1.0), np.ones(4)) == STILL


@given(st.floats(1e-9, 1e-3))
def test_a_strip_that_creeps_is_slowed_by_a_force_that_vanishes_with_its_speed(speed):
    # C_d ~ Re^(-2/3), so that the force goes with v^(4/3).
    force = strip_drag((0.0, speed, 0.0), STILL, STILL, 0.0, (RHO, NU, 1.0), np.array([0.0, 0.02, 0.01, 1.0]))
    reynolds = speed * 0.02 / NU
    expected = 0.5 * RHO * 0.02 * 0.01 * (speed**2 + 10 * speed**2 * reynolds ** (-2 / 3))
    assert -force[1] == pytest.approx(expected, rel=1e-9)


# The whole body.


@given(speeds, rates)
def test_the_force_on_many_strips_is_their_sum_at_their_places(moving, omega):
    strips = chain(0.12, 0.03, 5, factor=0.7, middle=0.02)
    forces = [strip_drag(moving, omega, STILL, 0.0, (RHO, NU, 1.0), strip) for strip in strips]
    torques = [np.cross([strip[0], 0, 0], force) for strip, force in zip(strips, forces, strict=True)]
    expected = np.concatenate([np.sum(forces, axis=0), np.sum(torques, axis=0)])
    assert wrench_on(Drag(strips), moving, omega) == pytest.approx(expected, rel=1e-9, abs=1e-12)


def test_a_spinning_chain_of_strips_has_the_moment_of_the_integral():
    # dM = -1/2 rho d C_d (r x)^2 x dx over both halves, C_d = 1 + 10 (r x d / nu)^(-2/3).
    length, d, r = 0.3, 0.02, 7.0
    half = length / 2
    moment = RHO * d * r**2 * (half**4 / 4 + 10 * (r * d / NU) ** (-2 / 3) * half ** (10 / 3) * 3 / 10)
    for axis, spin in ((5, (0.0, 0.0, r)), (4, (0.0, r, 0.0))):
        wrench = wrench_on(Drag(chain(length, d, 400)), omega=spin)
        assert wrench[axis] == pytest.approx(-moment, rel=2e-5)
        assert np.delete(wrench, axis) == pytest.approx(np.zeros(5), abs=1e-12)


def test_the_drag_of_strips_acts_where_they_are():
    wrench = wrench_on(Drag(chain(0.1, 0.02, 10, middle=0.04)), moving=(0.0, 0.0, 0.5))
    assert wrench[2] < 0
    assert wrench[4] == pytest.approx(-0.04 * wrench[2], rel=1e-9)


@given(speeds, rates, turns, st.sampled_from([None, 0.0, 0.01, -0.02]))
def test_drag_never_does_work_on_a_body_in_still_water(moving, omega, turn, level):
    drag = Drag(chain(0.12, 0.03, 9, middle=0.02), friction_area=0.012, length=0.12, ahead=1e-4, astern=5e-4)
    R = Rotation.from_rotvec(turn).as_matrix()
    wrench = wrench_on(drag, moving, omega, R, level=level)
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


def test_a_level_body_half_under_water_has_half_the_drag():
    drag = Drag(chain(0.12, 0.03, 9), friction_area=0.012, length=0.12, ahead=1e-4, astern=5e-4)
    motion = (0.4, 0.3, 0.0), (0.0, 0.0, 2.0)
    assert wrench_on(drag, *motion, level=0.0) == pytest.approx(0.5 * wrench_on(drag, *motion), rel=1e-9)


# Along the axis.

AXIAL = np.array([0.012, 0.12, 1e-4, 5e-4, 0.0, 0.0])


def test_axial_drag_is_friction_and_the_blunt_end_that_goes_first():
    for speed, area in ((0.5, 1e-4), (-0.5, 5e-4)):
        c = 1.328 / math.sqrt(0.5 * 0.12 / NU)
        expected = 0.5 * RHO * (c * 0.012 + area) * 0.25
        assert axial_drag(speed, RHO, NU, AXIAL) == pytest.approx(-math.copysign(expected, speed), rel=1e-9)
    assert axial_drag(0.0, RHO, NU, AXIAL) == 0.0


@given(st.floats(-10, 10))
def test_axial_drag_opposes_the_motion_along_the_axis_and_only_that(speed):
    force = axial_drag(speed, RHO, NU, AXIAL)
    assert force * speed <= 0
    drag = Drag(chain(0.12, 0.03, 9), friction_area=0.012, length=0.12, ahead=1e-4, astern=5e-4)
    assert wrench_on(drag, moving=(speed, 0.0, 0.0)) == pytest.approx([force, 0, 0, 0, 0, 0], rel=1e-12)


@pytest.mark.parametrize(("level", "share"), [(None, 1.0), (0.0, 0.5), (-1.0, 0.0)])
def test_a_body_may_have_drag_along_its_axis_alone(level, share):
    drag = Drag(np.empty((0, 4)), friction_area=0.012, length=0.12, ahead=1e-4, astern=5e-4)
    force = axial_drag(0.7, RHO, NU, AXIAL) * share
    wrench = wrench_on(drag, (0.7, 0.2, 0.0), (0.0, 0.0, 1.0), level=level)
    assert wrench == pytest.approx([force, 0, 0, 0, 0, 0], rel=1e-12)
    assert model_of(drag).strips.size > 0, "the equations and the check of the energy ask for strips"


def test_a_body_without_drag_has_no_strips():
    assert model_of(None).strips.shape == (0, 4)
