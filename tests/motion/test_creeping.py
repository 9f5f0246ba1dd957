"""Drag from creeping motion to high Reynolds numbers, against closed forms, bounds, and what others computed and measured."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from driftform.motion.forces.body_drag import estimate_drag
from driftform.motion.forces.creeping import creeping_resistance, spheroid_resistance
from driftform.motion.forces.drag import creeping_drag, still_water_wrench
from driftform.study import load_study
from driftform.testing.bodies import cylinder_body, spheroid_body

RHO, NU = 1000.0, 1.0e-6
STILL = (0.0, 0.0, 0.0)
REYNOLDS = 10 ** np.linspace(-3, 5, 33)
ALONG, ACROSS = 0, 2


def force(body, speed, way, viscosity=NU):
    """The resistance (N) to a motion along or across the axis at ``speed``, m/s."""
    moving = [0.0, 0.0, 0.0]
    moving[way] = speed
    drag = estimate_drag(body, viscosity)
    return -float(still_water_wrench(drag, tuple(moving), STILL, RHO, viscosity)[way])


def hoelzer_sommerfeld(aspect, reynolds, way):
    """C_d of a cylinder on its projected area, at Re on its diameter.

    Hoelzer and Sommerfeld, Powder Technology 184 (2008), 361, eq. 9; their Re and C_d refer to the sphere of equal volume. The
    lengthwise sphericity is its section over half of the surface less the mean section along the flow.
    """
    size = (1.5 * aspect) ** (1 / 3)
    section, surface = math.pi / 4 * size**2, math.pi * aspect + math.pi / 2
    ahead, beside = (math.pi / 4, aspect) if way == ALONG else (aspect, (aspect + math.pi / 4) / 2)
    phi, lengthwise, re = 4 * section / surface, section / (surface / 2 - beside), reynolds * size
    creeping = 8 / (re * lengthwise**0.5) + 16 / (re * phi**0.5)
    inertial = 0.42 * 10 ** (0.4 * (-math.log10(phi)) ** 0.2) * ahead / section
    return (creeping + 3 / (re**0.5 * phi**0.75) + inertial) * section / ahead


def off_hoelzer_sommerfeld(aspect, way):
    """The greatest relative difference from the correlation."""
    body = cylinder_body(0.02 * aspect, 0.01)
    area = math.pi * 1e-4 if way == ALONG else 4e-4 * aspect
    ratios = []
    for re in REYNOLDS:
        speed = re * NU / 0.02
        c = force(body, speed, way) / (0.5 * RHO * speed**2 * area)
        ratios.append(c / hoelzer_sommerfeld(aspect, re, way) - 1)
    return max(ratios, key=abs)


def prolate(a, b):
    """Resistances over the viscosity of a prolate spheroid: Happel and Brenner, sections 4-26 and 5-11, and Chwang and Wu 1974."""
    e = math.sqrt(1 - (b / a) ** 2)
    log = math.log((1 + e) / (1 - e))
    return (
        16 * math.pi * a * e**3 / ((1 + e**2) * log - 2 * e),
        32 * math.pi * a * e**3 / (2 * e + (3 * e**2 - 1) * log),
        32 / 3 * math.pi * a**3 * e**3 * (2 - e**2) / ((1 + e**2) * log - 2 * e),
    )


def tirado(aspect):
    """Resistances of a cylinder of diameter 1, along and across: Tirado and Garcia de la Torre, J. Chem. Phys. 71 (1979), 2581."""
    p, log = aspect, math.log(aspect)
    return (
        2 * math.pi * p / (log - 0.207 + 0.980 / p - 0.133 / p**2),
        4 * math.pi * p / (log + 0.839 + 0.185 / p + 0.233 / p**2),
    )


def sphere_radii(contour):
    """Radii of a sphere on the axis within a contour, and of one around it."""
    start, step = contour[:-1], np.diff(contour, axis=0)
    off_axis = (contour[:-1, 1] > 0) | (contour[1:, 1] > 0)
    inner, outer = 0.0, math.inf
    for x in np.linspace(contour[0, 0], contour[-1, 0], 200):
        to = np.array([x, 0.0]) - start
        share = np.clip((to * step).sum(axis=1) / np.maximum((step**2).sum(axis=1), 1e-30), 0, 1)
        gap = np.hypot(*(to - share[:, None] * step).T)[off_axis].min()
        inner, outer = max(inner, gap), min(outer, np.hypot(contour[:, 0] - x, contour[:, 1]).max())
    return inner, outer


@pytest.mark.parametrize("aspect", [1.0001, 1.5, 2, 3, 5, 7, 10])
def test_creeping_spheroids_have_the_resistance_of_their_closed_forms(aspect):
    a, b, viscosity, speed = 0.01 * aspect, 0.01, 1.0, 1e-3
    body = spheroid_body(a, b, edges=200)
    found = [force(body, speed, way, viscosity) / (RHO * viscosity * speed) for way in (ALONG, ACROSS)]
    drag = estimate_drag(body, viscosity)
    torque = still_water_wrench(drag, STILL, (0.0, 1e-3, 0.0), RHO, viscosity)[4]
    assert [*found, -torque / (RHO * viscosity * 1e-3)] == pytest.approx(prolate(a, b), rel=0.011)
    assert spheroid_resistance(a, b) == pytest.approx(prolate(a, b), rel=1e-4)


@pytest.mark.parametrize("radius", [0.02, 3.0])
def test_what_is_nearly_a_sphere_has_its_resistance(radius):
    found = spheroid_resistance(radius * (1 + 1e-6), radius)
    assert found == pytest.approx(np.pi * np.array([6 * radius, 6 * radius, 8 * radius**3]), rel=1e-5)


def test_a_creeping_disc_has_the_resistance_of_its_closed_form():
    # Happel and Brenner, section 5-11: 16 mu a broadside, 32/3 mu a edgewise and as a couple.
    assert creeping_resistance(cylinder_body(1e-5, 1.0).outer)[:3] == pytest.approx((16, 32 / 3, 32 / 3), rel=0.025)


@pytest.mark.parametrize("aspect", [2, 3, 5, 10, 20, 30])
def test_creeping_cylinders_have_the_resistance_that_others_computed(aspect):
    found = creeping_resistance(cylinder_body(aspect, 0.5).outer)[:2]
    assert found == pytest.approx(tirado(aspect), rel=0.07)


def test_no_agent_creeps_faster_or_slower_than_spheres_within_and_around_it():
    """Hill and Power, Quart. J. Mech. Appl. Math. 9 (1956), 313."""
    pipeline, rng = load_study("pipe-inspection").make_pipeline(), np.random.default_rng(5)
    for _ in range(100):
        outer = pipeline.builder.build(pipeline.grammar.express(pipeline.grammar.random(rng))).outer
        inner, around = sphere_radii(outer)
        for k in creeping_resistance(outer)[:2]:
            assert 6 * math.pi * inner < k < 6 * math.pi * around


@pytest.mark.parametrize("way", [ALONG, ACROSS], ids=["along", "across"])
@pytest.mark.parametrize("aspect", [1, 2, 3, 5, 8])
def test_cylinders_have_the_drag_of_hoelzer_and_sommerfeld_at_all_reynolds_numbers(aspect, way):
    assert abs(off_hoelzer_sommerfeld(aspect, way)) < 0.20


@pytest.mark.parametrize(("aspect", "c"), [(2, 0.79), (5, 0.83)])
def test_short_cylinders_have_no_dip_of_their_drag_at_a_reynolds_number_of_2000(aspect, c):
    body, speed = cylinder_body(0.02 * aspect, 0.01), 2e3 * NU / 0.02
    found = force(body, speed, ACROSS) / (0.5 * RHO * speed**2 * 4e-4 * aspect)
    assert hoelzer_sommerfeld(aspect, 2e3, ACROSS) == pytest.approx(c, abs=0.01)
    assert found == pytest.approx(c, rel=0.08)


@given(st.integers(0, 10_000), st.floats(-3, 6), st.floats(1e-6, 0.3), st.sampled_from([ALONG, ACROSS]))
def test_the_drag_of_any_agent_grows_with_its_speed_without_a_jump(seed, decades, more, way):
    pipeline = load_study("pipe-inspection").make_pipeline()
    genome = pipeline.grammar.random(np.random.default_rng(seed))
    body = pipeline.builder.build(pipeline.grammar.express(genome))
    speed = 10**decades * NU / body.max_diameter
    slow, fast = (force(body, v, way) for v in (speed, speed * (1 + more)))
    # The force grows at most with the square of the speed, and a little more where the layer becomes turbulent.
    assert slow < fast < slow * (1 + more) ** 2.4


@pytest.mark.parametrize("aspect", [0.5, 1.0, 4.0])
def test_a_spheroid_in_a_shear_turns_as_jeffery_found(aspect):
    """In u_x = G z, an axis at the angle phi from z turns at G (a^2 cos^2 phi + b^2 sin^2 phi) / (a^2 + b^2)."""
    a, b, G = 0.01 * aspect, 0.01, 3.0
    share = b * b / (a * a + b * b)
    for phi in (0.0, 0.4, 1.2, math.pi / 2):
        axis, normal = np.array([math.sin(phi), math.cos(phi)]), np.array([math.cos(phi), -math.sin(phi)])
        rate = G * (a * a * math.cos(phi) ** 2 + b * b * math.sin(phi) ** 2) / (a * a + b * b)
        # Body axes: x along the axis, z along -normal, y as in the world. Increasing phi is a turn about +y.
        shear = (G * axis[1] * axis[0], 0.0, -G * axis[1] * normal[0])
        creeping = np.array([1.0, 1.0, 1.0, share])
        _, couple = creeping_drag(STILL, (0.0, rate, 0.0), shear, (0.0, G, 0.0), 1.0, creeping)
        assert couple == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)


vectors = st.tuples(*[st.floats(-3, 3)] * 3)


@given(there=vectors, omega=vectors, shear=vectors, curl=vectors, turn=st.floats(0, 2 * math.pi))
def test_creeping_drag_knows_no_direction_across_the_axis(there, omega, shear, curl, turn):
    R = np.array([[1, 0, 0], [0, math.cos(turn), -math.sin(turn)], [0, math.sin(turn), math.cos(turn)]])
    creeping = np.array([1.0, 1.4, 0.3, 0.2])
    force, couple = creeping_drag(there, omega, shear, curl, 1.0, creeping)
    turned = creeping_drag(*(tuple(R @ v) for v in (there, omega, shear, curl)), 1.0, creeping)
    np.testing.assert_allclose(turned, (R @ force, R @ couple), atol=1e-12)


def test_the_page_has_the_errors_from_creeping_to_fast_motion(published):
    lines = [
        "| cylinder, L/d | along, Re 1e-3 to 1e5 | across | creeping along | creeping across |",
        "|---|---|---|---|---|",
    ]
    for aspect in (1, 2, 3, 5, 8, 10):
        found = creeping_resistance(cylinder_body(aspect, 0.5).outer)[:2]
        others = [
            f"{100 * (k / known - 1):+.0f} %" if aspect > 1 else ""
            for k, known in zip(found, tirado(max(aspect, 2)), strict=True)
        ]
        ways = [f"{100 * off_hoelzer_sommerfeld(aspect, way):+.0f} %" for way in (ALONG, ACROSS)]
        lines.append(f"| {' | '.join([str(aspect), *ways, *others])} |")
    published("drag at any Reynolds number", lines)
