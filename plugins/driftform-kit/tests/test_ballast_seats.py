"""Seats for balls of ballast, tried on the meshes of the parts: the ball gets there, lies there, and stays there."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from manifold3d import Manifold
from prints import chain_body

from driftform.agent import mass_properties
from driftform.errors import WorkFailedError
from driftform.testing.builder import random_morphology
from driftform.types import Module, Moments, Morphology
from driftform_frusta.builder import FrustaBuilder, FrustaOptions
from driftform_frusta.kit_options import LEAD, PartOptions
from driftform_frusta.parts import make_parts, settle_ballast
from driftform_kit.cutting.accounting import kit_mass, place_ballast
from driftform_kit.cutting.pieces import make_kit

NOTHING = 1e-3  # mm3


class Held:
    """A kit with one ball of ballast, as meshes in mm, z from the core's centre."""

    def __init__(self, body, x, diameter, **options):
        self.options = PartOptions(kit=True, ballast=[[x, diameter]], **options)
        self.kit = make_kit(body, self.options)
        [self.held] = self.kit.ballast
        lift = 1e3 * body.outer[0, 0]
        self.solids = [part.solid.to_manifold().translate((0.0, 0.0, lift)) for part in make_parts(body, self.options)]
        self.core = Manifold.sphere(1e3 * body.core.radius, 96)
        self.mine = self.solids[self.held.part]

    def ball_at(self, z, shrink=1.0):
        return Manifold.sphere(shrink * self.held.ball.radius, 96).translate((0.0, 0.0, z))

    def sweep(self, start, end):
        """The space that the ball passes on its way, a little less than its radius."""
        radius = 0.995 * self.held.ball.radius
        low, high = sorted((start, end))
        tube = Manifold.cylinder(high - low, radius, radius, 96).translate((0.0, 0.0, low))
        return tube + self.ball_at(start, 0.995) + self.ball_at(end, 0.995)


def check_held(made):
    held, z = made.held, made.held.ball.z
    for solid in (*made.solids, made.core):
        assert (solid ^ made.ball_at(z, 0.999)).volume() < NOTHING
    # Half a millimetre further it meets its seat, or the wall.
    assert (made.mine ^ made.ball_at(z + 0.5 * held.side)).volume() > NOTHING
    # Resting there it cannot roll aside: it is wedged all round.
    shifts = np.linspace(0.0, 0.5, 51)
    rest = next(s for s in shifts if (made.mine ^ made.ball_at(z + s * held.side)).volume() > NOTHING)
    aside = made.ball_at(z + rest * held.side).translate((0.5, 0.0, 0.0))
    on_a_flat_end = (made.mine ^ made.ball_at(z + rest * held.side)).volume()
    assert (made.mine ^ aside).volume() > 2 * on_a_flat_end
    rings = made.kit.pieces[held.part].rings
    if held.mouth is None:
        # Printed upright on the side that it rests on, it is put in from above, at the height of its top.
        assert made.kit.pieces[held.part].fore_down == (held.side > 0)
        lowest = min(-held.side * z for ring in rings for z in ring[:, 1])
        assert made.kit.find_pause(held) == pytest.approx(-held.side * z + held.ball.radius - lowest)
        above = z - held.side * held.ball.radius
        unfinished = made.mine.trim_by_plane((0, 0, held.side), held.side * above)
        assert (unfinished ^ made.sweep(z, z - held.side * 300.0)).volume() < NOTHING
    else:
        assert made.kit.find_pause(held) is None
        assert (made.mine ^ made.sweep(z, z - held.side * 300.0)).volume() < NOTHING


PLACES = st.floats(-0.09, 0.09)
LETTERS = st.text("uns", min_size=2, max_size=9)


@settings(max_examples=25, deadline=None)
@given(LETTERS, LETTERS, PLACES, st.floats(0.003, 0.012))
def test_wherever_a_kit_takes_ballast_the_ball_gets_there_lies_there_and_stays(fore, aft, x, diameter):
    try:
        made = Held(chain_body(fore, aft), x, diameter)
    except WorkFailedError as error:
        assert "no kit can be made" in str(error)
        return
    check_held(made)


def test_most_places_that_a_ball_fits_into_can_hold_it():
    body = chain_body("ssssnuss", "usssn")
    fits = [x for x in np.linspace(-0.045, 0.075, 25) if abs(x) > 0.03]
    taken = 0
    for x in fits:
        try:
            Held(body, float(x), 0.006)
        except WorkFailedError:
            continue
        taken += 1
    assert taken > 0.8 * len(fits)


def test_where_the_hull_narrows_the_wall_holds_it():
    # In a cone of 20 degrees a ball of 8 mm touches the wall where the bore has a radius of 4 / cos(20 deg).
    body = chain_body("sssnnn")
    made = None
    for x in np.linspace(0.035, 0.056, 211):
        try:
            made = Held(body, float(x), 0.008)
        except WorkFailedError:
            continue
        if made.held.seat is None:
            break
    assert made is not None and made.held.seat is None
    check_held(made)
    radius = np.interp(made.held.ball.z + 4 * math.sin(math.radians(20)), *1e3 * body.cavity.T)
    assert radius == pytest.approx(4 * math.cos(math.radians(20)), abs=0.3)
    assert kit_mass(body, made.options).mass == kit_mass(body, PartOptions(kit=True)).mass


