"""The state of a run in numbers, counted evaluation by evaluation, in any order and in little memory."""

import time
from bisect import bisect_right
from collections import deque
from collections.abc import Callable, Sequence

from driftform.errors import ReasonTally

MAX_STEPS = 512
"""Number of improvements of a target that are kept: far more than a terminal has columns."""


class TargetStatus:
    """The state of a run for one target.

    Attributes:
        best: the largest fitness of a sound evaluation, 0 before any.
        index: the evaluation that has it, the earliest of equals; -1 before any.
        generation: the newest of the population that works for the target, -1 before any.
        failed: how many evaluations of that population failed.
    """

    def __init__(self) -> None:
        self.best = 0.0
        self.index = -1
        self.generation = -1
        self.failed = 0
        self._sum = 0.0
        self._count = 0
        self._steps: tuple[tuple[int, float], ...] = ()

    @property
    def mean(self) -> float | None:
        """Mean fitness of the newest generation, without those that failed; ``None`` if all of them failed."""
        return self._sum / self._count if self._count else None

    @property
    def first(self) -> float | None:
        """The error (%) of the earliest sound evaluation, where all curves begin; ``None`` before any."""
        return self._steps[0][1] if self._steps else None

    def count(self, generation: int, failed: bool, fitness: float) -> None:
        """Count an evaluation of the population that works for the target."""
        if generation > self.generation:
            self.generation, self._sum, self._count = generation, 0.0, 0
        self.failed += failed
        if generation == self.generation and not failed:
            self._sum += fitness
            self._count += 1

    def score(self, index: int, fitness: float) -> None:
        """Compare a sound evaluation of any population with the best."""
        if (fitness, -index) > (self.best, -self.index) or self.index < 0:
            self.best, self.index = fitness, index
        error = 100 - fitness
        before = bisect_right(self._steps, (index, error))
        if before and self._steps[before - 1][1] <= error:
            return
        # Evaluations come in any order: what is later and no better is no improvement any more.
        after = before
        while after < len(self._steps) and self._steps[after][1] >= error:
            after += 1
        steps = (*self._steps[:before], (index, error), *self._steps[after:])
        if len(steps) > MAX_STEPS:
            # Of those that lie close together, the last.
            width = steps[-1][0] + 1
            steps = tuple({step[0] * (MAX_STEPS // 2) // width: step for step in steps}.values())
        # Put in place as a whole, for another thread may be drawing it.
        self._steps = steps

    def errors(self, columns: int, evaluations: int) -> list[float | None]:
        """The best error (%) so far at the end of each of ``columns`` equal parts of the run; ``None`` before any."""
        steps = self._steps
        found: list[float | None] = []
        for column in range(1, columns + 1):
            # The last evaluation of this part, rounded up: the first part has at least one.
            last = -(-column * evaluations // columns) - 1
            place = bisect_right(steps, last, key=lambda step: step[0])
            found.append(steps[place - 1][1] if place else None)
        return found


class RunStatus:
    """The state of a run.

    Attributes:
        budget: evaluations in the whole run.
        done, failed: how many there are, and how many of those failed.
        extent: one more than the largest index of an evaluation: what a curve spans.
        targets: the standing of each target, by its name.
    """

    def __init__(self, targets: Sequence[str], budget: int) -> None:
        self.budget = budget
        self.done = 0
        self.failed = 0
        self.extent = 0
        self.targets = {target: TargetStatus() for target in targets}
        self._reasons = ReasonTally()

    @property
    def commonest_failure(self) -> tuple[str, int]:
        """The first of the commonest kind of failure, and how many there are; ``("", 0)`` without failures."""
        return self._reasons.commonest

    def add(self, index: int, generation: int, population: str, failure: str | None, fitness: Sequence[float]) -> None:
        """Count one evaluation; ``population`` is the target that its population works for, ``""`` for all."""
        failed = failure is not None
        self.done += 1
        self.failed += failed
        if failure is not None:
            self._reasons.add(failure)
        self.extent = max(self.extent, index + 1)
        for (target, standing), value in zip(self.targets.items(), fitness, strict=True):
            if population in (target, ""):
                standing.count(generation, failed, value)
            if not failed:
                standing.score(index, value)


class Throughput:
    """How fast evaluations come, now and overall.

    Those that were there at the beginning do not count, nor does the time until the first new ones: kernels are
    compiled in it.
    """

    window = 30.0
    """How far back "now" reaches, s."""

    settling = 1.0
    """Evaluations that come this soon after the first, s, are as old as it: several are computed at once."""

    min_count = 5
    """Evaluations that a rate needs; fewer would make it jump."""

    def __init__(self, done: int, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._began = clock()
        self._before = done
        self._first: float | None = None
        self._settled = (self._began, done)
        self._marks = deque([self._settled])

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
            self._settled = (now, done)
            self._marks = deque([self._settled])
        elif now - self._marks[-1][0] >= self.window / 30:
            self._marks.append((now, done))
        while len(self._marks) > 1 and self._is_enough(*self._marks[1], now, done):
            self._marks.popleft()

    def overall(self, done: int) -> float | None:
        """Evaluations per second since the first of them; ``None`` while there are few."""
        return self._rate(*self._settled, done)

    def recent(self, done: int) -> float | None:
        """Evaluations per second of late; ``None`` while there are few."""
        return self._rate(*self._marks[0], done)

    def _rate(self, since: float, before: int, done: int) -> float | None:
        new, span = done - before, self._clock() - since
        return new / span if self._first is not None and new >= self.min_count and span > 0 else None

    def _is_enough(self, since: float, before: int, now: float, done: int) -> bool:
        return since < now - self.window and done - before >= self.min_count
