"""A run is its own witness: some of its evaluations are flown again in a fresh process, and must be the same."""

from collections.abc import Iterable
from contextlib import closing

import numpy as np

from driftform.runs.store import Record, Store
from driftform.search.jobs import Job
from driftform.search.local import LocalProcesses
from driftform.study import Study

SAMPLES = 5
"""Evaluations that are flown again, besides the winners."""

MIN_EVALUATIONS = 100
"""Fewest evaluations of a run that is checked: a process takes a second to start."""

_NEAR = 20
"""Evaluations among which a sample is looked for."""


def find_difference(study: Study, store: Store, winners: Iterable[int]) -> str | None:
    """Return in one line which evaluations differ when they are flown again, ``None`` if none does.

    Args:
        winners: evaluations that are flown again for certain.
    """
    targets, count = study.scenario.target_names, store.count()
    if count < MIN_EVALUATIONS:
        return None
    chosen = {index: store.read_record(index, targets) for index in winners}
    # A flight that did not matter was integrated once, if the simulator estimates errors at all.
    checks = any(_is_checked(record) for record in chosen.values())
    for sample in range(SAMPLES):
        for record in store.read_records(targets, sample * count // SAMPLES, _NEAR):
            if _is_checked(record) or not (checks or record.evaluation.failure):
                chosen.setdefault(record.index, record)
                break
    jobs = [Job(index, record.candidate.genome, record.seed) for index, record in chosen.items()]
    with closing(LocalProcesses(study.document, 1)) as fresh:
        again = {index: evaluation for batch in fresh.evaluate(jobs) for index, evaluation in batch}
    different = sorted(
        index
        for index, evaluation in again.items()
        if not np.array_equal(evaluation.fitness, chosen[index].evaluation.fitness)
    )
    if not different:
        return None
    index, fitness = different[0], again[different[0]].fitness
    at = int(np.argmax(fitness != chosen[index].evaluation.fitness))
    return (
        f"{len(different)} of {len(jobs)} evaluations differ when they are flown again in another process, such as {index}: "
        f"fitness {chosen[index].evaluation.fitness[at]:.6g} and {fitness[at]:.6g} for {targets[at]}; a plugin keeps something "
        "between evaluations, or draws random numbers of its own: results depend on the number of workers"
    )


def _is_checked(record: Record) -> bool:
    flight = record.evaluation.trajectory
    return record.evaluation.failure is None and flight is not None and flight.error is not None
