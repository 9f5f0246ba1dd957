"""The last round of a run: finalists are judged under disturbed conditions, and the winners' misses are measured.

The conditions of the choice are not those of the promise: whoever wins among many was also lucky, and only conditions
that the choice never saw show how far the winner misses.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import inf
from typing import Any

import numpy as np

from driftform.execution import Executor
from driftform.runs.agent_file import StoredAgent
from driftform.runs.disturbed import draw_rounds, fly_disturbed
from driftform.runs.store import Store
from driftform.runs.survey import read_scores
from driftform.scenario import Robustness
from driftform.study import Study
from driftform.trajectory.misses import Misses, finite_or_none
from driftform.trajectory.way import find_offsets
from driftform.types import FloatArray, Verdict


def fly_finalists(
    study: Study,
    store: Store,
    executor: Executor,
    on_flights: Callable[[int, int], None] = lambda _, __: None,
) -> None:
    """Fly the finalists of each target under the conditions of the choice, and the winners under those of the promise.

    Without disturbed conditions, and if every evaluation failed, nothing is flown, and what is stored already is not flown again. ``on_flights`` is
    called with the number of flights that are done, and with the total, which is an upper bound during the choice.
    """
    robustness, targets = study.scenario.robustness, study.scenario.target_names
    scores = read_scores(study, store) if robustness.conditions else {}
    if not scores:
        return
    fitness = np.array(list(scores.values())).reshape(-1, len(targets))
    finalists = [list(scores)[row] for row in choose_finalists(fitness, robustness.finalists)]
    conditions = draw_rounds(study.scenario, study.seed)
    judged = [(index, number) for index in finalists for number in range(robustness.conditions)]
    to_come = min(len(finalists), len(targets)) * robustness.checks
    fly = partial(fly_disturbed, study, store, executor, conditions)
    # The error of an unchecked flight is far below the differences that decide; what is promised is checked.
    done = fly(judged, lambda count: on_flights(count, len(judged) + to_come), (inf,) * len(targets))
    winners = sorted({won.index for t in targets if (won := find_winner(study, store, t)) is not None})
    numbers = range(robustness.conditions, robustness.conditions + robustness.checks)
    checked = [(index, number) for index in winners for number in numbers]
    fly(checked, lambda count: on_flights(done + count, done + len(checked)))


def choose_finalists(fitness: FloatArray, count: int) -> list[int]:
    """Return the rows of fitness (n, targets) that are among the ``count`` best for any target, in ascending order."""
    # With a stable sort the earlier of equal values is chosen.
    best = np.argsort(-fitness, axis=0, kind="stable")[:count]
    return sorted(set(best.ravel().tolist()))


def robust_fitness(fitness: FloatArray, robustness: Robustness) -> float:
    """Return the score of a finalist from its fitness under all conditions of the choice, (conditions,).

    It is the mean, the smallest value, or the quantile ``robustness.quantile``, by ``robustness.score``.
    """
    if robustness.score == "mean":
        return float(fitness.mean())
    lowest = 0.0 if robustness.score == "worst" else robustness.quantile
    return float(np.quantile(fitness, lowest))


@dataclass(frozen=True, eq=False)
class Winner:
    """The best finalist for a target.

    Attributes
    ----------
    index
        of its evaluation.
    score
        by which it was chosen, %.
    misses
        of its flights under the conditions of the promise, ``None`` before they are flown.
    reached
        share of these flights that reach the target, as the fitness judges it.
    """

    index: int
    score: float
    misses: Misses | None
    reached: float | None = None

    def document(self) -> dict[str, Any]:
        """Return what an agent file and a JSON document hold of it: flights, failures, share that reach the target, score; misses in m."""
        if self.misses is None:
            return {"score": self.score}
        return {
            "score": self.score,
            "flights": self.misses.count,
            "failed": self.misses.failed,
            "reached": self.reached,
            "median": finite_or_none(self.misses.median[0]),
            "p90": finite_or_none(self.misses.promised[0]),
        }


def find_winner(study: Study, store: Store, target: str) -> Winner | None:
    """Return the finalist that was chosen for a target; ``None`` before the choice is complete.

    Of those with equal scores, such as all that leave by an outlet, it is the one with the best undisturbed flight, and
    then the earliest.
    """
    robustness = study.scenario.robustness
    if not robustness.conditions:
        return None
    conditions = draw_rounds(study.scenario, study.seed)
    judged, checked = range(robustness.conditions), range(robustness.conditions, len(conditions))
    flown = store.read_disturbed(target)
    scores = {
        index: robust_fitness(np.array([flights[number][0] for number in judged]), robustness)
        for index, flights in flown.items()
        if all(number in flights for number in judged)
    }
    if not scores:
        return None
    best = max(scores.values())
    equals = [index for index, score in scores.items() if score == best]
    if len(equals) > 1:
        undisturbed = {brief.index: brief.fitness[0] for brief in store.read_summaries([target])}
        equals.sort(key=undisturbed.__getitem__, reverse=True)
    flights = [flown[equals[0]][number] for number in checked if number in flown[equals[0]]]
    if len(flights) < len(checked):
        return Winner(equals[0], best, None)
    misses = Misses(conditions[len(judged) :], np.array([offset for _, offset in flights])[:, None])
    fitness = study.make_plugin("fitness")
    reached = [fitness.judge(score) for score, _ in flights].count(Verdict.REACHED) / len(checked)
    return Winner(equals[0], best, misses, reached)


def find_best_agent(study: Study, store: Store, target: str) -> StoredAgent | None:
    """Return the best agent of a run for a target, named after it; ``None`` before any evaluation succeeded.

    If finalists were flown under disturbed conditions it is the one that was chosen then.
    """
    best, winner = store.find_best(target), find_winner(study, store, target)
    if best is None:
        return None
    targets = study.scenario.target_names
    index = best[0] if winner is None else winner.index
    record = store.read_record(index, targets)
    fitness = float(record.evaluation.fitness[targets.index(target)])
    offset = find_offsets(record.evaluation, study.scenario)[targets.index(target)]
    promise = {} if winner is None else winner.document()
    result: dict[str, Any] = {
        "target": target,
        "fitness": fitness,
        "error_percent": 100 - fitness,
        "evaluation": index,
        "nominal": finite_or_none(float(np.linalg.norm(offset))),
        "median": promise.pop("median", None),
        "p90": promise.pop("p90", None),
    }
    if promise:
        result["robust"] = promise
    return StoredAgent(target, record.candidate.genome, study.environment(record.index), result)
