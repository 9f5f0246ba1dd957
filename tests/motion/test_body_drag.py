"""Drag of a body against measured bodies: spheres, cylinders, discs and cones."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from driftform.motion.forces.body_drag import SLENDER, estimate_drag, wake_factor
from driftform.motion.forces.drag import still_water_wrench
from driftform.motion.forces.drag_coefficients import sphericity
from driftform.motion.forces.strips import outer_radii
from driftform.motion.forces.terminal import terminal_speeds
from driftform.study import load_study
from driftform.testing.bodies import (
    cylinder_body,
    dome_body,
    make_body,
    mirrored_body,
    mirrored_contour,
    scaled_body,
    spheroid_body,
)
from driftform.types import Body, Coefficients, Module, Morphology
from driftform_frusta.builder import FrustaBuilder, FrustaOptions

BUILDER = FrustaBuilder(FrustaOptions())
NU = 1.0e-6
STILL = (0.0, 0.0, 0.0)
RADIUS = 0.05


def along(body, speed):
    """C_d on the frontal area of a body that moves along its axis at ``speed``, m/s, in water."""
    force = still_water_wrench(estimate_drag(body, NU), (speed, 0.0, 0.0), STILL, 1000.0, NU)[0]
    return abs(force) / (0.5 * 1000.0 * speed**2 * math.pi * (body.max_diameter / 2) ** 2)


def across(body, speed):
    """C_d on the projected area of a body that moves across its axis."""
    force = still_water_wrench(estimate_drag(body, NU), (0.0, 0.0, speed), STILL, 1000.0, NU)[2]
    dx, r = np.diff(body.outer[:, 0]), body.outer[:, 1]
    return abs(force) / (0.5 * 1000.0 * speed**2 * float((r[:-1] + r[1:]) @ dx))


def capsule_contour(aspect):
    """A cylinder with half spheres for ends, ``aspect`` times as long as thick, of radius 1."""
    quarter = np.linspace(0, math.pi / 2, 200)
    dome = np.column_stack([np.cos(quarter), np.sin(quarter)])
    fore = dome[::-1] + np.array([aspect - 1, 0])
    return np.concatenate([mirrored_contour(fore), fore])


def clift_gauvin(reynolds):
    """The standard drag curve of a sphere, to 6 % for Re < 3e5 (Clift and Gauvin, 1970)."""
    return 24 / reynolds * (1 + 0.15 * reynolds**0.687) + 0.42 / (1 + 42500 * reynolds**-1.16)


@dataclass(frozen=True)
class Case:
    """A body that moves at a Reynolds number (on its diameter), and its C_d in the literature.

    ``within`` is how far off, relatively, the model may be.
    """

    name: str
    body: Body
    motion: Callable[[Body, float], float]
    reynolds: float
    measured: float
    source: str
    within: float

    @property
    def found(self):
        return self.motion(self.body, self.reynolds * NU / self.body.max_diameter)

    def __str__(self):
        return f"{self.name} {self.motion.__name__} at Re {self.reynolds:.0e}"


def cylinder(aspect):
    return cylinder_body(2 * RADIUS * aspect, RADIUS)


def cone(full):
    """Apex first; ``full`` is its angle, degrees."""
    return make_body([(0, 0), (0, RADIUS), (RADIUS / math.tan(math.radians(full / 2)), 0)])


HEMISPHERE = mirrored_body(dome_body(RADIUS, edges=60))
WHITE = "White, table 7.3"
CASES = [
    # Of a polygon of revolution, whose sphericity is a little less than 1.
    *(
        Case("sphere", spheroid_body(RADIUS, RADIUS, edges=100), motion, re, clift_gauvin(re), "Clift and Gauvin", w)
        for motion, w in ((along, 0.01), (across, 0.01))
        for re in (1e3, 3e3, 1e4, 3e4, 1e5, 2e5)
    ),
    Case("disc", cylinder_body(0.001, RADIUS), along, 5e4, 1.17, WHITE, 0.02),
    *(
        Case(f"cylinder, L/d {aspect:g}", cylinder(aspect), along, 5e4, measured, WHITE, 0.06)
        for aspect, measured in ((0.5, 1.15), (1, 0.90), (2, 0.85), (4, 0.87), (8, 0.99))
    ),
    *(
        Case(f"cone of {full} degrees, apex first", cone(full), along, 5e4, measured, WHITE, 0.06)
        for full, measured in ((20, 0.40), (40, 0.65), (60, 0.80), (90, 1.15))
    ),
    Case("hemisphere, round first", HEMISPHERE, along, 5e4, 0.42, WHITE, 0.10),
    Case("hemisphere, flat first", mirrored_body(HEMISPHERE), along, 5e4, 1.17, WHITE, 0.10),
    *(
        Case(f"cylinder, L/d {aspect}", cylinder(aspect), across, re, measured, WHITE, 0.08)
        for re in (1e4, 5e4)
        for aspect, measured in ((1, 0.64), (2, 0.68), (5, 0.74), (10, 0.82), (20, 0.91), (40, 0.98))
    ),
]

CORE_WEIGHT = (0.05 - 1024 * 4 / 3 * math.pi * 1e-6) * 9.81
"""In water, N: 0.05 kg in a sphere of 10 mm radius."""

CORE_SPEED = math.sqrt(2 * CORE_WEIGHT / (1024 * 0.47 * math.pi * 1e-4))
"""Benchmark 1: the speed at which its drag carries that weight with White's C_d of a sphere, 0.47; m/s."""


