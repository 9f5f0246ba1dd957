"""Flights of evaluations under disturbed conditions: each is flown once, and stored as it arrives."""

from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache

from driftform.execution import Executor, Job
from driftform.runs.store import DisturbedResult, Store
from driftform.scenario import Calibration, Robustness, Scenario, evaluation_seed
from driftform.scenario.disturbances import Condition, draw_conditions
from driftform.study import Study
from driftform.trajectory.way import find_offsets


def draw_rounds(scenario: Scenario, seed: int) -> tuple[Condition, ...]:
    """Return the conditions of the choice, and after them those of the promise, for a run with this seed."""
    return _draw_rounds(scenario.robustness, scenario.calibration, seed)


@lru_cache(maxsize=8)
def _draw_rounds(robustness: Robustness, calibration: Calibration, seed: int) -> tuple[Condition, ...]:
    """Draw the conditions once for all targets of a run."""
    return (
        *draw_conditions(robustness, robustness.conditions, (seed, 0), calibration),
        *draw_conditions(robustness, robustness.checks, (seed, 1), calibration),
    )


def fly_disturbed(
    study: Study,
    store: Store,
    executor: Executor,
    conditions: Sequence[Condition],
    wanted: Iterable[tuple[int, int]],
    on_flights: Callable[[int], None] = lambda _: None,
    threshold: tuple[float, ...] | None = None,
) -> int:
    """Fly each missing pair of an evaluation and a condition, and store it; return the number of all pairs.

    Parameters
    ----------
    conditions
        all of them; a pair holds the index of one.
    wanted
        pairs of an evaluation and a condition.
    on_flights
        called with the number of pairs that are done.
    threshold
        that of :class:`driftform.execution.Job`.
    """
    targets = study.scenario.target_names
    pairs = list(wanted)
    done = store.list_disturbed()
    missing = [pair for pair in pairs if pair not in done]
    genomes = {index: store.read_record(index, targets).candidate.genome for index in {i for i, _ in missing}}
    jobs = [
        Job(number, genomes[index], evaluation_seed(study.seed, index), conditions[condition], threshold)
        for number, (index, condition) in enumerate(missing)
    ]
    count = len(pairs) - len(missing)
    on_flights(count)
    for arrived in executor.evaluate(jobs):
        store.add_disturbed(
            [
                DisturbedResult(
                    *missing[number], flown.fitness, find_offsets(flown, study.scenario), flown.failure
                )
                for number, flown in arrived
            ],
            targets,
        )
        count += len(arrived)
        on_flights(count)
    return len(pairs)
