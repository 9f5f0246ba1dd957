"""Flights of random agents through the built-in junction: both simulators agree, nothing passes a wall, and both outlets are found."""

from collections import Counter
from itertools import repeat

import numpy as np
import pytest

from driftform.motion.path.interpolation import interpolate_positions
from driftform.motion.path.targets import name_outlet
from driftform.study import load_study
from driftform.testing.simulator import largest_distance
from driftform.types import End

pytestmark = pytest.mark.slow

MILLIMETRE = 1e-3

HORIZON = 1.5
"""Duration of the flights by both simulators, s: agents touch the wall within about 1 s."""


def make_agents(pipeline, count, seed):
    rng = np.random.default_rng(seed)
    return [pipeline.make_agent(pipeline.grammar.random(rng)) for _ in range(count)]


def fly_all(workers, use, agents, *settings):
    pipeline = load_study("t-junction", settings, use={"simulator": use}).make_pipeline()
    return workers.map(pipeline.simulator.simulate, agents, repeat(pipeline.scenario))


def test_both_simulators_fly_alike_until_the_wall_is_touched(workers, count_of):
    """Nearly all agents touch the wall within the first seconds; what follows along it is chaotic, and not compared."""
    agents = make_agents(load_study("t-junction").make_pipeline(), count_of("AGENTS", 200), 1)
    flown = [fly_all(workers, use, agents, f"flight.horizon={HORIZON}") for use in ("native", "exudyn")]
    apart, touches = [], 0
    for one, other in zip(*flown, strict=True):
        until = min(f.t[-1] if f.contact is None else f.contact for f in (one, other))
        times = np.linspace(0.0, until, 200)
        paths = [interpolate_positions(flight, times) for flight in (one, other)]
        apart.append(largest_distance(*paths))
        touches += one.contact is not None
    print(
        f"{len(agents)} agents, {touches} of which touch the wall within {HORIZON} s: positions up to then differ by at most "
        f"{1000 * max(apart):.2g} mm, {1000 * np.median(apart):.2g} mm in the median"
    )
    assert max(apart) < MILLIMETRE


def test_no_random_agent_passes_a_wall_and_every_end_has_a_name(workers, count_of):
    pipeline = load_study("t-junction").make_pipeline()
    agents = make_agents(pipeline, count_of("AGENTS", 10_000), 2)
    layout, ends = pipeline.scenario.pipe.layout, Counter[str]()
    for number, flight in enumerate(fly_all(workers, "native", agents), 1):
        if number % 500 == 0:
            print(f"{number} of {len(agents)} agents: {dict(ends)}", flush=True)
        assert flight.end is not End.NON_FINITE
        outlet = name_outlet(flight, pipeline.scenario)
        assert (outlet is not None) == (flight.end is End.OUTLET)
        ends[outlet or flight.end.value] += 1
        # Upstream of the inlet an agent may turn back.
        inside = layout.find_part(flight.position[:-1]) >= 0
        along = (flight.position[:-1] - layout.inlet.centre) @ layout.inlet.axes[0]
        assert (inside | (along < 0)).all()
    assert ends["riser"] > 0 and ends["main"] > 0
