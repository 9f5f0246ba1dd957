"""How many genomes make one task."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from driftform.execution import MAX_BATCH
from driftform.execution.jobs import MAX_TASK_S, MIN_TASK_S, task_size


@given(st.integers(1, 10**6), st.integers(1, 500), st.none() | st.floats(0, 1e4))
def test_tasks_are_short_enough_to_be_lost_and_long_enough_to_be_worth_it(
    waiting: int, processes: int, seconds: float | None
) -> None:
    size = task_size(waiting, processes, seconds)
    assert 1 <= size <= min(MAX_BATCH, waiting)
    if seconds is not None:
        assert size == 1 or size * seconds <= MAX_TASK_S
        assert size == min(MAX_BATCH, waiting) or (size + 1) * seconds >= min(MIN_TASK_S, MAX_TASK_S)


@pytest.mark.parametrize("seconds", [0.005, 0.03, 0.2])
def test_the_tasks_of_a_generation_let_two_processes_finish_together(seconds: float) -> None:
    waiting, busy, tasks = 100, [0.0, 0.0], 0
    while waiting:
        size = task_size(waiting, 2, seconds)
        busy[busy.index(min(busy))] += size * seconds
        waiting, tasks = waiting - size, tasks + 1
    assert abs(busy[0] - busy[1]) <= max(seconds, 1.5 * MIN_TASK_S)
    assert tasks <= 30
