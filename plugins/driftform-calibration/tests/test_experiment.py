"""Plans of drops: releases inside the tank, gains that become smaller, and intervals that fits then have."""

from dataclasses import replace

import numpy as np
import pytest
from made_films import Filming, film_flight

from driftform.errors import WorkFailedError
from driftform.water import Factors
from driftform_calibration.bench import Bench
from driftform_calibration.experiment import MARGIN, drop_design, list_candidates
from driftform_calibration.fit import fit_factors
from driftform_calibration.protocol import Tank

pytestmark = pytest.mark.long

SIZE = (0.6, 0.4, 0.5)
TANK = Tank(*SIZE)


def make_plan(design, count, noise=0.002):
    return drop_design(design, SIZE, drops=count, noise=noise)


@pytest.fixture(scope="module")
def plan(design):
    return make_plan(design, 3)


def test_every_release_that_is_compared_is_in_the_water(design):
    bench = Bench.of(design.pipeline, design.agent.morphology)
    candidates = list_candidates(bench, TANK)
    assert len(candidates) > 10
    reach = float(np.hypot(*bench.body.outer.T).max())
    for scenario in candidates:
        depth = -scenario.release.position[2]
        assert MARGIN < depth < TANK.depth - MARGIN
        assert depth < reach + 2 * MARGIN, "an agent that sinks is released near the surface"


def test_each_drop_tells_less_than_the_one_before(plan):
    gains = [drop.gain for drop in plan.drops]
    assert gains == sorted(gains, reverse=True)
    assert gains[-1] > 0


def test_more_drops_and_less_noise_make_intervals_narrower(design, plan):
    one, quiet = make_plan(design, 1), make_plan(design, 3, 0.0005)
    for name, (half, _) in plan.expected.items():
        assert quiet.expected[name][0] < half < one.expected[name][0]


def test_fits_of_the_planned_drops_have_the_intervals_that_the_plan_expects(design, plan):
    bench, rng = Bench.of(design.pipeline, design.agent.morphology), np.random.default_rng(11)
    films = [
        film_flight(replace(bench, scenario=drop.scenario), Factors(), rng, Filming(longest=drop.duration))
        for drop in plan.drops
    ]
    fit = fit_factors(films)
    both = [name for name in fit.known if name in plan.expected and plan.expected[name][1]]
    assert both
    for name in both:
        found = fit.estimates[name]
        ratio = (found.high - found.low) / 2 / found.value / plan.expected[name][0]
        assert 1 / 3 < ratio < 3, name


def test_a_tank_in_which_nothing_can_be_filmed_is_refused(design):
    with pytest.raises(WorkFailedError, match="take a deeper tank, or more frames"):
        drop_design(design, SIZE, drops=1, fps=1.0)
