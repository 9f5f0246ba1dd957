"""Motions that Exudyn integrates."""

from dataclasses import replace

import numpy as np
import pytest

from driftform.motion.coordinates import Motion
from driftform.motion.flight import release_state
from driftform.motion.integrator import Accuracy, greatest_distance, integrate
from driftform.motion.model import flight_model
from driftform.motion.plane import stays_in_plane
from driftform.study import load_study
from driftform_exudyn import integration
from driftform_exudyn.integration import integrate_motion, make_settings

PIPELINE = load_study("paper").make_pipeline()
SETTINGS = make_settings("DOPRI5", horizon=2.0, tolerance=1e-8, max_step=0.05)


def make_motion(seed):
    """The model of a random agent, its state at the release, and its motion."""
    agent, scenario = (
        PIPELINE.make_agent(PIPELINE.grammar.random(np.random.default_rng(seed))),
        PIPELINE.scenario,
    )
    model = flight_model(agent, scenario)
    start = release_state(model, scenario)
    return model, start, Motion.of(model, start)


@pytest.mark.parametrize("seed", range(6))
def test_a_flight_is_the_same_as_in_the_plane(seed):
    model, start, motion = make_motion(seed)
    assert stays_in_plane(start, model)
    here = integrate(model, start, 2.0, Accuracy(1e-6, tolerance=1e-8)).samples
    there = integrate_motion(motion, SETTINGS, 10_000)
    assert here[-1, 0] == there[-1, 0] == 2.0
    assert greatest_distance(here, there) < 1e-5
    # Nothing holds it in the plane but the equations.
    assert np.abs(there[:, [2, 5, 7, 9, 11, 13]]).max() < 1e-12


@pytest.mark.parametrize("function", ["accelerations", "fill_sample"])
def test_an_interruption_stops_a_flight_as_it_stops_anything(function):
    motion = make_motion(1)[2]
    calls = iter(range(100))

    def interrupted(*arguments):
        if next(calls) == 50:
            raise KeyboardInterrupt
        return getattr(motion, function)(*arguments)

    with pytest.raises(KeyboardInterrupt):
        integrate_motion(replace(motion, **{function: interrupted}), SETTINGS, 10_000)


def test_the_step_limit_ends_a_flight():
    motion = make_motion(1)[2]
    assert len(integrate_motion(motion, SETTINGS, 17)) == 18


def test_the_tolerance_grows_along_a_flight_and_the_settings_remain(monkeypatch):
    motion = make_motion(1)[2]
    growing = integrate_motion(motion, SETTINGS, 10_000)
    assert SETTINGS.timeIntegration.absoluteTolerance == 1e-8
    monkeypatch.setattr(integration.integrator, "grow_tolerance", lambda tolerance, _: tolerance)
    constant = integrate_motion(motion, SETTINGS, 10_000)
    assert len(growing) < 0.95 * len(constant)
