"""Flights of random agents through a bend on a grid of 20 cells per bore are those in its analytic flow, at a similar cost."""

import time

import numpy as np
import pytest

from driftform.motion.path.interpolation import interpolate_positions
from driftform.study import load_study
from driftform.testing.simulator import largest_distance
from driftform.water import Scenario
from driftform_tees.currents import sample_current, write_current

pytestmark = pytest.mark.slow

BEND = {
    "pipe": {
        "radius": 0.1,
        "parts": [{"length": 0.5}, {"kind": "bend", "radius": 0.3, "roll_deg": 90}, {"length": 0.5}],
    },
    "flow": {"kind": "uniform", "speed": 0.5},
    "release": {"position": (0.05, 0.0, 0.0)},
}
"""A level bend of a bore of 200 mm."""

ROUNDS = 3


def test_flights_on_a_grid_are_within_a_millimetre_at_most_at_three_times_the_cost(tmp_path, count_of):
    analytic = Scenario.model_validate(BEND)
    file = tmp_path / "bend.csv"
    write_current(file, sample_current(analytic))
    sampled = Scenario.model_validate(
        {**BEND, "flow": {"kind": "grid", "file": str(file), "speed": 0.5, "reference": 0.5}}
    )
    pipeline, rng = load_study("t-junction").make_pipeline(), np.random.default_rng(3)
    agents = [pipeline.make_agent(pipeline.grammar.random(rng)) for _ in range(count_of("AGENTS", 40))]
    apart, ratios = [], []
    for agent in agents:
        flights, costs = [], []
        for scenario in (analytic, sampled):
            seconds = []
            for _ in range(ROUNDS):
                start = time.process_time()
                flight = pipeline.simulator.simulate(agent, scenario)
                seconds.append(time.process_time() - start)
            flights.append(flight)
            costs.append(min(seconds))
        until = min(f.t[-1] if f.contact is None else f.contact for f in flights)
        times = np.linspace(0.0, until, 200)
        apart.append(largest_distance(*(interpolate_positions(flight, times) for flight in flights)))
        ratios.append(costs[1] / costs[0])
    print(
        f"{len(agents)} agents: at most {1000 * max(apart):.2g} mm apart up to the first touch, {1000 * np.median(apart):.2g} mm in "
        f"the median; a flight on the grid takes {np.median(ratios):.2g} times as long in the median, {max(ratios):.2g} at most"
    )
    assert max(apart) < 1e-3
    assert max(ratios) < 3
