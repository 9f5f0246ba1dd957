"""A body as printed, weighed and trimmed, and as it is in its water."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from driftform.agent import hull_mass, mass_properties, solid_of_revolution
from driftform.agent.distance import offset_contour
from driftform.study import load_study
from driftform.testing.bodies import hollow_body
from driftform.types import Detail, Fittings
from driftform.water import Fluid
from driftform.water.disturbances import Condition, Specimen, disturb_fluid
from driftform.water.prints import disturb_body

CALM = Condition()

WATER = Fluid(density=999.1, expansion=1.51e-4, celsius=15.0)


def sphere(radius, count=400):
    angle = np.linspace(np.pi, 0, count)
    return radius * np.column_stack([np.cos(angle), np.abs(np.sin(angle))])


@pytest.fixture
def ball():
    """A hollow sphere of ABS of 80 mm with a wall of 3 mm."""
    body = replace(hollow_body(), expansion=9.5e-5, squeeze=0.002)
    return replace(body, outer=sphere(0.04), cavity=sphere(0.037), wall=0.003)


def net_weight(body, condition, fluid=WATER):
    """Mass less that of the displaced water in flight, kg."""
    mass = mass_properties(disturb_body(condition, body, fluid))
    return mass.mass - disturb_fluid(condition, fluid).density * mass.volume


@given(st.floats(-2e-4, 2e-4))
def test_an_offset_moves_the_surface_of_a_sphere_a_cylinder_and_a_cone_along_its_normal(distance):
    grown = solid_of_revolution(offset_contour(sphere(0.04), distance)).volume
    assert grown - solid_of_revolution(sphere(0.04)).volume == pytest.approx(
        4 / 3 * np.pi * ((0.04 + distance) ** 3 - 0.04**3), rel=1e-3, abs=1e-15
    )
    cylinder = np.array([(-0.1, 0.0), (-0.1, 0.02), (0.1, 0.02), (0.1, 0.0)])
    outward = np.array([(-1, 0), (-1, 1), (1, 1), (1, 0)])
    assert offset_contour(cylinder, distance) == pytest.approx(cylinder + distance * outward, abs=1e-12)
    cone = offset_contour(np.array([(0.0, 0.0), (0.0, 0.03), (0.04, 0.0)]), distance)
    # Its side has the normal (3, 4) / 5: the nose moves by 5/3 of the distance.
    assert cone[-1] == pytest.approx((0.04 + 5 / 3 * distance, 0.0), abs=1e-12)
    assert cone[1, 0] == pytest.approx(-distance, abs=1e-12)


def test_a_condition_without_deviations_leaves_a_body_as_it_is():
    for specimen in (Specimen.PRINT, Specimen.WEIGHED, Specimen.WEIGHED_IN_AIR):
        found = mass_properties(disturb_body(replace(CALM, specimen=specimen), hollow_body(), WATER))
        assert found.mass == pytest.approx(mass_properties(hollow_body()).mass, rel=1e-12)
        assert found.volume == mass_properties(hollow_body()).volume


def test_a_thicker_wall_grows_inward(ball):
    heavier = hull_mass(disturb_body(replace(CALM, wall=2e-5), ball, WATER)) - hull_mass(ball)
    assert heavier == pytest.approx(1050 * 4 / 3 * np.pi * (0.037**3 - (0.037 - 2e-5) ** 3), rel=1e-3)
    # The wall of your own body may not be known.
    solid = replace(ball, wall=0.0)
    assert hull_mass(disturb_body(replace(CALM, wall=2e-5), solid, WATER)) == pytest.approx(hull_mass(ball))


def test_a_print_that_is_too_large_displaces_more_and_weighs_more(ball):
    area, volume = 4 * np.pi * 0.04**2, 4 / 3 * np.pi * 0.04**3 * (1 - 0.002)
    grown = net_weight(ball, replace(CALM, outside=5e-5)) - net_weight(ball, CALM)
    # The wall grows outward: (1050 - 999.1 (1 - squeeze)) kg/m3 of one gram of surface.
    assert grown == pytest.approx(area * 5e-5 * (1050 - 999.1 * 0.998), rel=0.01)
    scaled = net_weight(ball, replace(CALM, scale=1.001)) - net_weight(ball, CALM)
    hull = 1050 * 4 / 3 * np.pi * (0.04**3 - 0.037**3)
    assert scaled == pytest.approx(0.003003 * (hull - 999.1 * volume), rel=0.01)


def test_warmer_water_carries_less_and_a_warmer_hull_more(ball):
    volume = 4 / 3 * np.pi * 0.04**3 * (1 - 0.002)
    warm = net_weight(ball, replace(CALM, warmer=5.0)) - net_weight(ball, CALM)
    assert warm == pytest.approx((999.1 - WATER.density_at(20) * (1 + 5 * 9.5e-5) ** 3) * volume, rel=1e-3)


def test_the_fittings_of_a_kit_warm_and_shrink_with_its_hull():
    pipeline = load_study("pipe-inspection").make_pipeline()
    body = pipeline.build(pipeline.express(pipeline.grammar.random(np.random.default_rng(1))))
    assert abs(body.fittings.material.volume) > 1e-8
    # As of an eyelet outside, which displaces water too.
    ring = body.fittings.material.matrix()
    body = replace(body, fittings=Fittings(details=(Detail("ring", None, None, ring, ring),)))
    warm = disturb_body(replace(CALM, warmer=10.0), body, WATER)
    assert mass_properties(warm).mass == pytest.approx(mass_properties(body).mass, rel=1e-12)
    small = disturb_body(replace(CALM, scale=0.99), body, WATER)
    assert hull_mass(small) == pytest.approx(0.99**3 * hull_mass(body), rel=1e-12)
    volume = mass_properties(body).volume
    assert mass_properties(small).volume == pytest.approx(0.99**3 * volume, rel=1e-12)


def test_a_print_takes_up_water_and_carries_bubbles(ball):
    wet = net_weight(ball, replace(CALM, absorbed=0.002)) - net_weight(ball, CALM)
    assert wet == pytest.approx(0.002 * hull_mass(ball), rel=1e-9)
    for bubble in (1e-7, -1e-7):
        lifted = net_weight(ball, replace(CALM, bubble=bubble)) - net_weight(ball, CALM)
        assert lifted == pytest.approx(-999.1e-7, rel=1e-9)


def follow_procedure(body, condition, fluid):
    """The net weight (kg) in flight of a print that is weighed in a bucket of the main's water, step by step."""
    made = disturb_body(replace(condition, warmer=0.0, absorbed=0.0, bubble=0.0, specimen=Specimen.PRINT), body, fluid)
    volume, bucket = solid_of_revolution(made.outer).volume, fluid.density * condition.density
    design = mass_properties(body)
    # What the maker wants to read: the net weight of the design, and what it changes from the bucket to the main.
    step = condition.warmer + condition.read
    correction = 3 * body.expansion * step - body.squeeze + fluid.density_at(fluid.celsius + step) / fluid.density - 1
    reading = (
        design.mass
        - fluid.density * design.volume
        + fluid.density * solid_of_revolution(body.outer).volume * correction
    )
    mass = reading + condition.left + bucket * volume
    swollen = volume * (1 + body.expansion * condition.expanded * condition.warmer) ** 3
    swollen *= 1 - condition.squeezed * body.squeeze
    main = condition.density * fluid.density_at(fluid.celsius + condition.warmer)
    return mass + condition.absorbed * hull_mass(made) - main * swollen - fluid.density * condition.bubble


