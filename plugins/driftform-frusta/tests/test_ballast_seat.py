"""Ballast at its seat: where it lies, what it weighs, and what has no room."""

from dataclasses import replace

import numpy as np
import pytest

from driftform.agent import mass_properties
from driftform.testing.builder import random_morphology
from driftform_frusta.builder import FrustaBuilder, FrustaOptions
from driftform_frusta.cores import BallastOptions
from driftform_frusta.kit_options import LEAD
from driftform_frusta.load import SPARE, WATER, find_max_ballast, place_ballast

BUILDER = FrustaBuilder(FrustaOptions(tuning="ballast", ballast=BallastOptions(material="lead"), core_mass=0.02))
BODIES = [BUILDER.build(random_morphology(seed, 12)) for seed in range(30)]
BUOYANT = [body for body in BODIES if find_max_ballast(body, LEAD) > 0]


def test_ballast_makes_a_buoyant_body_float_freely_with_some_to_spare():
    assert len(BUOYANT) > 3
    for body in BUOYANT:
        bare = mass_properties(body)
        lacking = WATER * bare.volume - bare.mass
        assert 0 < find_max_ballast(body, LEAD) <= SPARE * lacking * (1 + 1e-12)


def test_a_body_that_sinks_needs_no_ballast():
    heavy = replace(BUOYANT[0], hull_density=20_000.0)
    assert find_max_ballast(heavy, LEAD) == 0.0
    assert BUILDER.find_tunings(random_morphology(0, 4)) is None


@pytest.mark.parametrize("share", [0.1, 0.5, 1.0])
def test_the_ball_is_inside_the_cavity_and_beside_the_core(share):
    for body in BUOYANT:
        ball = place_ballast(body, share * find_max_ballast(body, LEAD), LEAD)
        radius = (0.75 * ball.volume / np.pi) ** (1 / 3)
        assert abs(ball.centroid) >= body.core.radius + radius
        around = np.linspace(0, np.pi, 50)
        x, r = ball.centroid + radius * np.cos(around), radius * np.sin(around)
        assert (np.interp(x, *body.cavity.T) >= r).all()


def test_the_tuned_body_weighs_the_ballast_more_and_balances_at_their_common_centre():
    morphology = next(m for m in (random_morphology(s, 12) for s in range(30)) if BUILDER.find_tunings(m))
    bare, mass = mass_properties(BUILDER.build(morphology)), 0.005
    body = BUILDER.build(replace(morphology, tuning=mass))
    tuned, ball = mass_properties(body), body.ballast
    assert body.ballast_density == LEAD
    assert tuned.mass == pytest.approx(bare.mass + mass, rel=1e-12)
    assert tuned.mass * tuned.cog[0] == pytest.approx(bare.mass * bare.cog[0] + mass * ball.centroid)
    # A sphere: 2/5 m R^2 about each axis through its centre, and Steiner about the common centre.
    own = 0.4 * mass * (0.75 * ball.volume / np.pi) ** (2 / 3)
    apart = bare.mass * mass / tuned.mass * (ball.centroid - bare.cog[0]) ** 2
    assert tuned.inertia[0, 0] == pytest.approx(bare.inertia[0, 0] + own)
    assert tuned.inertia[1, 1] == pytest.approx(bare.inertia[1, 1] + own + apart)
    assert tuned.volume == bare.volume


def test_ballast_that_has_no_room_is_refused_with_what_has():
    with pytest.raises(ValueError, match="the hull has room for"):
        place_ballast(BUOYANT[0], 100.0, LEAD)
