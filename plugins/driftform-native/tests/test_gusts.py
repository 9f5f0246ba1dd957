"""Flights in gusts are less accurate than others, and by how much is known."""

import numpy as np
import pytest

from driftform.motion.approach import closest_approach
from driftform.pipeline import Pipeline
from driftform.study import load_study
from driftform.types import Agent
from driftform.water import Scenario
from driftform.water.flow import TurbulentFlow
from driftform_native.simulator import GUST_RATIO, NativeOptions, NativeSimulator


@pytest.fixture(scope="module")
def pipeline() -> Pipeline:
    return load_study("pipe-inspection", use={"simulator": "native"}).make_pipeline()


def blow(pipeline: Pipeline, seed: int) -> tuple[Agent, Scenario]:
    """A random agent in the gusts of this seed."""
    agent = pipeline.make_agent(pipeline.grammar.random(np.random.default_rng(seed)))
    flow = TurbulentFlow(speed=1.0, roughness=3e-4)
    return agent, pipeline.scenario.model_copy(update={"flow": flow}).with_gusts(seed)


def test_the_misses_of_flights_in_gusts_are_within_a_centimetre_of_exact_ones(pipeline: Pipeline) -> None:
    usual, sharp = NativeSimulator(NativeOptions()), NativeSimulator(NativeOptions(tolerance=1e-9))
    compared = 0
    for seed in range(12):
        agent, scenario = blow(pipeline, seed)
        flight, exact = (simulator.simulate(agent, scenario) for simulator in (usual, sharp))
        assert flight.error is not None
        # Where two integrations end differently, the flight says that its error is not known.
        if flight.end.failed or exact.end.failed or flight.error == np.inf:
            continue
        compared += 1
        assert flight.error <= GUST_RATIO * usual.options.accuracy
        points = scenario.target_array()
        near, far = (closest_approach(way, points)[0] for way in (flight, exact))
        assert np.abs(near - far).max() < GUST_RATIO * usual.options.accuracy
    assert compared >= 10


def test_without_gusts_a_flight_is_as_accurate_as_the_options_say(pipeline: Pipeline) -> None:
    agent, scenario = blow(pipeline, 1)
    calm = scenario.model_copy(update={"flow": pipeline.scenario.flow})
    flight = NativeSimulator(NativeOptions()).simulate(agent, calm)
    assert flight.error is not None and flight.error <= NativeOptions().accuracy
