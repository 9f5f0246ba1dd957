"""Flights through the parts of a pipe are those of the other simulator."""

import numpy as np
import pytest

from driftform.motion.path.interpolation import interpolate_positions
from driftform.study import load_study
from driftform.testing.simulator import largest_distance

pytestmark = pytest.mark.long

SEED, DENSITY = 24, 1182.0
"""Seed of a random agent, and the density of the water (kg/m3) in which it floats long enough to pass into a bend or a tee."""


@pytest.mark.parametrize(
    ("place", "yaw", "axis", "passed"),
    [((0.8, 0.0, 0.0), 0.0, 0, 1.0), ((1.3, -1.25, 0.03), -90.0, 1, -1.45)],
    ids=["bend", "junction"],
)
def test_a_flight_through_a_part_is_that_of_the_other_simulator_until_it_touches_the_wall(place, yaw, axis, passed):
    settings = [
        *("flight.horizon=2", "builder.pockets.diameter=0"),
        f"fluid.density={DENSITY}",
        f"release.position={list(place)}",
        f"release.yaw_deg={yaw}",
    ]
    flights = []
    for simulator in ("native", "exudyn"):
        pipeline = load_study("t-junction", settings, use={"simulator": simulator}).make_pipeline()
        agent = pipeline.make_agent(pipeline.grammar.random(np.random.default_rng(SEED)))
        flights.append(pipeline.simulator.simulate(agent, pipeline.scenario))
    until = min(f.t[-1] if f.contact is None else f.contact for f in flights)
    times = np.linspace(0.0, until, 200)
    one, other = (interpolate_positions(flight, times) for flight in flights)
    # It has entered the part before it touches.
    assert abs(one[-1, axis]) > abs(passed)
    assert largest_distance(one, other) < 1e-3
