"""Ballast balances to the last digit, and lies where there is room for it."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from driftform.agent import MassElement, mass_properties
from driftform.types import Agent, Body, Coefficients, Core
from driftform_kit.ballast import (
    FOAM,
    MATERIALS,
    PUTTY,
    max_ball_radius,
    place_by_hand,
    place_filling,
    place_one_ball,
    required_ballast,
)
from driftform_kit.kit import KitReport
from driftform_kit.trim import _lift, weigh_print

LEAD = MATERIALS["lead"]


def tube(bore=0.012, aft=0.05, fore=0.08, wall=0.002):
    """A capped tube with a core of 10 mm radius in it."""
    outer = [(-aft, 0), (-aft, bore + wall), (fore, bore + wall), (fore, 0)]
    cavity = [(-aft + wall, 0), (-aft + wall, bore), (fore - wall, bore), (fore - wall, 0)]
    return Body(np.array(outer), np.array(cavity), np.array([-aft, fore]), Core(0.01, 0.05), wall, 1050.0)


BODY = tube()
SIMULATED = mass_properties(BODY)
AGENT = Agent(BODY, SIMULATED, Coefficients(0.01 * np.eye(6)))


def place_ballast(body, wanted, density):
    """Return the first that fits: a ball, a filling."""
    return place_one_ball(body, wanted, density) or place_filling(body, wanted, density)


def place_nearest(body, wanted, density):
    """Return the filling as near as possible to where it should be."""
    return place_filling(body, wanted, density, nearest=True)


@given(missing=st.floats(1e-4, 8e-3), at=st.floats(0.022, 0.06))
@settings(deadline=None)
def test_print_and_ballast_weigh_and_balance_as_simulated(missing, at):
    mass = SIMULATED.mass - missing
    x = (SIMULATED.mass * float(SIMULATED.cog[0]) - missing * at) / mass
    printed = MassElement.reweigh(AGENT, MassElement.of_print(BODY, mass, x))
    wanted = required_ballast(SIMULATED, printed.mass)
    found = place_ballast(BODY, wanted, LEAD)
    assume(found)
    elements = [*MassElement.of_print(BODY, mass, x), *(piece.element for piece in found)]
    trimmed = MassElement.reweigh(AGENT, elements).mass
    assert trimmed.mass == pytest.approx(SIMULATED.mass, rel=1e-9)
    assert trimmed.cog[0] == pytest.approx(SIMULATED.cog[0], abs=1e-7)


@given(mass=st.floats(1e-5, 0.3), x=st.floats(-0.045, 0.075), density=st.sampled_from(list(MATERIALS.values())))
@settings(deadline=None)
def test_pieces_lie_in_the_bore_beside_the_core(mass, x, density):
    for piece in place_ballast(BODY, MassElement(mass, x), density):
        assert -0.048 - 1e-9 <= piece.start < piece.end <= 0.078 + 1e-9
        if piece.diameter is not None:
            assert piece.diameter / 2 <= 0.012 + 1e-9
            assert abs(piece.element.x) >= 0.01 + piece.diameter / 2 - 1e-9
            assert piece.diameter == pytest.approx(np.cbrt(6 * piece.element.mass / (np.pi * density)))


def test_a_filling_where_no_ball_has_room():
    # Half of 300 g of lead is a ball of 29 mm in a bore of 24 mm; all of it as a plug is 58 mm long.
    [piece] = place_ballast(BODY, MassElement(0.3, 0.045), LEAD)
    assert piece.diameter is None
    assert piece.end - piece.start == pytest.approx(0.3 / LEAD / (np.pi * 0.012**2), rel=1e-3)
    assert piece.element.x == pytest.approx(0.045, abs=1e-6)
    # A cylinder: m (3 r^2 + l^2) / 12 across, m r^2 / 2 along.
    length = piece.end - piece.start
    assert piece.element.axial == pytest.approx(0.3 * 0.012**2 / 2, rel=2e-3)
    assert piece.element.transverse == pytest.approx(0.3 * (3 * 0.012**2 + length**2) / 12, rel=2e-3)


@given(mass=st.floats(0.25, 0.4), share=st.floats(0, 0.999))
@settings(deadline=None)
def test_a_filling_has_its_centre_where_the_ballast_is_wanted(mass, share):
    aftmost, foremost = (place_nearest(BODY, MassElement(mass, end), LEAD)[0].element.x for end in (-1.0, 1.0))
    x = aftmost + share * (foremost - aftmost)
    [piece] = place_ballast(BODY, MassElement(mass, x), LEAD)
    assert piece.diameter is None
    assert piece.element.mass == pytest.approx(mass, rel=1e-9)
    assert piece.element.x == pytest.approx(x, abs=1e-10)


def test_all_of_the_bore_but_the_core_can_be_filled():
    volume = np.pi * 0.012**2 * 0.126 - 4 / 3 * np.pi * 0.01**3
    for share, room in ((0.999, True), (1.001, False)):
        wanted = MassElement(share * volume * LEAD, 0.0)
        assert bool(place_nearest(BODY, wanted, LEAD)) is room


@pytest.mark.parametrize(
    ("body", "wanted"),
    [
        (BODY, MassElement(2.0, 0.02)),
        (Body(BODY.outer, np.empty((0, 2)), BODY.joints, BODY.core, 0.002, 1050.0), MassElement(0.001, 0.0)),
        (BODY, required_ballast(SIMULATED, SIMULATED)),
    ],
    ids=["more than the bore holds", "a solid body", "nothing missing"],
)
def test_what_has_no_room_or_needs_none_has_no_pieces(body, wanted):
    assert place_ballast(body, wanted, LEAD) == place_nearest(body, wanted, LEAD) == ()


def test_foam_moves_the_centre_of_buoyancy_towards_it():
    required = MassElement(-0.01, 0.03)
    lifted, foam = _lift(AGENT, [MassElement(SIMULATED.mass + 0.01, SIMULATED.cog[0])], required, 1000.0)
    assert foam["volume"] == pytest.approx(0.01 / (1000.0 - FOAM)) and foam["x"] == pytest.approx(0.03)
    moment = SIMULATED.volume * SIMULATED.cob[0] + foam["volume"] * 0.03
    assert lifted.mass.cob[0] == pytest.approx(moment / (SIMULATED.volume + foam["volume"]))


def test_what_a_kit_weighs_more_or_less_is_hull_also_beside_a_core_off_its_centre():
    agent = replace(AGENT, body=replace(BODY, core=Core(0.01, 0.05, cog=0.004)))
    kit = KitReport(0.08, (0.03 * 0.02 + 0.05 * 0.004) / 0.08)
    weight = weigh_print(agent, 0.09, None, kit)
    assert weight.cog == pytest.approx((0.04 * 0.02 + 0.05 * 0.004) / 0.09)


def test_room_ends_at_the_walls_and_at_the_core():
    x = np.array([-0.06, -0.047, 0.0, 0.009, 0.015, 0.04, 0.076, 0.079])
    np.testing.assert_allclose(max_ball_radius(BODY, x), [0, 0.001, 0, 0, 0.005, 0.012, 0.002, 0], atol=1e-12)


@given(mass=st.floats(1e-5, 5e-4), x=st.floats(-0.045, 0.075))
@settings(deadline=None)
def test_no_filling_is_thinner_than_a_millimetre(mass, x):
    wanted = MassElement(mass, x)
    for found in (place_ballast(BODY, wanted, LEAD), place_nearest(BODY, wanted, LEAD)):
        assert all(piece.end - piece.start >= 1e-3 - 1e-9 for piece in found if piece.diameter is None)


def test_a_little_by_hand_is_a_ring_of_putty_on_the_wall_and_more_fills_the_bore():
    [filling] = place_by_hand(BODY, MassElement(0.3, 0.045), LEAD)
    assert filling.ring is None and filling.putty == 0
    [piece] = place_by_hand(BODY, MassElement(0.0005, 0.03), LEAD)
    assert piece.diameter is None and piece.ring is not None and piece.putty == piece.element.mass == 0.0005
    volume = np.pi * (0.012**2 - (0.012 - piece.ring) ** 2) * (piece.end - piece.start)
    assert volume * PUTTY == pytest.approx(0.0005) and piece.end - piece.start == pytest.approx(piece.ring)
    # A thin ring: m r^2 about the axis.
    assert piece.element.axial == pytest.approx(0.0005 * (0.012 - piece.ring / 2) ** 2, rel=1e-2)
    assert piece.element.transverse == pytest.approx(piece.element.axial / 2 + 0.0005 * piece.ring**2 / 12, rel=1e-12)


def test_by_hand_too_ballast_comes_as_near_as_it_can():
    [piece] = place_by_hand(BODY, MassElement(0.0005, -0.06), LEAD)
    assert -0.048 <= piece.start < -0.046
