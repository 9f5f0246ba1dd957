"""Trim pockets: what they weigh and displace, where a hull has them, and that its solid has them too."""

import math
from dataclasses import replace

import numpy as np
import pytest
from prints import chain_body

from driftform.agent import MassElement, distance_from, mass_properties
from driftform.types import Pocket
from driftform_frusta.hull import build_printable_hull

POCKETS = {"diameter": 0.005}
WATER = 1000.0


def weigh(body):
    """The net weight of a body in water, kg."""
    mass = mass_properties(body)
    return mass.mass - WATER * mass.volume


@pytest.mark.parametrize("way", [1, -1])
def test_putty_has_the_mass_and_the_place_of_a_cone_and_a_cylinder(way):
    r, depth = 0.003, 0.02
    pocket = Pocket(way * 0.05, way * (0.05 - depth), r, 0.5, 10_200.0)
    bore = (depth - 2 / 3 * r) / 2 - r / 3
    cone, rest = math.pi * r**3 / 3, math.pi * r**2 * bore
    putty = MassElement.of_putty(pocket)
    assert putty.mass == pytest.approx(10_200 * (cone + rest))
    x = (cone * 3 / 4 * r + rest * (r + bore / 2)) / (cone + rest)
    assert putty.x == pytest.approx(way * (0.05 - depth + x))
    assert putty.axial == pytest.approx(10_200 * (0.3 * cone + 0.5 * rest) * r**2)


def test_putty_in_a_pocket_adds_its_own_weight_in_water_and_the_pocket_displaces_nothing():
    body, plain = (chain_body("sssssss", "ssssss", pockets=p) for p in (POCKETS, {}))
    assert len(body.pockets) == 2 and np.array_equal(body.outer, plain.outer)
    putty = sum(MassElement.of_putty(pocket).mass for pocket in body.pockets)
    least, most = body.trim_range(WATER)
    assert most == pytest.approx(-least) == pytest.approx((1 - WATER / 10_200) * putty)
    empty = replace(body, pockets=tuple(replace(pocket, filled=0.0) for pocket in body.pockets))
    assert weigh(body) - weigh(empty) == pytest.approx(most, rel=1e-9)


def test_the_solid_of_a_hull_has_its_pockets_a_wall_away_from_its_cavity():
    body = chain_body("sssssss", "ssssss", pockets=POCKETS)
    solid = build_printable_hull(body, 128)[1]
    assert len(solid.shells) == 2
    for pocket in body.pockets:
        assert distance_from(pocket.contour(), body.cavity).min() >= body.wall - 1e-9
        middle = 1e3 * ((pocket.mouth + pocket.tip) / 2 - body.outer[0, 0])
        assert solid.to_manifold().slice(middle).num_contour() == 2
        assert 1e3 * abs(pocket.mouth - pocket.tip) == pytest.approx(25.0)


def test_a_pocket_needs_a_flat_end_that_is_long_and_wide_enough():
    assert [pocket.mouth > 0 for pocket in chain_body("sssssss", "", pockets=POCKETS).pockets] == [True]
    assert chain_body("sss", "nnnnnnn", pockets=POCKETS).pockets == ()