@pytest.mark.parametrize("lift", [0.0, 0.2, 0.4])
def test_a_ball_on_a_flat_end_gets_a_seat_that_keeps_it_from_rolling_aside(lift):
    body = chain_body("sssssuu", "ss")
    end = body.cavity[-1, 0]
    assert np.interp(end - 1e-6, *body.cavity.T) > 0.012  # wide and flat
    made = Held(body, end - 0.003 - 1e-3 * lift, 0.006)
    assert made.held.seat is not None
    check_held(made)


def test_a_ball_beyond_a_neck_is_put_in_while_its_part_is_printed():
    body = chain_body("nnnuuuss", "ss")
    neck = np.interp(0.03, *body.cavity.T)
    assert 2e3 * neck < 8
    made = Held(body, 0.065, 0.010)
    assert made.held.mouth is None
    check_held(made)


@pytest.mark.parametrize(("fore", "x"), [("uunnnnuuuussssnnnn", 0.08), ("unnnuuuusssnnn", 0.06)])
def test_a_hull_is_cut_once_more_where_a_ball_has_no_way_in(fore, x):
    body = chain_body(fore, "nn")
    made = Held(body, x, 0.02)
    check_held(made)
    assert len(make_kit(body, PartOptions(kit=True)).joints) + 1 == len(made.kit.joints)


def test_in_a_wide_hull_near_its_end_a_tube_is_lighter_than_a_cone():
    body = chain_body("uuuuuuuss")
    made = Held(body, 0.075, 0.008)
    low, high = made.held.seat.section.bounds()[0], made.held.seat.section.bounds()[2]
    assert high - low < 0.5 * 2e3 * np.interp(0.075, *body.cavity.T)
    check_held(made)


def test_a_seat_of_ballast_needs_no_support():
    body = chain_body("ssssss", "ss")
    plain, made = make_kit(body, PartOptions(kit=True)), Held(body, 0.045, 0.008)
    for before, after in zip(plain.pieces, made.kit.pieces, strict=True):
        assert after.fore_down == before.fore_down
        overhang = after.overhang - before.overhang
        # The rim of the seat, one line wide, which begins in the air as that of the core does.
        assert overhang < 2 * math.pi * 4 * 1.3


@pytest.mark.parametrize(
    ("x", "diameter", "why"),
    [
        (0.002, 0.004, "the core is there, or passes there"),
        (0.2, 0.004, "it is not in the cavity"),
        (0.045, 0.030, "the bore is narrower there"),
    ],
)
def test_ballast_that_cannot_be_held_is_refused_with_the_reason(x, diameter, why):
    with pytest.raises(WorkFailedError, match=why):
        Held(chain_body("ssssss", "ss"), x, diameter)


@pytest.mark.parametrize("material", ["lead", "steel"])
def test_the_kit_of_a_tuned_body_weighs_and_balances_as_simulated(material):
    """Ball and seat together have the mass and the moment of the ballast that flew."""
    options = FrustaOptions(tuning="ballast", ballast={"material": material}, made_as="kit", core_mass=0.02)
    builder, tried = FrustaBuilder(options), 0
    for seed in range(60):
        morphology = random_morphology(seed, 12)
        try:
            bounds = builder.find_tunings(morphology)
        except WorkFailedError:
            continue
        if bounds is None:
            continue
        try:
            body = builder.build(replace(morphology, tuning=bounds[1] / 1.5))
        except WorkFailedError:
            continue
        options = settle_ballast(body, PartOptions(kit=True))
        [(x, diameter)] = options.ballast
        printed, ball = kit_mass(body, options), body.ballast_density * math.pi / 6 * diameter**3
        assert material == "lead" or 1000 * diameter == round(1000 * diameter)
        simulated = mass_properties(body)
        assert printed.mass + ball == pytest.approx(simulated.mass, abs=5e-6)
        # Where the ball makes room for the core, its seat moves the centre of gravity a little.
        cog = (printed.mass * printed.cog[0] + ball * x) / simulated.mass
        assert cog == pytest.approx(simulated.cog[0], abs=1e-5 if x != round(body.ballast.centroid, 7) else 5e-4)
        tried += 1
        if tried == 5:
            return
    raise AssertionError(f"only {tried} bodies of 60 have a kit with ballast")


def test_a_ball_whose_seat_weighs_more_than_the_ballast_is_refused():
    body = FrustaBuilder(FrustaOptions(tuning="ballast")).build(Morphology((Module(0.05, 0.2), Module(0.02, 0.0)), ()))
    light = replace(body, ballast=Moments(1e-9, 2e-11), ballast_density=LEAD)
    with pytest.raises(WorkFailedError, match="no kit can be made"):
        place_ballast(light, PartOptions(kit=True))
