"""Searches that are repeated over seeds with equal budgets, and what their repeats come to.

Each repeat is an ordinary run in a directory of its own: an interrupted one continues where it stopped.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from math import isfinite
from pathlib import Path

import numpy as np

from driftform.figures.trend import Curve, choose_points
from driftform.runs.run import StoredRun
from driftform.runs.table_files import Column, write_csv
from driftform.search.advance import Observer, advance_run, list_best, search_run
from driftform.search.pool import Executor
from driftform.study import Study
from driftform.types import FloatArray
from driftform.util.files import write_whole

Repeats = Mapping[Path, Study]
"""The repeats of one search: studies that differ in their seed alone, by the directories of their runs."""

ALL = "all targets"
"""Name of the mean over targets."""

MEASURES = {
    "fitness": ("best undisturbed fitness", "percent"),
    "hit": ("disturbed flights of weighed prints that hit", "percent"),
    "miss": ("90 % miss of weighed prints", "mm"),
}
"""What searches are compared by, and its unit."""


def search_all(
    searches: Sequence[Repeats],
    open_place: Callable[[Study], AbstractContextManager[Executor]],
    progress: Callable[[int, int], None],
) -> list[str]:
    """Search every repeat to its end; with disturbed conditions, also fly its finalists and write its best agents.

    A repeat that is complete is left as it is. Each search gets workers of its own, by ``open_place``. ``progress`` is
    called with the number of undisturbed flights that are done, and of all. Returns a line per file that was not written, and
    per warning.

    Raises InputError if a directory holds a run of another study, or another process works on it.
    """
    problems, done, total = list[str](), 0, sum(study.evaluations for each in searches for study in each.values())
    for repeats in searches:
        with open_place(next(iter(repeats.values()))) as executor:
            for path, study in repeats.items():
                counter = _Counter(progress, done, total, problems)
                with StoredRun.create(path, study, again=True) as run:
                    if study.scenario.robustness.conditions:
                        problems += [line for best in advance_run(run, executor, counter) for line in best.problems]
                    elif run.count()[0] < study.evaluations:
                        search_run(run, executor, counter)
                done += study.evaluations
                progress(done, total)
    return problems


class _Counter(Observer):
    def __init__(self, progress: Callable[[int, int], None], before: int, total: int, problems: list[str]) -> None:
        self._progress, self._done, self._total, self._problems = progress, before, total, problems

    def record(self, record: object) -> None:
        self._done += 1
        self._progress(self._done, self._total)

    def warn(self, text: str) -> None:
        self._problems.append(text)


@dataclass(frozen=True, eq=False)
class Outcome:
    """What the repeats of a search come to.

    Attributes:
        targets: their names.
        best: the best fitness so far after each flight, %, (repeats, targets, flights).
        values: by the names of :data:`MEASURES` what each repeat ends with, in their units, (repeats, targets); NaN for a
            promise that is not known. Without disturbed conditions there are no promises.
        failed: number of flights that failed.
    """

    targets: tuple[str, ...]
    best: FloatArray
    values: Mapping[str, FloatArray]
    failed: int

    def split(self, values: FloatArray) -> dict[str, FloatArray]:
        """Return values, (repeats, targets, ...), by target, (repeats, ...), after their mean over targets."""
        return {ALL: values.mean(axis=1)} | {target: values[:, k] for k, target in enumerate(self.targets)}


def read_outcome(repeats: Repeats) -> Outcome:
    """Read what the repeats of a search come to; all of them are complete."""
    best, promises, failed = list[FloatArray](), list[FloatArray](), 0
    for path, study in repeats.items():
        run, targets = StoredRun(path, study), study.scenario.target_names
        with run.read() as store:
            fitness = np.array([summary.fitness for summary in store.read_summaries(targets)])
            failed += store.count_failed()
        best.append(np.maximum.accumulate(fitness, axis=0).T)
        if study.scenario.robustness.conditions:
            found = list_best(run)
            weighed = [found.get(name, {}).get("robust", {}).get("weighed", {}) for name in targets]
            known = [[row.get(key) for row in weighed] for key in ("hit", "p90")]
            promises.append(np.array(known, dtype=np.float64) * [[100.0], [1000.0]])
    values = {"fitness": np.array(best)[:, :, -1]}
    if promises:
        values |= dict(zip(("hit", "miss"), np.swapaxes(promises, 0, 1), strict=True))
    return Outcome(targets, np.array(best), values, failed)


def compare_outcomes(outcomes: Mapping[str, Outcome]) -> dict[str, dict[str, dict[str, dict[str, float | None]]]]:
    """Return the statistics of searches by their names, measures and targets, of those that all have; see :func:`compare_values`."""
    first = next(iter(outcomes.values()))
    return {
        name: {
            measure: {
                target: compare_values(values, None if outcome is first else first.split(first.values[measure])[target])
                for target, values in outcome.split(outcome.values[measure]).items()
                if all(target in (ALL, *other.targets) for other in outcomes.values())
            }
            for measure in MEASURES
            if all(measure in other.values for other in outcomes.values())
        }
        for name, outcome in outcomes.items()
    }


def compare_values(values: FloatArray, first: FloatArray | None = None) -> dict[str, float | None]:
    """Return median and quartiles of a value of each repeat, (repeats,), and how it differs from that of the ``first`` search.

    That is the difference of the medians with its interval by the bootstrap (percentiles of 9999 samples; Efron and
    Tibshirani 1993, ch. 13), and the probability ``p`` of ranks as different as these if both were the same (Mann and Whitney
    1947), of two sides. What is not finite is ``None``.

    >>> compare_values(np.array([3.0, 1.0, 2.0]))
    {'median': 2.0, 'q1': 1.5, 'q3': 2.5}
    """
    low, middle, high = np.quantile(values, (0.25, 0.5, 0.75))
    found = {"median": middle, "q1": low, "q3": high}
    if first is not None and np.isfinite([values, first]).all():
        from scipy.stats import bootstrap, mannwhitneyu

        def subtract(one: FloatArray, other: FloatArray, axis: int) -> FloatArray:
            return np.asarray(np.median(one, axis=axis) - np.median(other, axis=axis))

        interval = bootstrap((values, first), subtract, method="percentile", random_state=0).confidence_interval
        found |= {"difference": middle - np.median(first), "low": interval.low, "high": interval.high}
        found["p"] = mannwhitneyu(values, first).pvalue
    return {key: float(value) if isfinite(value) else None for key, value in found.items()}


def write_values(path: Path, outcomes: Mapping[str, Outcome], seeds: Sequence[int]) -> None:
    """Write what each repeat ends with as CSV: a row per search, seed and target."""
    rows = [
        {"search": name, "seed": seed, "target": target}
        | {
            f"{m}_{unit}": float(outcome.values[m][row, k]) if m in outcome.values else None
            for m, (_, unit) in MEASURES.items()
        }
        for name, outcome in outcomes.items()
        for row, seed in enumerate(seeds)
        for k, target in enumerate(outcome.targets)
    ]
    columns = [Column(name, "text", "", "") for name in rows[0]]
    write_whole(path, lambda part: write_csv(part, columns, [{name: [row[name] for row in rows] for name in rows[0]}]))


def draw_curves(outcomes: Mapping[str, Outcome]) -> dict[str, list[Curve]]:
    """Return the curves of searches, medians and quartiles, by the targets that all have, after the mean over targets."""
    panels: dict[str, list[Curve]] = {}
    for name, outcome in outcomes.items():
        at = choose_points(outcome.best.shape[2])
        for target, fitness in outcome.split(outcome.best[:, :, at - 1]).items():
            low, middle, high = np.quantile(fitness, (0.25, 0.5, 0.75), axis=0)
            panels.setdefault(target, []).append(Curve(name, at, middle, np.stack([low, high])))
    return {target: curves for target, curves in panels.items() if len(curves) == len(outcomes)}
