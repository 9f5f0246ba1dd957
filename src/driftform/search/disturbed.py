"""Flights of evaluations under disturbed conditions: each is flown once, and stored as it arrives."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace

import numpy as np

from driftform.agent.plain import PlainBody
from driftform.motion.path.targets import find_offsets
from driftform.runs.store import DisturbedResult, Store
from driftform.search.jobs import UNWRITTEN_S, Executor, Job
from driftform.study import Study
from driftform.types import BoolArray
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


def draw_baseline(study: Study, target: int, plain: PlainBody) -> dict[int, Condition]:
    """Return the conditions of the promise for the baseline of a target, by number; those of all targets follow :func:`draw_rounds`."""
    robustness = study.scenario.robustness
    first = robustness.conditions + (len(FLOWN) + 1 + target) * robustness.checks
    weighed = draw_rounds(study)[robustness.conditions + robustness.checks :][: robustness.checks]
    return {
        number: replace(condition, specimen=Specimen.BASELINE, plain=plain)
        for number, condition in enumerate(weighed, start=first)
    }


def fly_disturbed(
    study: Study,
    store: Store,
    executor: Executor,
    conditions: Sequence[Condition] | Mapping[int, Condition],
    flights: Iterable[tuple[int, int]],
    on_flights: Callable[[int], None] = lambda _: None,
    threshold: tuple[float, ...] | None = None,
    wanted: Mapping[int, BoolArray] | None = None,
) -> int:
    """Fly each missing pair of an evaluation and a condition, and store it; return the number of all pairs.

    Args:
        conditions: by number; a pair holds that of one.
        flights: pairs of an evaluation and a condition.
        on_flights: called with the number of pairs that are done.
        threshold: that of :class:`driftform.search.Job`.
        wanted: for which targets the flights of an evaluation are, (targets,); all if it is not given. For another target
            they are stored as flights that say nothing, without an offset.
    """
    targets = study.scenario.target_names
    pairs = list(flights)
    indices = {index for index, _ in pairs}
    # A flight has a result for each target.
    flown = store.read_disturbed(targets[0], min(indices, default=0), max(indices, default=-1) + 1)
    missing = [(index, condition) for index, condition in pairs if condition not in flown.get(index, ())]
    genomes = {index: store.read_genome(index) for index in {index for index, _ in missing}}
    flown_for = {index: np.ones(len(targets), bool) if wanted is None else wanted[index] for index in genomes}
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
    count = len(pairs) - len(missing)
    on_flights(count)
    unwritten, seconds = list[DisturbedResult](), 0.0
    with ExitStack() as at_end:
        # Also where the run is interrupted.
        at_end.callback(lambda: store.add_disturbed(unwritten, targets))
        for arrived in executor.evaluate(jobs):
            for number, evaluation in arrived:
                index, condition = missing[number]
                at, offsets = flown_for[index], find_offsets(evaluation, study.scenario)
                fitness, offsets = np.where(at, evaluation.fitness, 0.0), np.where(at[:, None], offsets, np.nan)
                unwritten.append(DisturbedResult(index, condition, fitness, offsets, evaluation.failure))
                seconds += evaluation.seconds
            if seconds > UNWRITTEN_S:
                store.add_disturbed(unwritten, targets)
                unwritten, seconds = [], 0.0
            count += len(arrived)
            on_flights(count)
    return len(pairs)
