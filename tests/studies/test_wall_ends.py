"""Does every flight with friction on the wall end, at the outlet or at the horizon?"""

from collections import Counter
from itertools import repeat

import numpy as np
import pytest

from driftform.study import load_study
from driftform.types import End

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("study", ["paper", "pipe-inspection"])
def test_no_agent_on_a_rough_wall_reaches_the_step_limit(study, workers, count_of):
    count = count_of("AGENTS", 1000)
    pipeline = load_study(study, ["contact.friction=0.3"], use={"simulator": "native"}).make_pipeline()
    rng = np.random.default_rng(11)
    agents = [pipeline.make_agent(pipeline.grammar.random(rng)) for _ in range(count)]
    flights = workers.map(pipeline.simulator.simulate, agents, repeat(pipeline.scenario.with_gusts(1)))
    ends = Counter(flight.end for flight in flights)
    assert ends[End.STEP_LIMIT] == 0
    # Bounces may amplify any error; such a flight says so.
    assert sum(number for end, number in ends.items() if end.failed) <= 0.02 * count, ends
