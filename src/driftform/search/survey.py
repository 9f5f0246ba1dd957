"""The survey: agents of the search that may be among the best are flown under a few disturbed conditions.

An agent that passes a target within a millimetre in the mean flow may owe that to a balance which the weight of a print
upsets. A strategy that receives the fitness under disturbed conditions breeds agents that do not.

The undisturbed flight counts as one of these conditions. Without it, agents that slide along the wall half a metre from
their target, whatever disturbs them, would displace those that reach it, and a search could not leave them any more.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from math import inf

import numpy as np

from driftform.runs.store import Store
from driftform.search.disturbed import draw_rounds, fly_disturbed
from driftform.search.journal import Journal
from driftform.search.pool import Executor
from driftform.study import Study
from driftform.types import Candidate, Evaluation, FloatArray

KEPT = "fitness_90"
"""Measure of surveyed agents."""


class Survey:
    """The race of a run's agents under the first conditions of the choice, the same for all.

    It is run in stages: few conditions for many agents, many for few. An agent goes on while, for a target that it is
    among the best for, its mean over the conditions so far is among those of the best earlier agents over the same conditions.
    Without disturbed conditions in the study nothing is flown.
    """

    def __init__(self, study: Study, journal: Journal, executor: Executor) -> None:
        robustness, targets = study.scenario.robustness, study.scenario.target_names
        count = min(robustness.survey, robustness.conditions)
        self._study, self._journal, self._executor = study, journal, executor
        self._threshold = (inf,) * len(targets)
        self._conditions = draw_rounds(study) if count else ()
        self._stages = sorted({count // 4, count // 2, count} - {0})
        self._best = {stage: BestFitness(robustness.finalists, len(targets)) for stage in self._stages}

    def fly(self, first: int, candidates: Sequence[Candidate], evaluations: Sequence[Evaluation]) -> list[Evaluation]:
        """Return what a strategy is given for a batch: evaluations with the mean fitness of all flights of an agent.

        An agent is surveyed if its undisturbed fitness exceeds its ``threshold`` for some target: any other fitness does
        not matter to its strategy. An agent without a threshold is not surveyed, and one with a threshold of minus infinity
        flies under all conditions. The measure :data:`KEPT` is the fitness that 90 % of its flights reach, the mean over targets.

        Args:
            first: index of the first evaluation.
            candidates, evaluations: the batch, and its undisturbed flights.
        """
        given = list(evaluations)
        matters = {
            number: evaluation.fitness > np.array(candidate.threshold)
            for number, (candidate, evaluation) in enumerate(zip(candidates, evaluations, strict=True))
            if evaluation.failure is None and candidate.threshold is not None
        }
        alive = [number for number, at in matters.items() if at.any()]
        whole = {number for number in alive if -inf in (candidates[number].threshold or ())}
        flown = dict[tuple[int, int], FloatArray]()
        genomes = {first + number: candidates[number].genome for number in alive}
        # The error of an unchecked flight is far below the differences that decide.
        fly = partial(fly_disturbed, self._study, self._journal, self._executor, self._conditions, genomes)
        for stage in self._stages if alive else ():
            pairs = [(first + number, condition) for number in alive for condition in range(stage)]
            flown |= fly([pair for pair in pairs if pair not in flown], threshold=self._threshold)
            for number in alive:
                flights = np.array([flown[first + number, condition] for condition in range(stage)])
                undisturbed, measures = evaluations[number].fitness, evaluations[number].measures
                kept = float(np.nanquantile(np.vstack([undisturbed, flights]), 0.1, axis=0).mean())
                given[number] = replace(
                    given[number], fitness=_mean_fitness(undisturbed, flights), measures={**measures, KEPT: kept}
                )
            least = self._best[stage].least
            self._best[stage].add([given[number] for number in alive])
            alive = [n for n in alive if n in whole or np.any((given[n].fitness > least)[matters[n]])]
        return given


class BestFitness:
    """The ``count`` best fitnesses so far for each of some targets."""

    def __init__(self, count: int, targets: int) -> None:
        self._best = np.full((count, targets), -np.inf)

    @property
    def least(self) -> FloatArray:
        """What others must exceed to be among them, (targets,)."""
        return np.asarray(self._best[0])

    def add(self, evaluations: Sequence[Evaluation]) -> None:
        """Take the fitness of evaluations; failed ones do not count."""
        sound = [evaluation.fitness for evaluation in evaluations if evaluation.failure is None]
        if sound:
            self._best = np.sort(np.vstack([self._best, *sound]), axis=0)[-len(self._best) :]

    def lower_threshold(self, threshold: tuple[float, ...] | None) -> tuple[float, ...] | None:
        """Return a strategy's threshold, lowered where the run itself wants a lower fitness, (targets,)."""
        return None if threshold is None else tuple(np.minimum(threshold, self.least).tolist())


def read_scores(study: Study, store: Store) -> dict[int, FloatArray]:
    """Return the fitness by which finalists are chosen, for each target, by evaluation: that which a strategy is given.

    With a survey it has only those that were flown under all its conditions, if there are any.
    """
    targets, robustness = study.scenario.target_names, study.scenario.robustness
    count = min(robustness.survey, robustness.conditions)
    undisturbed = {
        brief.index: np.array(brief.fitness) for brief in store.read_summaries(targets) if brief.failure is None
    }
    flown, surveyed = store.read_flights(targets), range(count)
    means = {
        index: _mean_fitness(undisturbed[index], np.array([flown[index, number] for number in surveyed]))
        for index in sorted({index for index, _ in flown})
        if count and all((index, number) in flown for number in surveyed)
    }
    return means or undisturbed


def _mean_fitness(undisturbed: FloatArray, disturbed: FloatArray) -> FloatArray:
    """Return the mean of an undisturbed flight, (targets,), and of disturbed ones, (flights, targets), NaN if they failed."""
    return np.asarray(np.nanmean(np.vstack([undisturbed, disturbed]), axis=0))