def core_speeds():
    """Of the model, along and across its axis, m/s."""
    drag = estimate_drag(spheroid_body(0.01, 0.01, edges=100), NU)
    return terminal_speeds(drag, CORE_WEIGHT, fore_first=True, density=1024.0, viscosity=NU)


@pytest.mark.parametrize("case", CASES, ids=str)
def test_bodies_have_the_drag_that_was_measured(case):
    assert case.found == pytest.approx(case.measured, rel=case.within)


def test_the_bare_core_sinks_as_fast_as_the_sphere_of_benchmark_1():
    assert round(CORE_SPEED, 4) == 2.4355
    assert core_speeds() == pytest.approx((CORE_SPEED, CORE_SPEED), rel=0.05)


def test_the_page_has_the_errors_of_the_drag(published):
    rows = [
        (case.name, case.motion.__name__, f"{case.reynolds:.0e}", case.found, case.measured)
        for case in CASES
        # A sphere moves alike along and across.
        if (case.name, case.motion) != ("sphere", across)
    ]
    speed = core_speeds()[0]
    rows.append(("core of 50 g, terminal speed, m/s", "along", f"{speed * 0.02 / NU:.0e}", speed, CORE_SPEED))
    published(
        "drag",
        [
            "| body | moves | Re | model | literature | off by |",
            "|---|---|---|---|---|---|",
            *(
                f"| {name} | {motion} | {re} | {found:.3f} | {value:.3f} | {100 * (found / value - 1):+.0f} % |"
                for name, motion, re, found, value in rows
            ),
        ],
    )


def test_drag_changes_continuously_from_slender_bodies_to_spheres():
    lengths = np.linspace(0.9, 2.5, 161)
    drags = np.array([[f(spheroid_body(a * RADIUS, RADIUS, edges=200), 0.5) for f in (along, across)] for a in lengths])
    assert np.abs(np.diff(drags, axis=0)).max() < 0.01
    # An ellipsoid twice as long as thick, with a laminar layer: White, table 7.3.
    assert along(spheroid_body(2 * RADIUS, RADIUS, edges=200), 0.5) == pytest.approx(0.27, rel=0.2)


@given(st.floats(0, math.pi))
def test_a_sphere_has_the_same_drag_in_every_direction(angle):
    drag = estimate_drag(spheroid_body(RADIUS, RADIUS, edges=100), NU)
    moving = (0.5 * math.cos(angle), 0.0, 0.5 * math.sin(angle))
    force = still_water_wrench(drag, moving, STILL, 1000.0, NU)[:3]
    assert force == pytest.approx(-np.linalg.norm(force) / 0.5 * np.array(moving), abs=2e-3)
    assert np.linalg.norm(force) == pytest.approx(125 * math.pi * RADIUS**2 * clift_gauvin(5e4), rel=0.01)


def test_only_bodies_that_are_nearly_spheres_have_the_drag_of_one():
    assert sphericity(spheroid_body(0.02, 0.02, edges=400).outer) == pytest.approx(1, abs=1e-4)
    # Of a capsule with a cylinder as long as its radius twice: V = 10/3 pi r^3, S = 8 pi r^2.
    assert sphericity(capsule_contour(2.0)) == pytest.approx((10 / 4) ** (2 / 3) * 4 / 8, rel=1e-3)
    for case in CASES:
        assert case.name == "sphere" or sphericity(case.body.outer) < SLENDER


def test_round_ends_have_less_drag_across_than_flat_ones_and_the_less_the_shorter_the_body():
    ratios = [across(make_body(RADIUS * capsule_contour(a)), 0.5) / across(cylinder(a), 0.5) for a in (2, 4, 8)]
    assert 0.85 < ratios[0] < ratios[1] < ratios[2] < 1


modules = st.lists(
    st.builds(Module, length=st.sampled_from([2.5e-3, 5e-3, 1e-2]), tilt=st.floats(-1.39, 1.39)), max_size=12
).map(tuple)


@given(
    st.builds(Morphology, fore=modules, aft=modules),
    st.tuples(st.floats(-1, 1), st.floats(-1, 1)),
    st.tuples(st.floats(-10, 10), st.floats(-10, 10)),
)
def test_five_strips_are_as_good_as_hundreds(morphology, aside, turning):
    body = BUILDER.build(morphology)
    x, r = outer_radii(body.outer, 800)
    few = estimate_drag(body, NU)
    many = replace(few, strips=np.column_stack([x, 2 * r, np.full(800, x[1] - x[0]), np.full(800, few.strips[0, 3])]))
    motion = (0.0, *aside), (0.0, *turning)
    found, expected = (still_water_wrench(d, *motion, 1000.0, NU) for d in (few, many))
    # The force if the whole side moved like its fastest part, and the moment of that force on the longer end.
    ends = np.array([x[0], x[-1]])
    fastest = float(np.hypot(aside[0] + ends * turning[1], aside[1] - ends * turning[0]).max())
    scale = still_water_wrench(many, (0.0, 0.0, max(fastest, 0.05)), STILL, 1000.0, NU)[2]
    assert found[1:3] == pytest.approx(expected[1:3], abs=0.03 * abs(scale))
    assert found[4:] == pytest.approx(expected[4:], abs=0.03 * abs(scale) * np.abs(ends).max())


