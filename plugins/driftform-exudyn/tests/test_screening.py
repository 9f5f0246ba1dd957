"""Which agents of a search Exudyn does not fly, and the flight that is returned instead."""

import numpy as np

from driftform.motion.interpolation import interpolate_positions
from driftform.pipeline import CLOSE_MARGIN, MARGIN
from driftform.study import load_study
from driftform.testing.simulator import largest_distance

PIPELINE = load_study("paper", use={"simulator": "exudyn"}).make_pipeline()
GENOMES = [PIPELINE.grammar.random(np.random.default_rng(seed)) for seed in range(8)]


def test_a_second_flight_of_known_error_may_show_that_the_first_does_not_matter():
    agents, scenario = [PIPELINE.make_agent(genome) for genome in GENOMES], PIPELINE.scenario
    known = []

    def matters(index, trajectory):
        known.append(trajectory.error)
        return trajectory.error is None

    flights = PIPELINE.simulator.screen_batch(agents, [scenario] * len(agents), matters)
    assert [error is None for error in known] == [True, False] * len(agents)
    assert max(known[1::2]) < 0.4e-3
    for agent, flight in zip(agents, flights, strict=True):
        checked = PIPELINE.simulator.simulate(agent, scenario)
        assert flight.error is None
        times = np.linspace(0.0, min(flight.t[-1], checked.t[-1]), 101)
        assert largest_distance(*(interpolate_positions(f, times) for f in (flight, checked))) < 1e-3


def test_exudyn_flies_what_is_at_most_the_close_margin_below_its_threshold():
    checked = PIPELINE.evaluate(GENOMES)
    for below in (0.5 * CLOSE_MARGIN, 0.5 * MARGIN):
        thresholds = [tuple(evaluation.fitness + below) for evaluation in checked]
        for evaluation in PIPELINE.evaluate(GENOMES, thresholds=thresholds):
            assert (evaluation.trajectory.error is None) == (below > CLOSE_MARGIN)
