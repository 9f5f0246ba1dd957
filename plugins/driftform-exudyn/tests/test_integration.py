"""Exudyn integrates a motion in the plane as a point, and one in space as a rigid body: both are the same flight."""

from dataclasses import replace

import numpy as np
import pytest

from driftform.motion.coordinates import Motion
from driftform.motion.flight import release_state
from driftform.motion.integrator import greatest_distance
from driftform.motion.model import flight_model
from driftform.study import load_study
from driftform_exudyn import integration
from driftform_exudyn.integration import integrate_motion, make_settings

PIPELINE = load_study("paper").make_pipeline()
SETTINGS = make_settings("DOPRI5", horizon=2.0, tolerance=1e-8, max_step=0.05)


def motions(seed):
    """A motion in the plane, and the same in space."""
    agent, scenario = (
        PIPELINE.make_agent(PIPELINE.grammar.random(np.random.default_rng(seed))),
        PIPELINE.scenario,
    )
    model = flight_model(agent, scenario)
    # Damping whose every coefficient is zero: it changes nothing but that the motion is integrated in space.
    damped = model._replace(numbers=model.numbers.copy())
    damped.numbers["is_damped"] = 1.0
    start = release_state(model, scenario)
    return [Motion.of(m, start) for m in (model, damped)]


@pytest.mark.parametrize("seed", range(6))
def test_a_flight_is_the_same_in_the_plane_and_in_space(seed):
    in_plane, in_space = motions(seed)
    assert (len(in_plane.rates), len(in_space.rates)) == (3, 6)
    here, there = (integrate_motion(motion, SETTINGS, 10_000) for motion in (in_plane, in_space))
    assert here[-1, 0] == there[-1, 0] == 2.0
    assert greatest_distance(here, there) < 1e-5
    assert not here[:, [2, 5, 7, 9, 11, 13]].any()
    # In space nothing holds it in the plane but the equations.
    assert np.abs(there[:, [2, 5, 7, 9, 11, 13]]).max() < 1e-12


@pytest.mark.parametrize("which", ["plane", "space"])
@pytest.mark.parametrize("function", ["accelerations", "fill_sample"])
def test_an_interruption_stops_a_flight_as_it_stops_anything(which, function):
    motion = motions(1)[which == "space"]
    calls = iter(range(100))

    def interrupted(*arguments):
        if next(calls) == 50:
            raise KeyboardInterrupt
        return getattr(motion, function)(*arguments)

    with pytest.raises(KeyboardInterrupt):
        integrate_motion(replace(motion, **{function: interrupted}), SETTINGS, 10_000)


@pytest.mark.parametrize("which", ["plane", "space"])
def test_the_step_limit_ends_a_flight(which):
    motion = motions(1)[which == "space"]
    assert len(integrate_motion(motion, SETTINGS, 17)) == 18


@pytest.mark.parametrize("which", ["plane", "space"])
def test_the_tolerance_grows_along_a_flight_and_the_settings_remain(which, monkeypatch):
    motion = motions(1)[which == "space"]
    growing = integrate_motion(motion, SETTINGS, 10_000)
    assert SETTINGS.timeIntegration.absoluteTolerance == 1e-8
    monkeypatch.setattr(integration.integrator, "grow_tolerance", lambda tolerance, _: tolerance)
    constant = integrate_motion(motion, SETTINGS, 10_000)
    assert len(growing) < 0.95 * len(constant)
