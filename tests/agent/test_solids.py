"""Solids of revolution against closed forms, limiting shapes, and numerical quadrature of eq. 11 to 17."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from driftform.agent import solid_of_revolution

lengths = st.floats(0.001, 0.5)
radii = st.floats(0.0, 0.2)


@given(st.floats(-1, 1), lengths, st.floats(0.001, 0.2))
def test_a_cylinder_has_its_textbook_moments(x0, h, r):
    solid = solid_of_revolution([(x0, 0), (x0, r), (x0 + h, r), (x0 + h, 0)])
    volume, middle = np.pi * r**2 * h, x0 + h / 2
    assert solid.volume == pytest.approx(volume, rel=1e-12)
    assert solid.first == pytest.approx(volume * middle, rel=1e-9, abs=1e-12 * volume)
    assert solid.polar == pytest.approx(volume * r**2 / 2, rel=1e-12)
    # Steiner: m (3 r^2 + h^2) / 12 about the centre.
    about_origin = volume * ((3 * r**2 + h**2) / 12 + middle**2)
    assert solid.transverse == pytest.approx(about_origin, rel=1e-9)


@given(lengths, st.floats(0.001, 0.2))
def test_a_cone_has_its_centroid_at_a_quarter_of_its_height(h, r):
    solid = solid_of_revolution([(0, 0), (0, r), (h, 0)])
    mass = np.pi * r**2 * h / 3
    assert solid.volume == pytest.approx(mass, rel=1e-12)
    assert solid.centroid == pytest.approx(h / 4, rel=1e-12)
    assert solid.polar == pytest.approx(3 / 10 * mass * r**2, rel=1e-12)
    # About the base's centre: 3/20 m r^2 + 1/10 m h^2.
    assert solid.transverse == pytest.approx(mass * (3 * r**2 / 20 + h**2 / 10), rel=1e-12)


def arc(radius, start, end, steps):
    angles = np.linspace(start, end, steps + 1)
    return np.column_stack([-radius * np.cos(angles), radius * np.sin(angles)])


def test_a_fine_polyline_tends_to_the_sphere_with_second_order():
    r, exact = 0.01, 4 / 3 * np.pi * 0.01**3
    errors = []
    for steps in (50, 100):
        solid = solid_of_revolution(arc(r, 0, np.pi, steps))
        errors.append([abs(solid.volume / exact - 1), abs(solid.polar / (0.4 * exact * r**2) - 1)])
        assert solid.transverse == pytest.approx(solid.polar, rel=2e-3)
        assert abs(solid.first) < 1e-15 * exact
    coarse, fine = np.array(errors)
    assert (fine < 1e-3).all()
    assert coarse / fine == pytest.approx(4, rel=0.02)


@pytest.mark.parametrize("height", [0.002, 0.01, 0.015])
def test_a_spherical_cap_has_the_volume_and_centroid_of_eq_23(height):
    R = 0.01
    # The cap on the aft side of a sphere about the origin, from x = -R to x = -R + height.
    cap = solid_of_revolution([*arc(R, 0, np.arccos(1 - height / R), 4000), (height - R, 0)])
    sine = (R - height) / R
    assert cap.volume == pytest.approx(np.pi * R**3 / 3 * (2 - 3 * sine + sine**3), rel=1e-6)
    assert cap.volume == pytest.approx(np.pi * height**2 * (3 * R - height) / 3, rel=1e-6)
    assert -cap.centroid == pytest.approx(3 * (2 * R - height) ** 2 / (4 * (3 * R - height)), rel=1e-6)


@given(radii, radii, lengths)
def test_a_frustum_has_the_volume_and_centroid_of_eq_19_and_21(bottom, top, h):
    if bottom + top < 1e-3:
        return
    solid = solid_of_revolution([(0, 0), (0, bottom), (h, top), (h, 0)])
    squares = bottom**2 + bottom * top + top**2
    assert solid.volume == pytest.approx(np.pi * h * squares / 3, rel=1e-12)
    eq_19 = h / 4 * (bottom**2 + 2 * bottom * top + 3 * top**2) / squares
    assert solid.centroid == pytest.approx(eq_19, rel=1e-12)


@given(st.floats(0.005, 0.1), st.floats(0.005, 0.1), lengths)
def test_a_wall_of_constant_radial_thickness_has_the_centroid_of_eq_18(bottom, top, h):
    wall = 0.001
    outer = solid_of_revolution([(0, 0), (0, bottom + wall / 2), (h, top + wall / 2), (h, 0)])
    inner = solid_of_revolution([(0, 0), (0, bottom - wall / 2), (h, top - wall / 2), (h, 0)])
    assert (outer - inner).centroid == pytest.approx(h * (bottom + 2 * top) / (3 * (bottom + top)), rel=1e-9)


@given(st.lists(st.tuples(st.floats(0.001, 0.05), st.floats(0.001, 0.1)), min_size=2, max_size=12))
def test_any_chain_agrees_with_quadrature_of_the_papers_integrals(steps):
    x = np.cumsum([0.0, *(h for h, _ in steps[1:])]) - 0.1
    r = np.array([radius for _, radius in steps])
    solid = solid_of_revolution([(x[0], 0), *zip(x, r, strict=True), (x[-1], 0)])

    def integral(f):
        return sum(quad(f, a, b, epsabs=0, epsrel=1e-10)[0] for a, b in pairwise(x))

    def radius(s):
        return np.interp(s, x, r)

    assert solid.volume == pytest.approx(np.pi * integral(lambda s: radius(s) ** 2), rel=1e-9)
    size = np.pi * integral(lambda s: abs(s) * radius(s) ** 2)
    assert solid.first == pytest.approx(np.pi * integral(lambda s: s * radius(s) ** 2), abs=1e-9 * size)
    assert solid.second == pytest.approx(np.pi * integral(lambda s: s * s * radius(s) ** 2), rel=1e-8)
    assert solid.polar == pytest.approx(np.pi / 2 * integral(lambda s: radius(s) ** 4), rel=1e-9)  # eq. 13


def test_an_edge_that_runs_aft_subtracts_what_it_sweeps():
    cup = [(0, 0), (0, 0.02), (0.05, 0.02), (0.05, 0.015), (0.01, 0.015), (0.01, 0)]
    expected = np.pi * (0.02**2 * 0.05 - 0.015**2 * 0.04)
    assert solid_of_revolution(cup).volume == pytest.approx(expected, rel=1e-12)


def test_an_empty_contour_is_an_empty_solid():
    assert solid_of_revolution(np.empty((0, 2))).volume == 0.0
