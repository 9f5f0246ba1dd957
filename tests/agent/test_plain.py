"""The plainest body around a core."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from driftform.agent import mass_properties
from driftform.agent.plain import MIN_WALL, PlainBody, find_size, make_plain_body
from driftform.testing.bodies import hollow_body
from driftform.types import Core

STEEL = Core(0.01, 0.0328)


def body_of(core=STEEL, density=1050.0):
    return replace(hollow_body(), core=core, hull_density=density)


@given(st.floats(0.06, 0.12), st.floats(-0.004, 0.004))
def test_a_plain_sphere_is_a_sphere_with_its_net_weight(diameter, net):
    body = make_plain_body(PlainBody(diameter, diameter, net), body_of(), 999.1)
    found, radius = mass_properties(body), diameter / 2
    assert found.volume == pytest.approx(np.pi / 6 * diameter**3, rel=2e-3)
    assert found.mass - 999.1 * found.volume == pytest.approx(net, abs=1e-7)
    assert np.hypot(*body.outer.T) == pytest.approx(radius) and np.hypot(*body.cavity.T) == pytest.approx(
        radius - body.wall
    )
    assert MIN_WALL <= body.wall <= radius - STEEL.radius and found.cog[0] == pytest.approx(0, abs=1e-12)


def test_a_capsule_has_the_volume_of_a_cylinder_with_two_half_spheres():
    body = make_plain_body(PlainBody(0.05, 0.12, 0.0), body_of(), 999.1)
    volume = np.pi * 0.025**2 * (0.07 + 4 / 3 * 0.025)
    assert mass_properties(body).volume == pytest.approx(volume, rel=2e-3)
    assert (body.length, body.max_diameter) == pytest.approx((0.12, 0.05))


def test_the_size_is_a_sphere_if_that_floats_the_core_and_else_the_shortest_capsule():
    assert find_size(body_of(), 999.1, 0.06) == PlainBody(0.06, 0.06, 0.0)
    # A sphere of 40 mm displaces 33.5 g: less than its core and the thinnest wall weigh.
    slim = find_size(body_of(), 999.1, 0.04)
    assert slim is not None and slim.length > 0.04 and slim.kind.startswith("capsule of 40 x ")
    shorter = replace(slim, length=slim.length - 0.004, net_weight=-0.02 * 999.1 * np.pi / 6 * 0.04**3)
    with pytest.raises(ValueError, match="no wall gives"):
        make_plain_body(shorter, body_of(), 999.1)
    assert find_size(body_of(Core(0.01, 30.0)), 999.1, 0.04) is None
