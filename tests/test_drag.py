"""Drag of a body against measured bodies: spheres, cylinders, discs and cones."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from driftform.drag import BLUNT_BASE, base_coefficient, drag_of, finite_length_factor, form_factor
from driftform.dynamics.drag import axial_drag, friction_coefficient, strip_drag
from driftform.study import load_study
from driftform.testing.bodies import body_of, cylinder_body, mirrored_body, scaled_body, spheroid_body
from driftform.types import FloatArray

NU = 1.0e-6
RADIUS = 0.05


def along(body, speed):
    """C_d on the frontal area of a body that moves along its axis at ``speed``, m/s, in water."""
    drag = drag_of(body, NU)
    axial: FloatArray = np.array([drag.friction_area, drag.length, drag.ahead, drag.astern])
    force = axial_drag(speed, 1000.0, NU, axial)
    return abs(force) / (0.5 * 1000.0 * speed**2 * math.pi * (body.max_diameter / 2) ** 2)


def across(body, speed):
    """C_d on the projected area of a body that moves across its axis."""
    drag = drag_of(body, NU)
    force = sum(
        strip_drag((0.0, 0.0, speed), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0, (1000.0, NU, 1.0), strip)[2]
        for strip in drag.strips
    )
    dx, r = np.diff(body.outer[:, 0]), body.outer[:, 1]
    return abs(force) / (0.5 * 1000.0 * speed**2 * float((r[:-1] + r[1:]) @ dx))


def clift_gauvin(reynolds):
    """The standard drag curve of a sphere, to 6 % for Re < 3e5 (Clift and Gauvin, 1970)."""
    return 24 / reynolds * (1 + 0.15 * reynolds**0.687) + 0.42 / (1 + 42500 * reynolds**-1.16)


@pytest.mark.parametrize("reynolds", [1e4, 3e4, 1e5, 2e5])
def test_a_sphere_has_the_drag_of_the_standard_curve_within_a_third_in_both_directions(reynolds):
    sphere = spheroid_body(RADIUS, RADIUS, edges=100)
    speed = reynolds * NU / (2 * RADIUS)
    assert along(sphere, speed) == pytest.approx(clift_gauvin(reynolds), rel=0.33)
    assert across(sphere, speed) == pytest.approx(clift_gauvin(reynolds), rel=0.40)


@pytest.mark.parametrize(("aspect", "measured"), [(0.5, 1.15), (1, 0.90), (2, 0.85), (4, 0.87), (8, 0.99)])
def test_a_flat_cylinder_along_its_axis_has_whites_coefficient(aspect, measured):
    assert along(cylinder_body(2 * RADIUS * aspect, RADIUS), 0.5) == pytest.approx(measured, rel=0.06)


def test_a_disc_has_117():
    assert along(cylinder_body(0.001, RADIUS), 0.5) == pytest.approx(1.17, rel=0.02)


@pytest.mark.parametrize(("full", "measured"), [(20, 0.40), (40, 0.65), (60, 0.80), (90, 1.15)])
def test_a_cone_apex_first_has_whites_coefficient(full, measured):
    cone = body_of([(0, 0), (0, RADIUS), (RADIUS / math.tan(math.radians(full / 2)), 0)])
    assert along(cone, 0.5) == pytest.approx(measured, rel=0.06)


def test_a_hemisphere_drags_little_round_first_and_like_a_disc_flat_first():
    arc = [(RADIUS * math.sin(t), RADIUS * math.cos(t)) for t in np.linspace(0, math.pi / 2, 60)[1:]]
    hemisphere = body_of([(0, 0), (0, RADIUS), *arc])
    assert along(hemisphere, 0.5) == pytest.approx(0.42, rel=0.10)
    assert along(hemisphere, -0.5) == pytest.approx(1.17, rel=0.10)


@pytest.mark.parametrize(("aspect", "measured"), [(1, 0.64), (2, 0.68), (5, 0.74), (10, 0.82), (40, 0.98)])
def test_a_cylinder_across_the_flow_has_whites_coefficient_for_its_length(aspect, measured):
    speed = 0.5
    # The table is of Re >= 1e4, where a long cylinder has 1.2; the strips have 1 + 10 Re^(-2/3).
    long = 1 + 10 * (speed * 2 * RADIUS / NU) ** (-2 / 3)
    found = across(cylinder_body(2 * RADIUS * aspect, RADIUS), speed) / long
    assert found == pytest.approx(measured / 1.2, rel=0.01)


def test_a_slender_spheroid_is_streamlined():
    # Hoerner, figure 6-16: 0.06 to 0.1 on the frontal area at a fineness of 6 and Re of 1e5 to 1e6.
    assert 0.05 < along(spheroid_body(6 * RADIUS, RADIUS, edges=200), 0.5) < 0.12


def test_the_bare_core_sinks_about_as_fast_as_the_sphere_of_benchmark_1():
    # 0.05 kg in a sphere of 10 mm radius: 2.4355 m/s with C_d 0.47.
    body = spheroid_body(0.01, 0.01, edges=100)
    weight = (0.05 - 1024 * 4 / 3 * math.pi * 1e-6) * 9.81

    def excess(speed):
        return 0.5 * 1024 * along(body, speed) * math.pi * 1e-4 * speed**2 - weight

    low, high = 0.1, 10.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if excess(middle) < 0 else (low, middle)
    # A third of the drag is a fifth of the speed.
    assert low == pytest.approx(2.4355, rel=0.25)


def test_a_mirrored_body_has_ahead_and_astern_exchanged():
    cone = body_of([(0, 0), (0, 0.03), (0.1, 0.01), (0.1, 0)])
    here, there = drag_of(cone, NU), drag_of(mirrored_body(cone), NU)
    assert (here.ahead, here.astern) == pytest.approx((there.astern, there.ahead))
    assert here.ahead < here.astern
    assert here.strips[:, 0] == pytest.approx(-there.strips[::-1, 0])


@given(st.floats(0.2, 5))
def test_areas_grow_with_the_square_of_the_size(scale):
    cone = body_of([(0, 0), (0, 0.03), (0.1, 0.01), (0.1, 0)])
    small, large = drag_of(cone, NU), drag_of(scaled_body(cone, scale), NU * scale)
    # With the viscosity scaled too, the Reynolds number is the same.
    for name in ("friction_area", "ahead", "astern"):
        assert getattr(large, name) == pytest.approx(scale**2 * getattr(small, name), rel=1e-9)


def test_formulas_have_their_limits():
    assert finite_length_factor(1000.0) == pytest.approx(0.98 / 1.2)
    assert form_factor(1e-9) == pytest.approx(1.0)
    assert base_coefficient(0.0, 0.02) == 0.0
    assert base_coefficient(1.0, 1e-4) == BLUNT_BASE
    assert friction_coefficient(1e6) > friction_coefficient(1e8)


def test_any_agent_has_finite_drag_and_comes_to_its_terminal_velocity():
    study = load_study(
        "pipe-inspection", ["hydrodynamics.drag=strips", "flow.speed=0.0"], use={"simulator": "native"}
    )
    pipeline = study.pipeline()
    rng = np.random.default_rng(3)
    agents = [pipeline.agent(pipeline.grammar.random(rng)) for _ in range(40)]
    for agent in agents:
        drag = agent.coefficients.drag
        assert drag is not None
        assert np.isfinite(drag.strips).all() and (drag.strips[:, 1:] > 0).all()
        frontal = math.pi * agent.body.max_diameter**2 / 4
        assert 0 < drag.ahead <= 1.4 * frontal and 0 < drag.astern <= 1.4 * frontal
    flights = pipeline.fly(agents[:10])
    assert not any(flight.end.failed for flight in flights)
