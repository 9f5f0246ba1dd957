"""The ask/tell loop over a stored run, and what a run leaves behind."""

from collections.abc import Callable, Sequence

import numpy as np

from driftform.errors import InputError
from driftform.execution import Executor, Job
from driftform.faults import report_faults
from driftform.runs.store import Record, Store
from driftform.runs.survey import survey
from driftform.scenario import Robustness, evaluation_seed
from driftform.seams import require_candidates
from driftform.study import Study
from driftform.types import Evaluation


def run_search(
    study: Study,
    store: Store,
    executor: Executor,
    on_record: Callable[[Record], None] = lambda _: None,
    on_generation: Callable[[int], None] = lambda _: None,
) -> None:
    """Ask, evaluate, tell, until the budget is spent.

    A strategy is a function of the seed and of the outcomes it received, so an interrupted run is resumed by running it
    again: what is stored already is not flown a second time. Which flights are checked follows from the same outcomes.

    Parameters
    ----------
    on_record
        called with each evaluation, stored or new.
    on_generation
        called with the number of evaluations so far, whenever the strategy has received their outcomes.

    Raises
    ------
    InputError
        where the stored evaluations are not those that this study asks for.
    WorkFailedError
        where the strategy fails.
    """
    with report_faults():
        _search(study, store, executor, on_record, on_generation)


def _search(
    study: Study,
    store: Store,
    executor: Executor,
    on_record: Callable[[Record], None],
    on_generation: Callable[[int], None],
) -> None:
    strategy, targets = study.make_strategy(), study.scenario.target_names
    grammar = study.document["grammar"]["use"]
    best = BestFitness(len(targets), count_finalists(study.scenario.robustness))
    first = 0
    while first < study.evaluations:
        left = study.evaluations - first
        candidates = require_candidates(strategy.ask(left), left, strategy, grammar, targets, first)
        outcomes: dict[int, Evaluation] = {}
        for record in store.read_records(targets, first, len(candidates)):
            if record.candidate != candidates[record.index - first]:
                raise InputError(
                    f"evaluation {record.index} of this run is not the one that its study asks for now: a plugin "
                    "has changed since; resume with the versions in environment.json, or start a new run"
                )
            outcomes[record.index] = record.evaluation
            on_record(record)
        seeds = {
            index: evaluation_seed(study.seed, index)
            for index in range(first, first + len(candidates))
            if index not in outcomes
        }
        missing = [
            Job(index, candidate.genome, seed, threshold=best.lower_threshold(candidate.threshold))
            for index, seed in seeds.items()
            for candidate in [candidates[index - first]]
        ]
        for arrived in executor.evaluate(missing):
            records = [
                Record(index, candidates[index - first], evaluation, seeds[index])
                for index, evaluation in arrived
            ]
            store.add(records, targets)
            # What is stored counts, and nothing else does.
            for record in records:
                outcomes[record.index] = record.evaluation
                on_record(record)
        ordered = [outcomes[first + i] for i in range(len(candidates))]
        strategy.tell(first, survey(study, store, executor, first, candidates, ordered))
        best.add(ordered)
        first += len(candidates)
        on_generation(first)


class BestFitness:
    """The best fitness of a run so far for each target: what an evaluation must exceed to appear among its results.

    Parameters
    ----------
    targets
        number of targets.
    count
        number of best evaluations that a run shows for each of them.
    """

    def __init__(self, targets: int, count: int) -> None:
        self._best = np.full((count, targets), -np.inf)

    def add(self, evaluations: Sequence[Evaluation]) -> None:
        """Take the fitness of evaluations; failed ones do not count."""
        sound = [evaluation.fitness for evaluation in evaluations if evaluation.failure is None]
        if sound:
            self._best = np.sort(np.vstack([self._best, *sound]), axis=0)[-len(self._best) :]

    def lower_threshold(self, threshold: tuple[float, ...] | None) -> tuple[float, ...] | None:
        """Return a strategy's threshold, lowered where the run itself wants a lower fitness, (targets,)."""
        if threshold is None:
            return None
        lowered: list[float] = np.minimum(threshold, self._best[0]).tolist()
        return tuple(lowered)


def count_finalists(robustness: Robustness) -> int:
    """Return the number of best evaluations that a run shows, or flies again, for each target."""
    return robustness.finalists if robustness.conditions else 1
