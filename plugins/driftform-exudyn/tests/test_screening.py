"""Which agents of a search Exudyn does not fly, and the flight that is returned instead."""

import numpy as np
import pytest

from driftform.motion.path.interpolation import interpolate_positions
from driftform.motion.solver import error
from driftform.study import load_study
from driftform.testing.simulator import largest_distance

PIPELINE = load_study("paper", use={"simulator": "exudyn"}).make_pipeline()
GENOMES = [PIPELINE.grammar.random(np.random.default_rng(seed)) for seed in range(4)]


def test_a_flight_that_does_not_matter_is_the_first_of_two():
    agents, scenario = [PIPELINE.make_agent(genome) for genome in GENOMES], PIPELINE.scenario
    seen = []

    def matters(index, trajectory):
        seen.append(trajectory.error)
        return index == 0

    flights = PIPELINE.simulator.screen_batch(agents, [scenario] * len(agents), matters)
    assert seen == [None] * len(agents)
    for agent, flight in zip(agents, flights, strict=True):
        checked = PIPELINE.simulator.simulate(agent, scenario)
        assert (flight.error is None) == (agent is not agents[0])
        times = np.linspace(0.0, min(flight.t[-1], checked.t[-1]), 101)
        assert largest_distance(*(interpolate_positions(f, times) for f in (flight, checked))) < 0.05


def test_exudyn_flies_without_the_native_integrator(monkeypatch):
    def refuse(*_, **__):
        raise AssertionError("the native integrator was called")

    for module, name in ((error, "integrate"), (error, "integrate_once"), (error, "take_all_steps")):
        monkeypatch.setattr(module, name, refuse)
    with pytest.raises(AssertionError, match="native"):
        load_study("paper", use={"simulator": "native"}).make_pipeline().simulator.simulate(
            PIPELINE.make_agent(GENOMES[0]), PIPELINE.scenario
        )
    [checked] = PIPELINE.evaluate(GENOMES[:1])
    [unchecked] = PIPELINE.evaluate(GENOMES[:1], thresholds=[(100.0,) * 10])
    assert checked.trajectory.error <= 1e-3 and unchecked.trajectory.error is None
