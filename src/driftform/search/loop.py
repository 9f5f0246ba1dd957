"""The ask/tell loop over a stored run."""

import logging
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain, repeat
from typing import Any

from driftform.errors import InputError
from driftform.interfaces import Result, Strategy
from driftform.plugins.faults import report_faults
from driftform.plugins.seams import require_candidates, require_results
from driftform.runs.store import Record, Store
from driftform.search.jobs import Job
from driftform.search.journal import Journal
from driftform.search.pool import Executor
from driftform.search.survey import BestFitness, Survey
from driftform.study import Study
from driftform.types import Candidate, Evaluation
from driftform.util.files import keep_directory
from driftform.water.scenario import evaluation_seed

_log = logging.getLogger(__name__)

AHEAD = 1
"""Batches that a strategy may be asked for while the outcomes of another are missing, so that no worker waits for it."""


@dataclass(frozen=True, eq=False)
class _Batch:
    """Candidates that a strategy asked for together, from evaluation ``first`` on, and their outcomes so far."""

    first: int
    candidates: Sequence[Candidate]
    seeds: Sequence[int]
    outcomes: dict[int, Evaluation] = field(default_factory=dict)


@report_faults()
def run_search(
    study: Study,
    store: Store,
    executor: Executor,
    on_record: Callable[[Record], None] = lambda _: None,
    on_batch: Callable[[int, Sequence[Evaluation]], None] = lambda _, __: None,
) -> Mapping[str, Result]:
    """Ask, evaluate, tell, until the budget is spent; return what the strategy found.

    A strategy that can is asked for a batch while another is flown. It is a function of the seed and of the outcomes it
    received, so an interrupted run is resumed by running it again: what is stored already is not flown a second time. Which
    flights are checked follows from the same outcomes.

    Args:
        on_record: called with each evaluation, stored or new.
        on_batch: called as the strategy is told: with the index of the first evaluation of each batch, and all of it.

    Raises:
        InputError: where the stored evaluations are not those that this study asks for.
        WorkFailedError: where the strategy fails.
    """
    strategy, targets = study.make_strategy(executor.begin), study.scenario.target_names
    robustness = study.scenario.robustness
    # As many as the run shows, or flies again, for each target.
    best = BestFitness(robustness.finalists if robustness.conditions else 1, len(targets))
    waiting = deque[Job]()
    # What is added while outcomes arrive is evaluated too; the next is asked for only if there is one.
    arrivals = chain.from_iterable(executor.evaluate(waiting) for _ in repeat(None))
    batches: deque[_Batch] = deque()
    asked = told = 0
    # No other process writes meanwhile: beyond what is stored now there is nothing to read.
    stored = store.last_index() + 1
    with Journal(store, targets, on_record) as journal:
        survey = Survey(study, journal, executor)
        while told < study.evaluations:
            # The order of these calls depends on no time: with any workers, and after an interruption, it is the same.
            while asked < study.evaluations and (not batches or (len(batches) <= AHEAD and strategy.can_ask_ahead())):
                batch = _ask(study, strategy, asked)
                if asked < stored:
                    for record in store.read_records(targets, asked, len(batch.candidates)):
                        if record.candidate != batch.candidates[record.index - asked]:
                            raise InputError(
                                f"evaluation {record.index} of this run is not the one that its study asks for now: a "
                                "plugin has changed since; resume with the versions in environment.json, or start a new run"
                            )
                        batch.outcomes[record.index] = record.evaluation
                        on_record(record)
                waiting.extend(
                    Job(index, candidate.genome, seed, threshold=best.lower_threshold(candidate.threshold))
                    for index, (candidate, seed) in enumerate(zip(batch.candidates, batch.seeds, strict=True), asked)
                    if index not in batch.outcomes
                )
                batches.append(batch)
                asked += len(batch.candidates)
            while len(batches[0].outcomes) < len(batches[0].candidates):
                for index, evaluation in next(arrivals):
                    batch = next(batch for batch in reversed(batches) if batch.first <= index)
                    number, batch.outcomes[index] = index - batch.first, evaluation
                    record = Record(index, batch.candidates[number], evaluation, batch.seeds[number])
                    journal.add(record, evaluation.seconds)
            batch = batches.popleft()
            ordered = [evaluation for _, evaluation in sorted(batch.outcomes.items())]
            outcomes = survey.fly(told, batch.candidates, ordered)
            with keep_directory():
                strategy.tell(told, outcomes)
                on_batch(told, outcomes)
            best.add(ordered)
            told += len(batch.candidates)
            _log.debug("%d of %d evaluations", told, study.evaluations)
    with keep_directory():
        return require_results(strategy.collect_results(), strategy)


def _ask(study: Study, strategy: Strategy[Any], asked: int) -> _Batch:
    left, grammar = study.evaluations - asked, study.document["grammar"]["use"]
    with keep_directory():
        found, targets = strategy.ask(left), study.scenario.target_names
    candidates = require_candidates(found, left, strategy, grammar, targets, asked)
    seeds = [evaluation_seed(study.seed, index) for index in range(asked, asked + len(candidates))]
    return _Batch(asked, candidates, seeds)
