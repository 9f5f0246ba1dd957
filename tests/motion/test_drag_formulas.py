"""Formulas of the drag as their sources have them, tables at their points, and the drag of bodies whose shape is simple."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from driftform.motion.forces.body_drag import SLENDER, estimate_drag
from driftform.motion.forces.drag import axial_drag, sphere_drag, spin_drag, strip_drag, wake_drag
from driftform.motion.forces.drag_coefficients import (
    base_coefficient,
    blockage_factor,
    crossflow_drag,
    end_shape_factor,
    finite_length_factor,
    form_factor,
    friction_coefficient,
    nose_coefficient,
    sphere_excess,
    sphericity,
    spin_coefficient,
)
from driftform.testing.bodies import cylinder_body, make_body, spheroid_body

RHO, NU = 1024.0, 1.05e-6
RADIUS, LENGTH = 0.02, 0.16

reynolds_numbers = st.floats(0, 6).map(lambda e: 10**e)


@given(reynolds_numbers)
def test_coefficients_are_the_formulas_of_their_sources(re):
    assert crossflow_drag(re, 1.0) / re == pytest.approx(1.18 + 1.96 / re**0.5, rel=1e-9)
    clift = 24 / re * (1 + 0.15 * re**0.687) + 0.42 / (1 + 42500 * re**-1.16)
    assert 24 / re + sphere_excess(re) == pytest.approx(clift, rel=1e-9)
    # A spin below 40 goes with the inverse of Re.
    spin = (3.507 * math.log10(max(re, 40)) - 2.565) ** -2 * max(1, 40 / re)
    assert spin_coefficient(re) == pytest.approx(spin, rel=1e-9)
    if re < 5e5:
        assert friction_coefficient(re) == pytest.approx(1.328 / re**0.5, rel=1e-9)
    else:
        # A is the difference of the two lines at 5e5, times 5e5.
        front = 5e5 * 0.075 / (math.log10(5e5) - 2) ** 2 - 1.328 * 5e5**0.5
        ittc = 0.075 / (math.log10(re) - 2) ** 2
        assert friction_coefficient(re) == pytest.approx(ittc - front / re, rel=1e-9)


@given(st.floats(0, 0.95))
def test_the_factor_of_a_bore_is_achenbachs(b):
    assert blockage_factor(b) == pytest.approx((1 + 1.45 * b**4.5) / (1 - b**2) ** 2, rel=1e-9)
    assert blockage_factor(0.95) == blockage_factor(1.0) < 1000


@given(st.floats(1e-3, 0.4), st.floats(0, 1), st.floats(1e-3, 1))
def test_factors_of_form_and_base_are_hoerners(s, ratio, friction):
    assert form_factor(s) == pytest.approx(1 + 1.5 * s**1.5 + 7 * s**3, rel=1e-12)
    base = min(0.029 / math.sqrt(friction), 0.20) * ratio**3
    assert base_coefficient(ratio, friction) == pytest.approx(base, rel=1e-9)
    # Flatter bodies have the form factor of those of two fifths.
    assert form_factor(0.9) == form_factor(0.4) == pytest.approx(1 + 1.5 * 0.4**1.5 + 7 * 0.4**3)


def test_short_cylinders_cones_and_flat_faces_have_the_drag_of_their_tables():
    # Between the points, the logarithm of the aspect counts.
    short = {1: 0.64, 2: 0.68, 3: 0.72, 5: 0.74, 10: 0.82, math.sqrt(200): (0.82 + 0.91) / 2, 20: 0.91, 40: 0.98}
    cones = {0: 0.2, 5: 0.3, 10: 0.4, 15: 0.55, 20: 0.65, 30: 0.8, 37.5: 1.05, 45: 1.15, 90: 1.17}
    faces = {0: 1.17, 0.5: 1.15, 1: 0.9, 2: 0.85, 4: 0.87, 8: 0.99}
    assert {a: 1.18 * finite_length_factor(a) for a in short} == pytest.approx(short, rel=1e-12)
    assert {a: nose_coefficient(math.radians(a), 0.0) + 0.2 for a in cones} == pytest.approx(cones, rel=1e-12)
    assert {a: nose_coefficient(math.pi / 2, a) + 0.2 for a in faces} == pytest.approx(faces, rel=1e-12)


@given(st.floats(0.3, 0.999), st.floats(0.3, 30))
def test_ends_have_the_ratio_of_hoelzer_and_sommerfeld(phi, aspect):
    flat = (12 * aspect) ** (2 / 3) / (4 * aspect + 2)
    drags = [0.42 * 10 ** (0.4 * (-math.log10(p)) ** 0.2) for p in (phi, flat)]
    assert end_shape_factor(phi, aspect) == pytest.approx(drags[0] / drags[1], rel=1e-9)
    # The sphericity of a flat-ended cylinder, from its volume and surface.
    r, h = 1.0, 2.0 * aspect
    volume, surface = math.pi * h, 2 * math.pi * (h + 1)
    assert flat == pytest.approx(math.pi ** (1 / 3) * (6 * volume) ** (2 / 3) / surface, rel=1e-9)
    box = np.array([(0.0, 0.0), (0.0, r), (h, r), (h, 0.0)])
    assert sphericity(box) == pytest.approx(flat, rel=1e-9)


@pytest.mark.parametrize("turn", [0.0, 1.2])
def test_a_strip_feels_the_water_that_moves_past_it(turn):
    """Its own velocity less that of the water, which changes along the axis."""
    x, d, dx, factor, wet = 0.07, 0.03, 0.012, 0.8, 0.6
    moving, omega, shear, middle = (0.4, 0.2, -0.3), (2.0, 1.5 + turn, -0.7), (0.3, 0.9, -0.5), 0.02
    velocity = np.array(moving) + np.cross(omega, [x, 0, 0]) - (x - middle) * np.array(shear)
    across = velocity * [0, 1, 1]
    speed = np.linalg.norm(across)
    expected = -0.5 * RHO * wet * factor * d * dx * crossflow_drag(speed, NU / d) * across
    found = strip_drag(moving, omega, shear, middle, (RHO, NU, wet), np.array([x, d, dx, factor]))
    assert found == pytest.approx(expected, rel=1e-9)


def test_a_sphere_and_a_spin_have_the_forces_of_their_coefficients():
    v, area = np.array([0.3, -0.4, 1.2]), 7e-4
    # What creeping has is a force of its own.
    re = 1.3 * 0.03 / NU
    expected = -0.5 * RHO * area * sphere_excess(re) * 1.3 * v
    assert sphere_drag(tuple(v), RHO, NU, area, 0.03) == pytest.approx(expected)
    assert sphere_drag(tuple(v), RHO, NU, 0.0, 0.03) == (0.0, 0.0, 0.0)
    for rate in (-8.0, 8.0):
        torque = -0.5 * RHO * spin_coefficient(8 * 0.015**2 / NU) * 8 * rate * 1e-8
        assert spin_drag(rate, RHO, NU, 1e-8, 0.03) == pytest.approx(torque)
    assert spin_drag(8.0, RHO, NU, 0.0, 0.03) == 0.0


def test_a_tail_across_the_flow_and_one_at_an_angle_have_allens_factor():
    for alpha in (0.1, 0.8, 1.5):
        u, v = 0.7 * math.cos(alpha), 0.7 * math.sin(alpha)
        expected = -RHO * 3e-4 * u * v * math.cos(alpha / 2)
        assert wake_drag(u, 0.6 * v, -0.8 * v, RHO, 3e-4) == pytest.approx((0, 0.6 * expected, -0.8 * expected))


@pytest.mark.parametrize("speed", [1e-149, 1e-100])
def test_the_slowest_motions_that_count_have_laminar_friction(speed):
    area = 0.01 * 1.328 / math.sqrt(speed * 0.1 / NU)
    axial = np.array([0.01, 0.1, 1e-4, 2e-4])
    expected = -0.5 * RHO * (area + 1e-4) * speed * speed
    assert axial_drag(speed, RHO, NU, axial) == pytest.approx(expected, rel=1e-9, abs=0)


def blunt_end(length, radius):
    """Drag area of the face and the base of a flat-ended cylinder."""
    frontal = math.pi * radius**2
    friction = friction_coefficient(0.3 * length / NU) * 2 * math.pi * radius * length / frontal
    return frontal * (nose_coefficient(math.pi / 2, length / (2 * radius)) + base_coefficient(1.0, friction))


def test_a_cylinder_has_the_drag_of_its_parts():
    """Flat ends, friction on its side, strips of equal width, and integrals of its sections in closed form."""
    drag = estimate_drag(cylinder_body(LENGTH, RADIUS), NU, wake_factor=0.9)
    # Of the form factor that which blunt ends leave.
    smooth = 1 - blunt_end(LENGTH, RADIUS) / (0.85 * math.pi * RADIUS**2)
    form = 1 + smooth * (form_factor(2 * RADIUS / LENGTH) - 1)
    assert 0 < smooth < 0.2
    assert drag.friction_area == pytest.approx(2 * math.pi * RADIUS * LENGTH * form)
    assert (drag.length, drag.diameter, drag.blocking) == pytest.approx((LENGTH, 2 * RADIUS, 2 * RADIUS))
    assert drag.ahead == pytest.approx(blunt_end(LENGTH, RADIUS), rel=1e-9)
    assert drag.astern == pytest.approx(drag.ahead, rel=1e-9)
    # An L/d of 4, and ends that are those of the cylinder.
    assert drag.strips[:, 3] == pytest.approx(np.full(5, finite_length_factor(4.0)), rel=1e-9)
    assert drag.strips[:, 1] @ drag.strips[:, 2] == pytest.approx(2 * RADIUS * LENGTH)
    assert drag.round_area == 0.0
    assert drag.wake_ahead[1] == pytest.approx(0.9 * math.pi * RADIUS**2)
    assert drag.wake_astern[1] == pytest.approx(0.9 * math.pi * RADIUS**2)
    assert drag.spin == pytest.approx(2 * math.pi * RADIUS**4 * LENGTH)
    assert drag.shear_volume == pytest.approx(0.5 * math.pi * RADIUS**2 * LENGTH)
    assert drag.spread == pytest.approx((RADIUS**2 / 4, LENGTH**2 / 12), rel=1e-9)


@pytest.mark.parametrize("ratio", [1.0, 1.2, 1.4])
def test_a_body_between_sphere_and_spheroid_has_shares_of_both_drags(ratio):
    body = spheroid_body(ratio * RADIUS, RADIUS, edges=200)
    share = max(0.0, (sphericity(body.outer) - 0.92) / 0.08)
    assert pytest.approx(0.92) == SLENDER
    mixed, slender = estimate_drag(body, NU), estimate_drag(body, NU, without=("sphere",))
    assert 0.1 < share <= 1.0
    assert mixed.round_area == pytest.approx(share * math.pi * RADIUS**2)
    assert slender.round_area == 0.0
    for name in ("friction_area", "ahead", "astern"):
        assert getattr(mixed, name) == pytest.approx((1 - share) * getattr(slender, name), abs=1e-15)
    assert mixed.wake_ahead[1] == pytest.approx((1 - share) * slender.wake_ahead[1], abs=1e-15)
    assert mixed.strips[:, 3] == pytest.approx((1 - share) * slender.strips[:, 3], abs=1e-15)


@pytest.mark.parametrize("chamfer", [0.02, 0.2])
def test_the_nose_of_a_cylinder_has_the_inclination_of_its_outer_twentieth(chamfer):
    """A cone of half angle 30 degrees that is cut at a share of the radius; only a chamfer within 5 % is not seen as one."""
    slope = math.tan(math.radians(30))
    inner = (1 - chamfer) * RADIUS
    nose = [(LENGTH, RADIUS), (LENGTH + chamfer * RADIUS / slope, inner), (LENGTH + chamfer * RADIUS / slope, 0)]
    body = make_body([(0, 0), (0, RADIUS), *nose])
    # Of a small chamfer, the outer twentieth has all, and the flat face behind it.
    angle = math.radians(30) if chamfer > 0.05 else math.atan2(0.05 * RADIUS, chamfer * RADIUS / slope)
    frontal, length = math.pi * RADIUS**2, body.length
    rubbed = 2 * math.pi * (RADIUS * LENGTH + 0.5 * (RADIUS + inner) * (length - LENGTH))
    friction = friction_coefficient(0.3 * length / NU) * rubbed / frontal
    found = estimate_drag(body, NU).ahead
    expected = frontal * (nose_coefficient(angle, LENGTH / (2 * RADIUS)) + base_coefficient(1.0, friction))
    assert found == pytest.approx(expected, rel=1e-9)