deviations = st.floats(-2.5, 2.5)


@given(*[deviations] * 9)
def test_a_print_weighed_in_water_has_the_net_weight_that_the_procedure_gives(a, b, c, d, e, f, g, h, i):
    body = replace(hollow_body(), expansion=9.5e-5, squeeze=0.002)
    body = replace(body, outer=sphere(0.04), cavity=sphere(0.037), wall=0.003)
    condition = replace(
        CALM,
        **{"outside": 5e-5 * a, "scale": 1 + 1e-3 * b, "warmer": 5 * c, "read": 0.2 * d, "expanded": 1 + 0.2 * e},
        **{"squeezed": 1 + 0.2 * f, "absorbed": 1e-3 * abs(g), "bubble": 1e-7 * h, "left": 2e-5 * i},
        **{"mass": 1 + 0.01 * a, "density": 1 + 1e-3 * d, "wall": 2e-5 * g, "specimen": Specimen.WEIGHED},
    )
    # Products of two deviations are left out: 1e-4 of the 268 g that it displaces, a tenth of what is left.
    assert net_weight(body, condition) == pytest.approx(follow_procedure(body, condition, WATER), abs=3e-5)


def test_weighing_in_air_leaves_the_volume_unknown_and_weighing_in_water_does_not(ball):
    design = net_weight(ball, CALM)
    off = replace(CALM, outside=5e-5, mass=1.02, wall=5e-5, left=2e-5)
    in_air = net_weight(ball, replace(off, specimen=Specimen.WEIGHED_IN_AIR))
    assert in_air - design == pytest.approx(2e-5 - 999.1 * 0.998 * 4 * np.pi * 0.04**2 * 5e-5, rel=0.01)
    in_water = net_weight(ball, replace(off, specimen=Specimen.WEIGHED))
    assert in_water - design == pytest.approx(2e-5, abs=1e-9)
