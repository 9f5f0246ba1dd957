"""The state of a run in numbers, counted evaluation by evaluation, in any order and in little memory."""

import math
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from itertools import accumulate

from driftform.errors import ReasonTally
from driftform.runs.store import EvaluationSummary
from driftform.runs.table_files import MEASURE_COLUMNS

PARTS = 48
"""Equal parts of the budget of which the best error is kept: as many as a curve has columns."""


class TargetStatus:
    """The state of a run for one target.

    Attributes:
        best: the largest fitness of a sound evaluation, 0 before any.
        index: the evaluation that has it, the earliest of equals; -1 before any.
        generation: the newest of the population that works for the target, -1 before any.
        failed: how many evaluations of that population failed.
        measures: what was measured of the best, by name.
    """

    def __init__(self) -> None:
        self.best = 0.0
        self.index = -1
        self.generation = -1
        self.failed = 0
        self.measures: Mapping[str, float] = {}
        self._sum = 0.0
        self._count = 0
        self._least = [math.inf] * PARTS

    @property
    def mean(self) -> float | None:
        """Mean fitness of the newest generation, without those that failed; ``None`` if all of them failed."""
        return self._sum / self._count if self._count else None

    def count(self, generation: int, failed: bool, fitness: float) -> None:
        """Count an evaluation of the population that works for the target."""
        if generation > self.generation:
            self.generation, self._sum, self._count = generation, 0.0, 0
        self.failed += failed
        if generation == self.generation and not failed:
            self._sum += fitness
            self._count += 1

    def score(self, index: int, fitness: float, part: int, measures: Mapping[str, float]) -> None:
        """Compare a sound evaluation of any population, in a part of the budget, with the best."""
        if (fitness, -index) > (self.best, -self.index) or self.index < 0:
            self.best, self.index, self.measures = fitness, index, measures
        self._least[part] = min(self._least[part], 100 - fitness)

    def list_errors(self) -> list[float | None]:
        """Return the best error (%) so far at the end of each part of the budget that is begun; ``None`` before any."""
        begun = max((part for part, error in enumerate(self._least, start=1) if error < math.inf), default=0)
        return [None if error == math.inf else error for error in accumulate(self._least[:begun], min)]


class Missed:
    """How many evaluations miss each constraint, and by how much those that miss it least."""

    def __init__(self) -> None:
        self._found: dict[str, tuple[int, float]] = {}

    def add(self, violations: Mapping[str, float]) -> None:
        """Count the violations of an evaluation."""
        for name, excess in violations.items():
            if excess > 0:
                count, least = self._found.get(name, (0, excess))
                self._found[name] = count + 1, min(least, excess)

    def __str__(self) -> str:
        units = {column.name: f" {column.unit}" for column in MEASURE_COLUMNS}
        rows = self._found.items()
        return ", ".join(
            f"{name} {count} times, by {least:.3g}{units.get(name, ' (SI)')} or more" for name, (count, least) in rows
        )


class RunStatus:
    """The state of a run.

    Attributes:
        budget: evaluations in the whole run.
        done, failed: how many there are, and how many of those failed.
        targets: the standing of each target, by its name.
        missed: the constraints that evaluations miss.
    """

    def __init__(self, targets: Sequence[str], budget: int) -> None:
        self.budget = budget
        self.done = 0
        self.failed = 0
        self.targets = {target: TargetStatus() for target in targets}
        self.missed = Missed()
        self._reasons = ReasonTally()

    @property
    def commonest_failure(self) -> tuple[str, int]:
        """The first of the commonest kind of failure, and how many there are; ``("", 0)`` without failures."""
        return self._reasons.commonest

    def add(self, one: EvaluationSummary) -> None:
        """Count one evaluation."""
        failed = one.failure is not None
        self.done += 1
        self.failed += failed
        if one.failure is not None:
            self._reasons.add(one.failure)
        self.missed.add(one.violations)
        part = min(PARTS * one.index // self.budget, PARTS - 1)
        for (target, standing), value in zip(self.targets.items(), one.fitness, strict=True):
            if one.population in (target, ""):
                standing.count(one.generation, failed, value)
            if not failed:
                standing.score(one.index, value, part, one.measures)


class Throughput:
    """How fast evaluations come of late.

    Those that were there at the beginning do not count, nor does the time until the first new ones: kernels are
    compiled in it.
    """

    window = 30.0
    """How far back the rate reaches, s; further where few came since."""

    settling = 1.0
    """Evaluations that come this soon after the first, s, are as old as it: several are computed at once."""

    min_count = 5
    """Evaluations that a rate needs; fewer would make it jump."""

    def __init__(self, done: int, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock, self._before = clock, done
        self._began = clock()
        self._first: float | None = None
        self._marks = deque([(self._began, done)])

    @property
    def elapsed(self) -> float:
        """Time since the beginning, s."""
        return self._clock() - self._began

    def mark(self, done: int) -> None:
        """Note how many evaluations there are."""
        if done <= self._before:
            return
        now = self._clock()
        if self._first is None:
            self._first = now
        if now - self._first < self.settling:
            self._marks = deque([(now, done)])
        elif now - self._marks[-1][0] >= self.window / 30:
            self._marks.append((now, done))
        while (
            len(self._marks) > 1
            and now - self._marks[1][0] > self.window
            and done - self._marks[1][1] >= self.min_count
        ):
            self._marks.popleft()

    def measure(self, done: int) -> float | None:
        """Return evaluations per second of late; ``None`` while there are few."""
        (since, before), now = self._marks[0], self._clock()
        new = done - before
        return new / (now - since) if self._first is not None and new >= self.min_count and now > since else None
