"""Flights in gusts are less accurate than others, and by how much is known."""

from dataclasses import replace

import numpy as np
import pytest

from driftform.motion.path.approach import closest_approach
from driftform.motion.path.targets import find_offsets
from driftform.motion.solver.error import GUST_RATIO
from driftform.study import load_study
from driftform.water.disturbances import draw_conditions
from driftform.water.flow import TurbulentFlow
from driftform.water.scenario import Robustness
from driftform_native.simulator import NativeOptions, NativeSimulator

RIDER = (
    "C: addF-tiltp-1-M-moveN-addB-tiltn-2-S-moveN-addF-tiltn-1-L-moveF | S: addB-tiltn-0-M-moveF-addB-tiltp-1-L-moveB-"
    "addB-tiltp-2-L-moveF | M: addF-tiltp-0-S-moveF-addB-tiltp-2-L-moveF-addB-tiltn-0-S-moveB | L: addF-tiltp-1-M-moveB-"
    "addF-tiltp-1-L-moveN-addB-tiltn-1-M-moveF"
)


@pytest.fixture(scope="module")
def pipeline():
    return load_study("pipe-inspection", use={"simulator": "native"}).make_pipeline()


def blow(pipeline, seed):
    """A random agent in the gusts of this seed."""
    agent = pipeline.make_agent(pipeline.grammar.random(np.random.default_rng(seed)))
    flow = TurbulentFlow(speed=1.0, roughness=3e-4)
    return agent, pipeline.scenario.model_copy(update={"flow": flow}).with_gusts(seed)


def test_the_misses_of_flights_in_gusts_are_within_a_centimetre_of_exact_ones(pipeline):
    usual, sharp = NativeSimulator(NativeOptions()), NativeSimulator(NativeOptions(tolerance=1e-9))
    within, accurate = GUST_RATIO * usual.options.accuracy, 0
    for seed in range(12):
        agent, scenario = blow(pipeline, seed)
        flight, exact = (simulator.simulate(agent, scenario) for simulator in (usual, sharp))
        assert flight.error is not None and not flight.end.failed and not exact.end.failed
        # A path that no tolerance fixes says so.
        assert flight.error < 0.2
        accurate += flight.error <= within
        points = scenario.target_array()
        near, far = (closest_approach(way, points)[0] for way in (flight, exact))
        assert np.abs(near - far).max() < within
    assert accurate >= 10


@pytest.mark.long
def test_paths_along_the_wall_differ_with_the_tolerance_and_how_far_nine_of_ten_miss_does_not():
    # It rides the wall to TP8, wide and thin, with a ball of lead; its flights are those of a run that need the most steps.
    lead = ("builder.tuning='ballast'", "builder.ballast={material='lead', most=1.0}", "builder.pressure=0")
    settings = (*lead, "builder.max_radius=0", "release.port=0", "builder.pockets.diameter=0")
    pipeline = load_study("pipe-inspection", settings, use={"simulator": "native"}).make_pipeline()
    rider = replace(pipeline.grammar.parse(RIDER), tuning=0.5796)
    conditions = draw_conditions(Robustness(), 100, (4,))
    sharp = replace(pipeline, simulator=NativeSimulator(NativeOptions(tolerance=1e-8)))
    usual, exact = (
        made.evaluate([rider] * len(conditions), conditions=conditions, thresholds=[None] * len(conditions))
        for made in (pipeline, sharp)
    )
    errors = [flight.trajectory.error for flight in usual if flight.trajectory is not None]
    assert np.mean(np.array(errors) > 0.01) > 0.2, "many of these paths are chaotic"
    near, far = (
        np.array([np.linalg.norm(find_offsets(flight, pipeline.scenario)[7]) for flight in flights])
        for flights in (usual, exact)
    )
    assert np.abs(near - far).max() > 5e-3
    drawn = np.random.default_rng(3).integers(0, len(far), (300, len(far)))
    for share in (0.5, 0.9):
        spread = float(np.std(np.quantile(far[drawn], share, axis=1)))
        assert abs(np.quantile(near, share) - np.quantile(far, share)) < spread


def test_without_gusts_a_flight_is_as_accurate_as_the_options_say(pipeline):
    agent, scenario = blow(pipeline, 1)
    calm = scenario.model_copy(update={"flow": pipeline.scenario.flow})
    flight = NativeSimulator(NativeOptions()).simulate(agent, calm)
    assert flight.error is not None and flight.error <= NativeOptions().accuracy
