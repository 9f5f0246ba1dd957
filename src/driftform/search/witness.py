"""A run is its own witness: some of its evaluations are flown again in a fresh process, and must be the same."""

from collections.abc import Iterable
from contextlib import closing
from dataclasses import replace

import numpy as np

from driftform.motion.path.targets import approach_targets
from driftform.plugins.registry import registry
from driftform.runs.store import Record, Store
from driftform.search.jobs import Job
from driftform.search.local import LocalProcesses
from driftform.study import Study

SAMPLES = 5
"""Evaluations that are flown again, besides the winners."""

MIN_EVALUATIONS = 100
"""Fewest evaluations of a run that is checked: a process takes a second to start."""

OTHERS = {"native": "exudyn", "exudyn": "native"}
"""The simulator that flies the winners of another once more."""

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


def find_dissent(study: Study, store: Store, winners: Iterable[int]) -> str | None:
    """Return in one line which winners another simulator sees pass their targets elsewhere than both state, ``None`` if none.

    Args:
        winners: evaluations; those whose flight has no estimated error say nothing.
    """
    targets, other = study.scenario.target_names, OTHERS.get(study.document["simulator"]["use"])
    known = [row.name for row in registry().seam("simulator") if row.available]
    if store.count() < MIN_EVALUATIONS or other not in known:
        return None
    pipeline = replace(study.make_pipeline(), simulator=registry().create("simulator", other, {}))
    records = [record for record in (store.read_record(index, targets) for index in winners) if _is_checked(record)]
    found = []
    for record in records:
        [again] = pipeline.evaluate([record.candidate.genome], [record.seed])
        flights = (record.evaluation.trajectory, again.trajectory)
        passes = [(approach_targets(f, study.scenario)[0], f.error) for f in flights if f and f.error is not None]
        if again.failure is None and len(passes) == 2:
            (miss, error), (other_miss, other_error) = passes
            away = np.abs(miss - other_miss)
            found += [(float(away.max()), error + other_error, record.index, targets[int(away.argmax())])]
    found = sorted((row for row in found if row[0] > row[1]), reverse=True)
    if not found:
        return None
    apart, error, index, target = found[0]
    return (
        f"{len(found)} of {len(records)} winners pass their targets elsewhere by the simulator '{other}', beyond the stated "
        f"errors, such as {index}: {1000 * apart:.3g} mm apart at {target}, with errors of {1000 * error:.3g} mm"
    )


def _is_checked(record: Record) -> bool:
    flight = record.evaluation.trajectory
    return record.evaluation.failure is None and flight is not None and flight.error is not None
