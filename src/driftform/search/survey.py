"""The survey: agents of the search that may be among the best are flown under a few disturbed conditions.

An agent that passes a target within a millimetre in the mean flow may owe that to a balance which the weight of a print
upsets. A strategy that receives the fitness under disturbed conditions breeds agents that do not.

The undisturbed flight counts as one of these conditions. Without it, agents that slide along the wall half a metre from
their target, whatever disturbs them, would displace those that reach it, and a search could not leave them any more.
"""

from collections.abc import Sequence
from dataclasses import replace
from math import inf

import numpy as np

from driftform.runs.store import Store
from driftform.search.disturbed import draw_rounds, fly_disturbed
from driftform.search.jobs import Executor
from driftform.study import Study
from driftform.types import Candidate, Evaluation, FloatArray
from driftform.water.scenario import Robustness


def count_survey(robustness: Robustness) -> int:
    """Return the number of disturbed flights of an agent that matters to the search."""
    return min(robustness.survey, robustness.conditions)


class Survey:
    """The race of a run's agents under the first conditions of the choice, the same for all.

    It is run in stages: few conditions for many agents, many for few. An agent goes on while, for a target that it is
    among the best for, its mean over the conditions so far is among those of the best earlier agents over the same conditions.

    Args:
        study: the study of the run; without disturbed conditions nothing is flown.
    """

    def __init__(self, study: Study) -> None:
        robustness, targets = study.scenario.robustness, study.scenario.target_names
        count = count_survey(robustness)
        self._study = study
        self._conditions = draw_rounds(study) if count else ()
        self._stages = sorted({count // 4, count // 2, count} - {0})
        self._best = {stage: np.full((robustness.finalists, len(targets)), -np.inf) for stage in self._stages}

    def fly(
        self,
        store: Store,
        executor: Executor,
        first: int,
        candidates: Sequence[Candidate],
        evaluations: Sequence[Evaluation],
    ) -> list[Evaluation]:
        """Return what a strategy is given for a batch: evaluations with the mean fitness of all flights of an agent.

        An agent is surveyed if its undisturbed fitness exceeds its ``threshold`` for some target: any other fitness does
        not matter to its strategy. An agent without a threshold is not surveyed.

        Args:
            first: index of the first evaluation.
            candidates, evaluations: the batch, and its undisturbed flights.
        """
        targets, given = self._study.scenario.target_names, list(evaluations)
        matters = {
            number: evaluation.fitness > np.array(candidate.threshold)
            for number, (candidate, evaluation) in enumerate(zip(candidates, evaluations, strict=True))
            if evaluation.failure is None and candidate.threshold is not None
        }
        alive = [number for number, at in matters.items() if at.any()]
        flown = 0
        for stage in self._stages if alive else ():
            pairs = [(first + number, condition) for number in alive for condition in range(flown, stage)]
            # The error of an unchecked flight is far below the differences that decide.
            fly_disturbed(self._study, store, executor, self._conditions, pairs, threshold=(inf,) * len(targets))
            flights = read_flights(store, targets, stage, first, first + len(candidates))
            for number in alive:
                mean = _mean_fitness(evaluations[number].fitness, flights[first + number])
                given[number] = replace(given[number], fitness=mean)
            best, flown = self._best[stage], stage
            added = [given[number].fitness for number in alive]
            alive = [n for n in alive if np.any((given[n].fitness > best[0])[matters[n]])]
            if added:
                self._best[stage] = np.sort(np.vstack([best, *added]), axis=0)[-len(best) :]
        return given


def read_scores(study: Study, store: Store) -> dict[int, FloatArray]:
    """Return the fitness by which finalists are chosen, for each target, by evaluation: that which a strategy is given.

    With a survey it has only those that were flown under all its conditions, if there are any.
    """
    targets, count = study.scenario.target_names, count_survey(study.scenario.robustness)
    undisturbed = {
        brief.index: np.array(brief.fitness) for brief in store.read_summaries(targets) if brief.failure is None
    }
    surveyed = read_flights(store, targets, count, 0, store.last_index() + 1) if count else {}
    if surveyed:
        return {index: _mean_fitness(undisturbed[index], flights) for index, flights in surveyed.items()}
    return undisturbed


def _mean_fitness(undisturbed: FloatArray, disturbed: FloatArray) -> FloatArray:
    """Return the mean of an undisturbed flight, (targets,), and of disturbed ones, (flights, targets), NaN if they failed."""
    flights = np.vstack([undisturbed, disturbed])
    return np.asarray(np.nanmean(flights, axis=0) if np.isnan(disturbed).any() else flights.mean(axis=0))


def read_flights(store: Store, targets: Sequence[str], count: int, first: int, end: int) -> dict[int, FloatArray]:
    """Return the fitness of the first ``count`` disturbed flights, (count, targets), of evaluations that have all."""
    columns = [store.read_disturbed(target, first, end) for target in targets]
    return {
        index: np.array([[column[index][number] for column in columns] for number in range(count)])
        for index, flights in columns[0].items()
        if all(number in flights for number in range(count))
    }
