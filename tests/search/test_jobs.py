"""How many genomes make one task, and what comes back of them."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from driftform.motion.path.targets import find_offsets
from driftform.runs.compression import decode
from driftform.search.jobs import MAX_BATCH, MAX_TASK_S, MIN_TASK_S, Job, evaluate_batch, rehearse, task_size
from driftform.study import load_study
from driftform.water.disturbances import draw_conditions


@given(st.integers(1, 10**6), st.integers(1, 500), st.none() | st.floats(0, 1e4))
def test_tasks_are_short_enough_to_be_lost_and_long_enough_to_be_worth_it(waiting, processes, seconds):
    size = task_size(waiting, processes, seconds)
    assert 1 <= size <= min(MAX_BATCH, waiting)
    if seconds is not None:
        assert size == 1 or size * seconds <= MAX_TASK_S
        assert size == min(MAX_BATCH, waiting) or (size + 1) * seconds >= min(MIN_TASK_S, MAX_TASK_S)


@pytest.mark.parametrize("seconds", [0.005, 0.03, 0.2])
def test_the_tasks_of_a_generation_let_two_processes_finish_together(seconds):
    waiting, busy, tasks = 100, [0.0, 0.0], 0
    while waiting:
        size = task_size(waiting, 2, seconds)
        busy[busy.index(min(busy))] += size * seconds
        waiting, tasks = waiting - size, tasks + 1
    assert abs(busy[0] - busy[1]) <= max(seconds, 1.5 * MIN_TASK_S)
    assert tasks <= 30


def test_of_a_disturbed_flight_no_more_comes_back_than_a_run_stores():
    study = load_study("paper", targets=["TP2", "TP6"], run={"seed": 1})
    pipeline = study.make_pipeline()
    genome = pipeline.grammar.random(np.random.default_rng(1))
    [condition] = draw_conditions(study.scenario.robustness, 1, (1,))
    [whole] = pipeline.evaluate([genome], conditions=[condition])
    (_, kept), (_, disturbed) = evaluate_batch(pipeline, [Job(0, genome), Job(1, genome, condition=condition)])
    assert kept.trajectory is not None
    read_back = replace(kept, trajectory=decode(vars(kept.trajectory)["blob"], kept.trajectory.end), offsets=None)
    np.testing.assert_array_equal(kept.offsets, find_offsets(read_back, study.scenario))
    assert not {"t", "position"} & vars(kept.trajectory).keys()
    assert disturbed.trajectory is None
    np.testing.assert_array_equal(find_offsets(disturbed, study.scenario), find_offsets(whole, study.scenario))


@pytest.mark.parametrize("conditions", [0, 5])
def test_a_rehearsal_is_one_flight_under_the_conditions_of_the_study(conditions):
    study = load_study("paper", ["flight.horizon=0.2", f"robustness.conditions={conditions}"])
    pipeline, flown = study.make_pipeline(), []

    class Observed(type(pipeline.simulator)):  # type: ignore[misc]
        def simulate_batch(self, agents, scenarios):
            flown.extend(scenarios)
            return super().simulate_batch(agents, scenarios)

    pipeline = replace(pipeline, simulator=Observed(pipeline.simulator.options))
    rehearse(pipeline)
    assert len(flown) == (conditions > 0)
    assert all(scenario.release != study.scenario.release for scenario in flown)
