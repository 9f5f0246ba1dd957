"""Flights of evaluations under disturbed conditions: each is flown once, and stored as it arrives."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from driftform.motion.path.targets import find_offsets
from driftform.runs.store import DisturbedResult
from driftform.search.jobs import Job
from driftform.search.journal import Journal
from driftform.search.pool import Executor
from driftform.study import Study
from driftform.types import BoolArray, FloatArray, Genome
from driftform.util.latest import keep_latest
from driftform.water.disturbances import FLOWN, Condition, Specimen, draw_conditions, know_gusts
from driftform.water.scenario import evaluation_seed


@keep_latest
def draw_rounds(study: Study) -> tuple[Condition, ...]:
    """Return the conditions of the choice, and after them those of the promise, for a run of a study.

    The latter are the same for each of what is :data:`~driftform.water.disturbances.FLOWN`: print, weighed print and idle body, in this order. If the gusts are in
    doubt, the weighed print also flies in gusts as ``[gusts]`` describes them, last of all.
    """
    robustness, calibration = study.scenario.robustness, study.scenario.calibration
    choice = draw_conditions(robustness, robustness.conditions, (study.seed, 0), calibration)
    fresh = draw_conditions(robustness, robustness.checks, (study.seed, 1), calibration)
    chosen = Specimen.WEIGHED if robustness.weighed else Specimen.PRINT
    weighed = [replace(condition, specimen=Specimen.WEIGHED) for condition in fresh]
    return (
        *(replace(condition, specimen=chosen) for condition in choice),
        *(replace(condition, specimen=specimen) for specimen in FLOWN for condition in fresh),
        *know_gusts(weighed, study.scenario),
    )


def draw_baseline(study: Study, target: int) -> dict[int, Condition]:
    """Return the conditions of the promise for the baseline of a target, by number; those of all targets follow :func:`draw_rounds`."""
    robustness = study.scenario.robustness
    first = robustness.conditions + (len(FLOWN) + 1 + target) * robustness.checks
    weighed = draw_rounds(study)[robustness.conditions + robustness.checks :][: robustness.checks]
    return {
        number: replace(condition, specimen=Specimen.BASELINE) for number, condition in enumerate(weighed, start=first)
    }


def fly_disturbed(
    study: Study,
    journal: Journal,
    executor: Executor,
    conditions: Sequence[Condition] | Mapping[int, Condition],
    genomes: Mapping[int, Genome],
    pairs: Sequence[tuple[int, int]],
    on_flights: Callable[[int], None] = lambda _: None,
    threshold: tuple[float, ...] | None = None,
    wanted: Mapping[int, BoolArray] | None = None,
) -> dict[tuple[int, int], FloatArray]:
    """Fly each pair of an evaluation and a condition that is not stored; return the fitness (%) of all, (targets,), NaN for none.

    Args:
        journal: takes the flights.
        conditions: by number; a pair holds that of one.
        genomes: by evaluation.
        on_flights: called with the number of pairs that were done since the last call.
        threshold: that of :class:`driftform.search.jobs.Job`.
        wanted: for which targets the flights of an evaluation are, (targets,); all if it is not given. For another target
            they are stored as flights that say nothing, without an offset.
    """
    fitness = journal.read_flights(genomes)
    missing = [pair for pair in pairs if pair not in fitness]
    flown_for = wanted or dict.fromkeys(genomes, np.ones(len(study.scenario.targets), bool))
    jobs = [
        Job(
            number,
            genomes[index],
            evaluation_seed(study.seed, index),
            conditions[condition],
            threshold,
            tuple(flown_for[index].tolist()),
        )
        for number, (index, condition) in enumerate(missing)
    ]
    on_flights(len(pairs) - len(missing))
    for arrived in executor.evaluate(jobs):
        for number, evaluation in arrived:
            index, condition = missing[number]
            at, offsets = flown_for[index], find_offsets(evaluation, study.scenario)
            found, offsets = np.where(at, evaluation.fitness, 0.0), np.where(at[:, None], offsets, np.nan)
            journal.add(DisturbedResult(index, condition, found, offsets, evaluation.failure), evaluation.seconds)
            fitness[index, condition] = np.where(np.isnan(offsets[:, 0]), np.nan, found)
        on_flights(len(arrived))
    return fitness