def test_the_wake_of_a_blunt_body_begins_at_its_base_and_that_of_a_pointed_one_where_it_is_steepest():
    blunt = estimate_drag(cylinder(5), NU)
    assert blunt.wake_ahead == pytest.approx((-5 * RADIUS, math.pi * RADIUS**2))
    assert blunt.wake_astern == pytest.approx((5 * RADIUS, math.pi * RADIUS**2))
    # A parabola: steepest, on the mean over a diameter half, a quarter diameter ahead of its point.
    s = np.linspace(0, 1, 400)
    pointed = make_body([*np.column_stack([2 * s, 0.1 * s * (2 - s)]), (2.0, 0.0)])
    x, area = estimate_drag(pointed, NU).wake_ahead
    assert 0.0 < x < 0.1
    assert area == pytest.approx(math.pi * (0.1 * x / 2 * (2 - x / 2)) ** 2, rel=0.02)


@pytest.mark.parametrize(
    ("term", "zero"),
    [("sphere", "round_area"), ("roll", "spin"), ("lift", "shear_volume"), ("bore", "blocking"), ("bore", "spread")],
)
def test_every_term_can_be_left_out(term, zero):
    body = spheroid_body(0.02, 0.02, edges=100)
    assert np.all(np.array(getattr(estimate_drag(body, NU), zero)) > 0)
    assert not np.any(getattr(estimate_drag(body, NU, without=(term,)), zero))


def test_a_study_leaves_out_what_its_option_names():
    study = load_study(
        "paper",
        ["hydrodynamics.drag=strips", 'hydrodynamics.drag_without=["roll", "wake"]'],
        use={"simulator": "native"},
    )
    pipeline = study.make_pipeline()
    drag = pipeline.make_agent(pipeline.grammar.random(np.random.default_rng(0))).coefficients.drag
    assert drag.spin == drag.wake_ahead[1] == 0.0 < drag.shear_volume


def test_the_factor_of_the_wake_is_that_of_the_munk_moment():
    assert wake_factor(Coefficients(np.diag([0.2, 1.1, 1.1, 0, 0, 0])), 1.0) == pytest.approx(0.9)
    assert wake_factor(Coefficients(np.diag([1.2, 0.4, 0.4, 0, 0, 0])), 1.0) == 0.0


def test_a_slender_spheroid_is_streamlined():
    # Hoerner, figure 6-16: 0.06 to 0.1 on the frontal area at a fineness of 6 and Re of 1e5 to 1e6.
    assert 0.05 < along(spheroid_body(6 * RADIUS, RADIUS, edges=200), 0.5) < 0.12


def test_a_mirrored_body_has_ahead_and_astern_exchanged():
    cone = make_body([(0, 0), (0, 0.03), (0.1, 0.01), (0.1, 0)])
    here, there = estimate_drag(cone, NU), estimate_drag(mirrored_body(cone), NU)
    assert (here.ahead, here.astern) == pytest.approx((there.astern, there.ahead))
    assert here.ahead < here.astern
    assert here.strips[:, 0] == pytest.approx(-there.strips[::-1, 0])


@given(st.floats(0.2, 5))
def test_areas_grow_with_the_square_of_the_size(scale):
    cone = make_body([(0, 0), (0, 0.03), (0.1, 0.01), (0.1, 0)])
    small, large = estimate_drag(cone, NU), estimate_drag(scaled_body(cone, scale), NU * scale)
    # With the viscosity scaled too, the Reynolds number is the same.
    for name in ("friction_area", "ahead", "astern"):
        assert getattr(large, name) == pytest.approx(scale**2 * getattr(small, name), rel=1e-9)


@given(st.builds(Morphology, fore=modules, aft=modules))
def test_any_body_has_finite_drag(morphology):
    body = BUILDER.build(morphology)
    drag = estimate_drag(body, NU)
    frontal = math.pi * body.max_diameter**2 / 4
    assert np.isfinite(drag.strips).all() and (drag.strips[:, 1:] > 0).all()
    assert math.isfinite(drag.friction_area) and drag.friction_area >= 0
    assert 0 < drag.ahead + drag.round_area <= 1.4 * frontal
    assert 0 < drag.astern + drag.round_area <= 1.4 * frontal
    assert max(drag.wake_ahead[1], drag.wake_astern[1]) <= frontal * (1 + 1e-9)
    # Where both ends are concave, the steepest place of one may lie beyond that of the other.
    wakes = drag.wake_ahead[0], drag.wake_astern[0]
    assert body.outer[:, 0].min() <= min(wakes) <= max(wakes) <= body.outer[:, 0].max()
