"""Tuned hulls: the cavity, and a ball beside the core, give the mass that is added, whatever the shape."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from driftform.agent import distance_from, mass_properties, solid_of_revolution
from driftform.testing.builder import random_morphology
from driftform.types import Module, Morphology
from driftform_frusta.builder import FrustaBuilder, FrustaOptions
from driftform_frusta.cores import SIZES_MM
from driftform_frusta.hull import build_printable_hull

STEEL = {"core": "steel-20mm", "material": "ABS"}
WALL = FrustaBuilder(FrustaOptions(tuning="wall", thinnest=0.00125, **STEEL))
BALLS = FrustaBuilder(FrustaOptions(tuning="ballast", **STEEL))
seeds = st.integers(0, 10_000)


def tune(builder, morphology, share):
    """Return a body with some share of what can be added to it, and that mass, kg."""
    low, high = builder.find_tunings(morphology)
    added = low + share * (high - low)
    return builder.build(replace(morphology, tuning=added)), added


@settings(deadline=None, max_examples=60)
@given(seeds, st.floats(0.0, 1.0), st.sampled_from([WALL, BALLS]))
def test_a_tuned_body_weighs_what_is_added_and_keeps_its_outside_and_its_core(seed, share, builder):
    morphology = random_morphology(seed, 12)
    bare, (body, added) = builder.build(morphology), tune(builder, morphology, share)
    assert mass_properties(body).mass == pytest.approx(mass_properties(bare).mass + added, abs=1e-8)
    assert np.array_equal(body.outer, bare.outer)
    assert body.core == bare.core
    # A core of 10 mm has its clearance but for the chords of its room.
    assert distance_from(np.zeros((1, 2)), body.cavity)[0] >= 0.0101
    assert distance_from(body.cavity, body.outer).min() >= 0.00125 - 1e-9


@settings(deadline=None, max_examples=20)
@given(seeds)
def test_more_mass_is_a_smaller_cavity_inside_the_one_before(seed):
    morphology = random_morphology(seed, 12)
    bodies = [tune(WALL, morphology, share)[0] for share in np.linspace(0, 1, 9)]
    plain = [body for body in bodies if not body.ballast.volume]
    volumes = [solid_of_revolution(body.cavity).volume for body in plain]
    assert (np.diff(volumes) < 0).all()
    stations = np.linspace(plain[0].cavity[0, 0], plain[0].cavity[-1, 0], 200)
    radii = [np.interp(stations, *body.cavity.T, left=0, right=0) for body in plain]
    assert all((after <= before + 1e-9).all() for before, after in pairwise(radii))


def test_710_ml_of_abs_with_a_core_of_33_g_are_neutral_with_a_cavity_of_66_ml():
    """By the balance of weight and buoyancy alone: 1050 (V - C) + 0.0328 = 1000 V."""
    morphology = Morphology((Module(0.15, 0.02), Module(0.02, -1.2)), (Module(0.02, 1.3), Module(0.15, -0.02)))
    shape = solid_of_revolution(WALL.build(morphology).outer).volume
    morphology = Morphology(
        *(
            tuple(Module(m.length * (7.1e-4 / shape) ** 0.5, m.tilt) for m in side)
            for side in (morphology.fore, morphology.aft)
        )
    )
    low, high = WALL.find_tunings(morphology)
    bare = mass_properties(WALL.build(morphology))
    body = WALL.build(replace(morphology, tuning=1000 * bare.volume - bare.mass))
    assert low < 1000 * bare.volume - bare.mass < high
    _, solid = build_printable_hull(body, 256)
    mesh = trimesh.Trimesh(solid.vertices, solid.triangles)
    outside, inside = sorted((abs(part.volume) for part in mesh.split(only_watertight=False)), reverse=True)
    assert inside / 1000 == pytest.approx(1e6 * bare.volume * (1 - 1000 / 1050) + 32.8 / 1.05, rel=0.01)
    assert not body.ballast.volume
    assert outside / 1000 == pytest.approx(1e6 * bare.volume, rel=1e-3)


def test_small_bodies_get_the_smallest_ball_to_buy_that_is_enough_in_a_pocket_that_it_fills():
    found = set()
    for seed in range(40):
        body, _ = tune(WALL, random_morphology(seed, 12), 0.97)
        if not body.ballast.volume:
            continue
        diameter = 2000 * (0.75 * body.ballast.volume / np.pi) ** (1 / 3)
        assert round(diameter, 6) in SIZES_MM
        assert body.ballast_density == 7830
        assert body.ballast.volume * body.ballast_density < 0.1
        found.add(round(diameter))
        x, radius = body.ballast.centroid, diameter / 2000
        assert abs(x) == pytest.approx(0.01 + 0.002 + radius)
        # It is put in from the core's room, and rests in a round end, with its clearance.
        for at in np.linspace(0, x, 30):
            assert distance_from(np.array([[at, 0.0]]), body.cavity)[0] >= radius + 0.00019
        assert distance_from(np.array([[x, 0.0]]), body.cavity)[0] == pytest.approx(radius + 0.0002, rel=1e-3)
    assert len(found) > 2


def test_a_study_that_names_no_lead_has_none_and_most_bounds_what_there_is():
    for material in ("steel", "stainless", "tungsten-carbide", "tungsten-putty", "lead"):
        for tuning in ("wall", "ballast"):
            options = FrustaOptions(tuning=tuning, ballast={"material": material, "most": 0.01}, **STEEL)
            for seed in range(8):
                morphology = random_morphology(seed, 12)
                if (bounds := FrustaBuilder(options).find_tunings(morphology)) is None:
                    continue
                body = FrustaBuilder(options).build(replace(morphology, tuning=bounds[1]))
                assert body.ballast.volume * body.ballast_density <= 0.01 + 1e-12
                assert (body.ballast_density == 11340) <= (material == "lead")
    assert FrustaOptions().ballast.material == "steel"


def test_resolved_studies_of_0_2_0_keep_their_balls_of_lead():
    held = FrustaOptions().model_dump(mode="json")
    for key in ("ballast", "max_radius"):
        del held[key]
    older = FrustaBuilder(FrustaOptions.model_validate(held | {"tuning": "ballast", "core_mass": 0.02}))
    assert older.options.ballast.material == "lead"
    named = FrustaOptions(tuning="ballast", core_mass=0.02, ballast={"material": "lead", "most": 1e4})
    morphology = next(m for m in (random_morphology(s, 12) for s in range(30)) if older.find_tunings(m))
    body = older.build(replace(morphology, tuning=0.005))
    assert body.ballast_density * body.ballast.volume == pytest.approx(0.005, rel=1e-12)
    assert older.find_tunings(morphology) == FrustaBuilder(named).find_tunings(morphology)


def test_what_cannot_be_added_is_refused_with_what_can():
    with pytest.raises(ValueError, match=r"5e[+]04 g cannot be added to this hull: it takes 0 to "):
        WALL.build(replace(random_morphology(1, 12), tuning=50.0))


@settings(deadline=None, max_examples=40)
@given(seeds, st.floats(0.0116, 0.05))
def test_no_chain_is_wider_than_allowed_and_narrower_ones_are_as_they_were(seed, radius):
    morphology = random_morphology(seed, 12)
    free = FrustaBuilder(FrustaOptions(**STEEL)).build(morphology)
    bound = FrustaBuilder(FrustaOptions(max_radius=radius, **STEEL)).build(morphology)
    assert bound.max_diameter <= 2 * radius * (1 + 1e-12)
    assert bound.length <= free.length * (1 + 1e-12)
    if free.max_diameter <= 2 * radius:
        assert np.array_equal(bound.outer, free.outer)
