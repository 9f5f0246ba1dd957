"""Flights through the parts of a pipe are those of the other simulator."""

import numpy as np
import pytest

from driftform.study import load_study
from driftform.testing.simulator import largest_distance
from driftform.trajectory.interpolation import interpolate_positions

pytest.importorskip("driftform_native")

NEUTRAL = 12
"""Seed of a random agent that passes the first bend before it touches the wall."""


def test_a_flight_through_the_junction_is_that_of_the_other_simulator_until_it_touches_the_wall():
    flights = []
    for simulator in ("native", "exudyn"):
        study = load_study("t-junction", ["flight.horizon=5"], use={"simulator": simulator})
        pipeline = study.make_pipeline()
        agent = pipeline.make_agent(pipeline.grammar.random(np.random.default_rng(NEUTRAL)))
        flights.append(pipeline.simulator.simulate(agent, pipeline.scenario))
    until = min(f.t[-1] if f.contact is None else f.contact for f in flights)
    times = np.linspace(0.0, until, 200)
    one, other = (interpolate_positions(flight, times) for flight in flights)
    # The first straight ends at x = 1 m.
    assert one[-1, 0] > 1.0
    assert largest_distance(one, other) < 1e-3
