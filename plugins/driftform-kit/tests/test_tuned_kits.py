"""Kits of neutral bodies of the default study: they can be made, hold the core, and weigh what is simulated."""

import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from manifold3d import Manifold
from prints import job_of
from scipy.optimize import brentq

from driftform import load_study
from driftform.agent import MassElement, mass_properties
from driftform.interfaces import PrintJob
from driftform_frusta.exporters.threemf import ThreeMfExporter
from driftform_frusta.kit_options import PartOptions
from driftform_frusta.parts import make_parts, settle_ballast
from driftform_kit.cutting.accounting import kit_mass
from driftform_kit.cutting.pieces import make_kit

WATER = 999.1
PIPELINE = load_study("pipe-inspection").make_pipeline()
SHARES = (None, 0.0, 0.97)
"""Of what can be added; ``None`` for what makes the body neutral."""


@cache
def draw_bodies(share, count=20):
    """Return random bodies that can be neutral."""
    rng, bodies = np.random.default_rng(57), []
    while len(bodies) < count:
        morphology = PIPELINE.express(PIPELINE.grammar.random(rng))
        low, high = PIPELINE.builder.find_tunings(morphology) or (0.0, 0.0)

        def weigh(added, morphology=morphology):
            mass = mass_properties(PIPELINE.build(replace(morphology, tuning=added)))
            return mass.mass - WATER * mass.volume

        if weigh(low) < 0 < weigh(high):
            added = brentq(weigh, low, high, xtol=1e-7) if share is None else low + share * (high - low)
            bodies.append(PIPELINE.build(replace(morphology, tuning=added)))
    return tuple(bodies)


def list_options(share, count=20):
    return [(body, settle_ballast(body, PartOptions(kit=True))) for body in draw_bodies(share, count)]


@pytest.mark.parametrize("share", SHARES)
def test_the_meshes_of_a_kit_with_core_and_ball_weigh_what_is_simulated(share):
    for body, options in list_options(share):
        ball = body.ballast.volume * body.ballast_density
        printed = sum(part.solid.volume for part in make_parts(body, options)) * 1e-9 * body.hull_density
        whole = mass_properties(body)
        putty = [MassElement.of_putty(pocket) for pocket in body.pockets]
        ball += sum(one.mass for one in putty)
        assert printed + body.core.mass + ball == pytest.approx(whole.mass, abs=2e-5)
        made = kit_mass(body, options)
        assert made.mass + ball == pytest.approx(whole.mass, abs=1e-8)
        moment = made.mass * made.cog[0] + body.ballast.first * body.ballast_density
        moment += sum(one.mass * one.x for one in putty)
        assert moment == pytest.approx(whole.mass * whole.cog[0], abs=1e-8)


@pytest.mark.long
@pytest.mark.parametrize("share", SHARES)
def test_parts_core_and_ball_have_their_places_and_do_not_overlap(share):
    for body, options in list_options(share):
        lift = 1e3 * body.outer[0, 0]
        solids = [part.solid.to_manifold().translate((0, 0, lift)) for part in make_parts(body, options)]
        solids.append(Manifold.sphere(1e3 * body.core.radius, 96))
        for x, diameter in options.ballast:
            solids.append(Manifold.sphere(500 * diameter, 96).translate((0, 0, 1e3 * x)))
        for index, one in enumerate(solids):
            assert all((one ^ other).volume() < 0.05 for other in solids[index + 1 :])


@pytest.mark.peers
@pytest.mark.parametrize("count", [1, pytest.param(10, marks=pytest.mark.slow)])
def test_a_slicer_prints_the_mass_that_is_stated_to_a_hundredth(count, ask, tmp_path):
    for body, options in list_options(None, count):
        stated = sum(part.solid.volume for part in make_parts(body, options)) / 1000
        plates = ThreeMfExporter(options).write(job_of(body), tmp_path / "agent.3mf")
        paths = tuple(Path(file.path) for file in plates if file.path.endswith(".3mf"))
        printed = re.search(
            r"filament ([\d.]+) cm3", ask("prusa-slicer", PrintJob(paths))["prusa-slicer g-code"].detail
        )[1]
        print(f"{stated:.2f} cm3 stated, {printed} cm3 printed")
        assert float(printed) == pytest.approx(stated, rel=0.01)


def test_a_ball_goes_in_by_the_joint_of_the_core_and_rests_on_the_wall_of_its_pocket():
    kits = [make_kit(body, options) for body, options in list_options(0.97) if options.ballast]
    assert len(kits) > 5
    for kit in kits:
        [held] = kit.ballast
        assert held.seat is None
        assert kit.joints[held.mouth] is kit.core_joint


def test_no_neutral_body_of_the_default_study_needs_ballast_or_exceeds_the_port():
    for body in draw_bodies(None):
        assert not body.ballast.volume
        assert body.max_diameter <= PIPELINE.scenario.release.port
