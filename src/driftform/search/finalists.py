"""The last round of a run: finalists are judged under disturbed conditions, and the winners' misses are measured.

The conditions of the choice are not those of the promise: the winner among many was also lucky, and only other
conditions show how far it misses.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from math import inf, isnan, nan
from typing import Any

import numpy as np

from driftform.agent import hull_mass
from driftform.interfaces import Fitness
from driftform.motion.path.targets import find_offsets, find_within
from driftform.runs.agent_file import StoredAgent
from driftform.runs.misses import Misses, finite_or_none
from driftform.runs.store import Store
from driftform.runs.wording import KEPT, describe_result, name_verdict
from driftform.search.baseline import Baseline, find_baselines, read_baselines
from driftform.search.disturbed import draw_baseline, draw_rounds, fly_disturbed
from driftform.search.journal import Journal
from driftform.search.pool import Executor
from driftform.search.survey import read_scores
from driftform.study import Study
from driftform.types import BoolArray, FloatArray, Genome, Verdict
from driftform.water.disturbances import FLOWN, Specimen
from driftform.water.scenario import Robustness

ROUND = 5
"""Conditions of the choice between two looks at who can still win."""

EQUAL, PLAIN = 0.05, 0.1
"""Scores are equal if what they lack to 100 % differs by a smaller share than this: 20 flights cannot distinguish them. A plain
body is equal to what is better by twice as much."""


def fly_finalists(
    study: Study, store: Store, executor: Executor, on_flights: Callable[[int, int], None] = lambda _, __: None
) -> None:
    """Fly the finalists of each target under the conditions of the choice, and the winners under those of the promise.

    Without disturbed conditions, and if every evaluation failed, nothing is flown, and what is stored already is not flown
    again. ``on_flights`` is called with the number of flights that are done, and with the total, which is an upper bound
    during the choice.
    """
    robustness, targets = study.scenario.robustness, study.scenario.target_names
    scores = read_scores(study, store) if robustness.conditions else {}
    if not scores:
        return
    fitness = study.make_plugin("fitness")
    reaching = np.column_stack([_find_reaching(fitness, store.read_fitness(t, list(scores))) for t in targets])
    rows = choose_finalists(np.array(list(scores.values())), robustness.finalists, reaching)
    finalists = {list(scores)[row]: reaching[row] for row in rows}
    conditions = draw_rounds(study)
    count = _Count(on_flights)
    count.later = min(len(finalists), len(targets)) * (len(conditions) - robustness.conditions)
    count.later += len(targets) * robustness.checks
    genomes = {index: store.read_record(index, targets).candidate.genome for index in finalists}
    with Journal(store, targets) as journal:
        fly = partial(fly_disturbed, study, journal, executor, conditions, genomes)
        plain = find_plain(study, genomes)
        _race(study, fly, finalists, scores, plain, count)
        journal.write()
        won = [None if (winner := find_winner(study, store, t)) is None else winner.index for t in targets]
        winners = {index: np.array([index == of for of in won]) for index in won if index is not None}
        # One that the survey flew under all conditions may win without being a finalist.
        genomes |= {index: store.read_record(index, targets).candidate.genome for index in winners}
        numbers = range(robustness.conditions, len(conditions))
        checked = [(index, number) for index in sorted(winners) for number in numbers]
        baselines = find_baselines(study, store, executor, [t for t, index in enumerate(won) if index is not None])
        count.left, count.later = len(checked), robustness.checks * len(baselines)
        fly(checked, count.add, wanted=winners)
        count.left, count.later = count.later, 0
        # Each baseline is stored with the winner that it is compared with.
        for target, baseline in sorted(baselines.items()):
            if (index := won[target]) is not None:
                drawn, genome, wanted = draw_baseline(study, target), baseline.genome, np.arange(len(won)) == target
                pairs = [(index, number) for number in drawn]
                fly_disturbed(
                    study, journal, executor, drawn, {index: genome}, pairs, count.add, wanted={index: wanted}
                )


@dataclass
class _Count:
    """Counts flights: ``left`` are those that are being flown, ``later`` those that come after them, at most."""

    on_flights: Callable[[int, int], None]
    done: int = 0
    left: int = 0
    later: int = 0

    def add(self, flights: int) -> None:
        self.done, self.left = self.done + flights, self.left - flights
        self.on_flights(self.done, self.done + self.left + self.later)


def _find_reaching(fitness: Fitness[Any], undisturbed: Mapping[int, float]) -> BoolArray:
    """Return which evaluations may be chosen for a target, (n,): those that come near it undisturbed, or all if none does."""
    near = np.array([fitness.judge(value) is not Verdict.MISSED for value in undisturbed.values()], dtype=bool)
    return near if near.any() else ~near


def choose_finalists(fitness: FloatArray, count: int, eligible: BoolArray) -> list[int]:
    """Return the rows that are among the ``count`` best eligible ones for any target, in ascending order.

    ``fitness`` and ``eligible`` are (n, targets).
    """
    # With a stable sort the earlier of equal values is chosen.
    best = np.argsort(-np.where(eligible, fitness, -np.inf), axis=0, kind="stable")[:count]
    return sorted({row for column, may in zip(best.T, eligible.T, strict=True) for row in column[may[column]].tolist()})


def _race(
    study: Study,
    fly: Callable[..., Mapping[tuple[int, int], FloatArray]],
    finalists: Mapping[int, BoolArray],
    scores: Mapping[int, FloatArray],
    plain: set[int],
    progress: _Count,
) -> None:
    """Fly the conditions of the choice; finalists that can no longer win are dropped.

    The best of the search for each target fly under all conditions. Another is out as soon as its score would be below
    theirs for all its targets if all flights to come were perfect. So the winners are those of a choice in which all fly.

    Args:
        finalists: for which targets each may be chosen, (targets,).
        scores: fitness of the search, (targets,).
        plain: which finalists are plain bodies.
        progress: counts flights; what comes after the choice is still to be flown.
    """
    robustness, targets = study.scenario.robustness, study.scenario.target_names
    count, flown = robustness.conditions, dict[tuple[int, int], FloatArray]()
    perfect = np.full((count, len(targets)), 100.0)
    # The error of an unchecked flight is far below the differences that decide; what is promised is checked.
    unchecked = (inf,) * len(targets)

    def fly_on(indices: Sequence[int], first: int, end: int, others: int) -> None:
        pairs = [(index, number) for index in indices for number in range(first, end)]
        progress.left = len(pairs) + others
        flown.update(fly(pairs, progress.add, unchecked, finalists))

    def bound(index: int, end: int) -> FloatArray:
        return robust_fitness(np.vstack([*(flown[index, at] for at in range(end)), perfect[end:]]), robustness)

    leaders = [
        max((index for index, may in finalists.items() if may[number]), key=lambda index: scores[index][number])
        for number in range(len(targets))
    ]
    racing = sorted(set(finalists).difference(leaders))
    fly_on(sorted(set(leaders)), 0, count, len(racing) * count)
    best = np.array([bound(leader, count)[number] for number, leader in enumerate(leaders)])
    for first in range(0, count, ROUND):
        end = min(first + ROUND, count)
        fly_on(racing, first, end, len(racing) * (count - end))
        bars = {index: best - (PLAIN if index in plain else EQUAL) * (100 - best) for index in racing}
        racing = [index for index in racing if (bound(index, end) >= bars[index])[finalists[index]].any()]


def find_plain(study: Study, genomes: Mapping[int, Genome]) -> set[int]:
    """Return which evaluations are those of a plain body."""
    plain = study.make_plugin("grammar").plain()
    return {index for index, genome in genomes.items() if plain and replace(genome, tuning=0.0) == plain}


def robust_fitness(fitness: FloatArray, robustness: Robustness) -> FloatArray:
    """Return the scores of a finalist from its fitness under all conditions of the choice, (conditions, targets).

    It is the mean, the smallest value, or the quantile ``robustness.quantile``, by ``robustness.score``. Failed flights, NaN, say
    nothing; if most failed, the score is 0.
    """
    sound = np.where(2 * np.isnan(fitness).sum(axis=0) < len(fitness), fitness, 0.0)
    if robustness.score == "quantile":
        return np.asarray(np.nanquantile(sound, robustness.quantile, axis=0))
    return np.asarray((np.nanmin if robustness.score == "worst" else np.nanmean)(sound, axis=0))


@dataclass(frozen=True, eq=False)
class Promise:
    """The misses of flights under fresh conditions, and the share of those that did not fail that hit the target."""

    misses: Misses
    hit: float | None

    def document(self) -> dict[str, Any]:
        """Return the numbers of flights and failures, the share of hits, and median and 90 % miss, m."""
        return {"hit": self.hit, **self.misses.describe(0)}


@dataclass(frozen=True, eq=False)
class Winner:
    """The best finalist for a target.

    Attributes:
        index: of its evaluation.
        score: by which it was chosen, %.
        promises: of what flies under the conditions of the promise, empty before that.
        baseline: the plain body that was tuned for the target; ``None`` without one, or in a run of an earlier version.
    """

    index: int
    score: float
    promises: Mapping[Specimen, Promise] = field(default_factory=dict)
    baseline: Baseline | None = None

    def document(self) -> dict[str, Any]:
        """Return what an agent file and a JSON document hold of it: the score, and of each promise its numbers, misses in m."""
        documents = {specimen: promise.document() for specimen, promise in self.promises.items()}
        if not documents:
            return {"score": self.score}
        baseline = {}
        if self.baseline is not None and Specimen.BASELINE in documents:
            baseline = {"baseline": {**documents[Specimen.BASELINE], **self.baseline.document()}}
        return {
            "score": self.score,
            **documents[Specimen.PRINT],
            "weighed": documents[Specimen.WEIGHED],
            **baseline,
            "idle": documents[Specimen.IDLE],
        }


def find_winner(study: Study, store: Store, target: str) -> Winner | None:
    """Return the finalist that was chosen for a target; ``None`` before the choice is complete.

    One that comes near the target undisturbed goes before all that do not: a body that always passes half a metre above its
    target can be relied on, and is of no use. Of those with equal scores, by :data:`EQUAL` and :data:`PLAIN`, it is a plain body that keeps its
    target; else the one whose print is the lightest; then that with the best score, the best undisturbed flight, and the earliest.
    """
    robustness = study.scenario.robustness
    if not robustness.conditions:
        return None
    conditions = draw_rounds(study)
    first, count = robustness.conditions, robustness.checks
    judged, checked = range(first), range(first, first + len(FLOWN) * count)
    within = float(find_within(study.scenario)[study.scenario.target_names.index(target)])
    flown = store.read_disturbed(target)
    judged_all = [index for index, flights in flown.items() if all(number in flights for number in judged)]
    if not judged_all:
        return None
    fitness, undisturbed = study.make_plugin("fitness"), store.read_fitness(target, judged_all)
    reaching = _find_reaching(fitness, undisturbed)
    eligible = [index for index, reaches in zip(judged_all, reaching, strict=True) if reaches]
    judged_fitness = np.array([[flown[index][number] for number in judged] for index in eligible])
    scores = dict(zip(eligible, robust_fitness(judged_fitness.T, robustness).tolist(), strict=True))
    best = max(scores.values())
    bar, low = (best - share * (100 - best) for share in (EQUAL, PLAIN))
    equals = sorted((index for index in scores if scores[index] >= low), key=lambda i: (-scores[i], -undisturbed[i], i))

    def keeps(index: int) -> bool:
        misses = store.read_offsets(target, index)
        hits = [fitness.is_hit(flown[index][at], float(np.linalg.norm(misses[at])), within) for at in judged]
        return bool(sum(hits) >= KEPT * first)

    # What has flown under the conditions of the promise was chosen before.
    decided = [i for i in equals if not all(isnan(flown[i].get(number, nan)) for number in checked)]
    if not decided and len(equals) > 1:
        genomes = {i: store.read_record(i, study.scenario.target_names).candidate.genome for i in equals}
        pipeline, plain = study.make_pipeline(), {i for i in find_plain(study, genomes) if keeps(i)}
        equals = [i for i in equals if i in plain or scores[i] >= bar]
        masses = {i: hull_mass(pipeline.make_agent(genomes[i]).body) for i in equals}
        equals.sort(key=lambda i: (i not in plain, masses[i]))
    chosen = (decided or equals)[0]
    flights = flown[chosen]
    if not all(number in flights for number in checked):
        return Winner(chosen, scores[chosen])
    offsets, promises = store.read_offsets(target, chosen), dict[Specimen, Promise]()
    # A run of an earlier version has no flights in known gusts, and no baseline.
    known = [at for at in range(checked.stop, len(conditions)) if at in flights]
    at_target, numbered = study.scenario.target_names.index(target), dict(enumerate(conditions[: checked.stop]))
    baseline = read_baselines(store).get(at_target)
    if baseline is not None:
        numbered |= draw_baseline(study, at_target)
    for specimen in (*FLOWN, Specimen.BASELINE):
        fresh = [at for at, condition in numbered.items() if at >= first and condition.specimen is specimen]
        if not fresh or not all(at in flights for at in fresh):
            continue
        found = [np.array([offsets[at] for at in part])[:, None] for part in (fresh, known) if part]
        beside = found[-1] if specimen is Specimen.WEIGHED and len(known) == count else None
        misses = Misses([numbered[at] for at in fresh], found[0], beside)
        sound = [
            fitness.is_hit(flights[at], miss, within)
            for at, miss in zip(fresh, misses.distances[:, 0].tolist(), strict=True)
            if not isnan(flights[at])
        ]
        promises[specimen] = Promise(misses, sum(sound) / len(sound) if sound else None)
    return Winner(chosen, scores[chosen], promises, baseline)


def find_best_agent(study: Study, store: Store, target: str, winner: Winner | None = None) -> StoredAgent | None:
    """Return the best agent of a run for a target, named after it; ``None`` before any evaluation succeeded.

    It is the ``winner`` among finalists that were flown under disturbed conditions; without one, the best of the search.
    """
    winner = winner or find_winner(study, store, target)
    if winner is not None:
        index = winner.index
    elif (best := store.find_best(target)) is not None:
        index, _ = best
    else:
        return None
    targets = study.scenario.target_names
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
        "within": float(find_within(study.scenario)[targets.index(target)]),
        "median": promise.get("median"),
        "p90": promise.get("p90"),
        "plain": index in find_plain(study, {index: record.candidate.genome}),
    }
    if promise:
        result["robust"] = promise
    words = study.make_plugin("fitness")
    result |= {"verdict": name_verdict(words, result), "summary": describe_result(words, result)}
    return StoredAgent(target, record.candidate.genome, study.environment(record.index), result)
