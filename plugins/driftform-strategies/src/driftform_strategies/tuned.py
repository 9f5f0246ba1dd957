"""Searches of tuned bodies: each is made to hit its target by its ballast, and judged by how well it keeps it."""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import count
from math import inf, sqrt
from typing import Any

import numpy as np

from driftform.errors import InputError
from driftform.interfaces import SearchSpace, Strategy, Table, option
from driftform.types import Candidate, Evaluation
from driftform_strategies.evolution import remember
from driftform_strategies.shapes import Aim, Shape, draw_even, draw_plain, draw_random, vary
from driftform_strategies.tuning import find_next, find_up, measure_heights

Drawn = Callable[[], Shape | None]
"""Waits until a shape is drawn."""

HIT = 0.001
"""m: a tuned body that passes its target this near has hit it."""

NEAR = 0.5
"""Share of the distance within which a flight hits, in which a body is judged where it cannot always be tuned to hit."""

MAX_UNFIT = 10
"""Random shapes that are drawn at most to find one that can be heavy or light enough for a target."""

MAX_KNOWN = 20
"""Shapes that are drawn at most to find one that was not drawn before."""

EVEN = 30
"""Random shapes of which the one whose wall is inclined least is taken."""


class TunedOptions(Table):
    """Options of the evolution of tuned bodies."""

    shapes: int = option(10, "random shapes at the start", "", gt=0, le=1_000_000)
    batch: int = option(3, "flights per batch; one batch is asked for while another is flown", "", gt=0, le=100_000)
    elites: int = option(4, "best shapes kept for each target, from which others descend", "", gt=0, le=10_000)
    flights: int = option(6, "most flights to tune a shape for a target", "", gt=1, le=1000)
    first: int = option(3, "bodies for each target before those with a large miss get more", "", gt=0, le=10_000)
    pressure: float = option(
        1.0,
        "the share of the bodies for a target is proportional to this power of the miss of its best",
        "",
        ge=0,
        le=10,
    )
    retune: float = option(
        0.3, "share of the new bodies that have a shape which is among the best for another target", "", ge=0, le=1
    )
    random: float = option(0.1, "share of the new bodies that have a random shape", "", ge=0, le=1)
    cross: float = option(0.2, "share of the changed shapes that descend from two", "", ge=0, le=1)


STEP = 1.25
"""Factor between the roots of the net weight at which a body that rides the wall is tried under disturbed conditions."""


@dataclass(eq=False)
class Job:
    """A shape on its way to hit a target: ``flights`` it had, the ``tuning`` of the next, and the miss (m) below which that matters.

    One that has hit, at the root ``hit`` of its net weight, is tuned on: ``root`` did best, with a ``score`` (%), and the next is
    ``factor`` times that.
    """

    shape: Shape
    target: int
    tuning: float
    parents: tuple[int, ...] = ()
    flights: int = 0
    bar: float = HIT
    hit: float | None = None
    root: float = 0.0
    score: float = 0.0
    factor: float = STEP


@dataclass(frozen=True, eq=False)
class _Start:
    """A body that is about to be tuned: its target, the elite that it descends from, and its shape, or what draws it."""

    target: int
    elite: "_Elite | None"
    shape: Shape | None
    draw: "Callable[[], Drawn] | None" = None
    drawn: "Drawn | None" = None


@dataclass(frozen=True, eq=False)
class _Elite:
    fitness: float
    index: int
    shape: Shape
    root: float


class TunedStrategy(Strategy[TunedOptions]):
    """Evolution of shapes: each body is tuned until it hits its target, and then judged by its flights in disturbed water.

    The tuning, such as the mass of ballast, is found by a secant on the height at which the body passes the target, or, in a riser,
    on its distance in the direction in which the tuning moves it, with 3 to 6 flights; for an outlet it is drawn until the body leaves there. Bodies that hit race against each other: under few
    disturbed conditions all of them, under many only the best. Where none hits, those that pass nearer than all before race
    too. The best body for a target, and the plain one, are tuned on there by steps of a quarter of their speed of sinking if
    they touch the wall near the target, or the pipe is not straight: a lighter one, say, rides the ceiling in any gust. New shapes are those of the best
    bodies with one symbol changed, mixtures of two of them, shapes that are good for another target, and random ones. No body
    flies twice. The first body for each target is the plain one, if the builder makes one that can be tuned: it is not varied.
    """

    name = "tuned"
    Options = TunedOptions

    def __init__(self, options: TunedOptions, space: SearchSpace) -> None:
        from driftform.motion import path

        super().__init__(options, space)
        if space.builder is None:
            raise InputError("strategy 'tuned' needs a builder")
        self._elites: list[list[_Elite]] = [[] for _ in space.targets]
        self._started = [0] * len(space.targets)
        self._nearest = [inf] * len(space.targets)
        self._fresh: list[Shape] = []
        self._plain: Drawn | None = None
        self._coming: deque[_Start] = deque()
        self._ready: deque[Job] = deque()
        self._asked: deque[list[Job]] = deque()
        self._bodies: dict[int, None] = {}
        self._numbers = count()
        self._unfit: set[int] = set()
        scenario, robustness = space.scenario, space.scenario.robustness
        self._is_surveyed = min(robustness.survey, robustness.conditions) > 0
        release, points = scenario.release_position(), scenario.target_array().reshape(-1, 3)
        self._up = find_up(scenario)
        # In a straight pipe a neutral body passes a target by as much above it as this lies below the release.
        drops = np.zeros(len(points)) if self._up is None else (release - points) @ self._up
        self._aims = [
            Aim(float(drop), float(way), scenario.flow.speed, scenario.fluid, at if isinstance(at, str) else None)
            for drop, way, at in zip(
                drops, np.linalg.norm(points - release, axis=1), map(scenario.targets.get, space.targets), strict=True
            )
        ]
        self._reach = path.farthest_distances(scenario) if space.targets else np.zeros(0)
        # Behind a bend the path may jump with the net weight: what passes near cannot always be tuned to hit.
        self._jumps = np.array([self._up is None and aim.outlet is None for aim in self._aims], dtype=bool)
        self._near = np.where(self._jumps, np.maximum(HIT, NEAR * path.find_within(scenario)), HIT)

    def ask(self, limit: int) -> list[Candidate]:
        """Return the next flights of bodies that are being tuned, and the first ones of new bodies."""
        jobs = [self._ready.popleft() for _ in range(min(len(self._ready), self.options.batch))]
        while len(jobs) < self.options.batch:
            if not self._coming:
                self._coming.append(self._prepare(self._choose_target()))
            jobs.append(self._start_job(self._coming.popleft()))
        # The workers draw the next shapes while they fly these.
        while len(self._coming) < self.options.batch:
            self._coming.append(self._prepare(self._choose_target()))
        generation = next(self._numbers)
        candidates = [self._make_candidate(job, generation) for job in jobs[:limit]]
        self._asked.append(jobs[:limit])
        return candidates

    def can_ask_ahead(self) -> bool:
        """Return True: bodies are tuned independently of each other."""
        return True

    def tell(self, first: int, evaluations: Sequence[Evaluation]) -> None:
        """Find the next tuning of each body, or rank a body that has hit."""
        for index, (job, evaluation) in enumerate(zip(self._asked.popleft(), evaluations, strict=True), first):
            job.flights += 1
            job.parents = (index,)
            if evaluation.failure is None:
                self._learn(index, job, evaluation)

    def _learn(self, index: int, job: Job, evaluation: Evaluation) -> None:
        from driftform.motion import path

        shape, root = job.shape, job.shape.find_root(job.tuning)
        offsets, outlet = path.find_offsets(evaluation, self.space.scenario), self._aims[job.target].outlet
        shape.points.append((root, offsets))
        miss = float(np.linalg.norm(offsets[job.target]))
        hits = miss <= HIT
        if outlet is not None:
            flight = evaluation.trajectory
            hits = flight is not None and path.name_outlet(flight, self.space.scenario) == outlet
            miss = 0.0 if hits else inf
        self._nearest[job.target] = min(miss, self._nearest[job.target])
        ranked, score, elites = hits or miss < job.bar, float(evaluation.fitness[job.target]), self._elites[job.target]
        if ranked and not shape.is_plain:
            best = _Elite(score, index, shape, root if job.hit is None else job.hit)
            # One place for each shape, by the best of its tunings.
            known = [elite for elite in elites if elite.shape is not shape or elite.fitness > score]
            if all(elite.shape is not shape for elite in known):
                known.append(best)
            elites[:] = sorted(known, key=lambda elite: -elite.fitness)[: self.options.elites]
        may_hit = job.hit is None and not hits and job.flights < self.options.flights
        if may_hit and (tuning := self._find_tuning(shape, job.target)) is not None:
            job.tuning = tuning
            self._ready.append(job)
        elif job.hit is not None or (ranked and self._may_ride(job, evaluation)):
            self._tune_on(job, root, score)

    def _may_ride(self, job: Job, evaluation: Evaluation) -> bool:
        """Return whether the best body for a target, or the plain one, would touch the wall before it if it rose or sank a step faster.

        Where its path may jump, it is tried in any case.
        """
        from driftform.motion import path

        elites, flight = self._elites[job.target], evaluation.trajectory
        is_best = job.shape.is_plain or (bool(elites) and elites[0].shape is job.shape)
        if not (self._is_surveyed and is_best) or flight is None:
            return False
        if self._jumps[job.target]:
            return True
        return flight.contact is not None and bool(
            flight.contact <= STEP * path.approach_targets(flight, self.space.scenario)[1][job.target]
        )

    def _tune_on(self, job: Job, root: float, score: float) -> None:
        """Take a further step in the same direction while that improves a body; try the other one if the first did not."""
        if job.hit is None:
            job.hit = job.root = root
            job.score = score
        elif score > job.score:
            job.root, job.score = root, score
        elif job.root == job.hit and job.factor > 1:
            job.factor = 1 / job.factor
        else:
            return
        tuning = job.shape.tune(job.root * job.factor)
        if tuning != job.shape.tune(job.root):
            # However it passes the target in the mean flow.
            job.tuning, job.bar = tuning, inf
            self._ready.append(job)

    def _find_tuning(self, shape: Shape, target: int) -> float | None:
        """Return the tuning of the next flight of a shape for a target; ``None`` if it cannot come nearer."""
        aim = self._aims[target]
        if aim.outlet is not None:
            return self._draw_tuning(shape)
        points = measure_heights([(root, offsets[target]) for root, offsets in shape.points], self._up)
        response = -aim.guess_response(shape.size)
        if self._up is not None and len(points) == 1 and points[0][0]:
            # With what a body without net weight should do, one flight shows the response.
            [(root, height)] = points
            seen = (height - aim.drop) / root
            response = min(max(seen, 5 * response), response / 5)
        found = find_next(points, response)
        if found is None:
            return None
        tuning = shape.tune(found)
        return None if any(shape.tune(root) == tuning for root, _ in points) else tuning

    def _draw_tuning(self, shape: Shape) -> float:
        """Return a random tuning: the outlet that a body takes does not follow from where another passed."""
        light, heavy = map(shape.find_root, shape.bounds)
        return shape.tune(float(self.space.rng.uniform(light, heavy)))

    def _prepare(self, target: int) -> _Start:
        """Choose what a body for a target descends from, and let its shape be drawn."""
        rng, options, elites = self.space.rng, self.options, self._elites[target]
        self._started[target] += 1
        if self._plain is None:
            self._plain = self.space.begin(draw_plain, self._aims[target])
        if self._started[target] == 1 and (plain := self._plain()) is not None:
            return self._take(target, None, plain)
        if elites and (draw := rng.random()) >= options.random:
            others = [one for them in self._elites for one in them if target not in one.shape.tried]
            if others and draw < options.random + options.retune:
                elite = others[int(rng.integers(len(others)))]
                return self._take(target, elite, elite.shape)
            elite = self._draw_elite(elites)
            other = self._draw_elite(self._elites[int(rng.integers(len(self._elites)))] or [elite])
            if elite.shape.genome.symbols:
                parents = elite.shape.genome, other.shape.genome
                return self._let_draw(target, elite, vary, parents, options.cross)
        return self._prepare_random(target)

    def _prepare_random(self, target: int) -> _Start:
        """Let a random shape be drawn, or take one of the first that serve all targets."""
        untried = [shape for shape in self._fresh if target not in shape.tried and self._aims[target].may_be_hit(shape)]
        coming = sum(start.elite is None and start.shape is None for start in self._coming)
        if len(self._fresh) + coming < self.options.shapes or not untried:
            # Where so many were in vain before, the next will hardly be fit: each costs more than the flights of a body.
            return self._let_draw(target, None, draw_random, 1 if target in self._unfit else MAX_UNFIT)
        return self._take(target, None, untried[int(self.space.rng.integers(len(untried)))])

    def _take(self, target: int, elite: _Elite | None, shape: Shape) -> _Start:
        shape.tried.add(target)
        return _Start(target, elite, shape)

    def _let_draw(self, target: int, elite: _Elite | None, draw: Callable[..., Shape | None], *args: Any) -> _Start:
        """Let a worker call a function of :mod:`driftform_strategies.shapes` with an aim, arguments, and a seed."""

        def begin() -> Drawn:
            return self.space.begin(draw, self._aims[target], *args, int(self.space.rng.integers(2**63)))

        return _Start(target, elite, None, begin, begin())

    def _receive(self, start: _Start) -> Shape | None:
        """Return the shape of a body, or ``None`` if no new one could be drawn."""
        if start.shape is not None or start.draw is None or start.drawn is None:
            return start.shape
        shape = start.drawn()
        for _ in range(MAX_KNOWN):
            if shape is None or shape.name not in self._bodies:
                break
            shape = start.draw()()
        if shape is None or shape.name in self._bodies:
            return None
        remember(self._bodies, [shape.name])
        return shape

    def _start_job(self, start: _Start) -> Job:
        target, aim, elite, shape = start.target, self._aims[start.target], start.elite, self._receive(start)
        if shape is None:
            # In a small space all shapes may be known: one of them is tried again.
            elite, known = None, [one for one in self._fresh if target not in one.tried] or self._fresh
            if not known:
                raise InputError(
                    f"strategy '{self.name}': no shape of the grammar can be tuned: set [builder] tuning to 'ballast' or "
                    "'wall', or use the strategy 'evolution'"
                )
            shape = known[int(self.space.rng.integers(len(known)))]
        elif start.shape is None and elite is None:
            if not aim.may_be_hit(shape):
                self._unfit.add(target)
            if len(self._fresh) < self.options.shapes:
                self._fresh.append(shape)
        shape.tried.add(target)
        tuning = self._find_tuning(shape, target) if shape.points else None
        if tuning is None and elite is not None and not shape.points:
            tuning = shape.tune(elite.root * sqrt(shape.size / elite.shape.size))
        if tuning is None and aim.outlet is not None:
            tuning = self._draw_tuning(shape)
        if tuning is None:
            tuning = shape.tune(aim.guess_root(shape.size))
        return Job(shape, target, tuning, () if elite is None else (elite.index,))

    def _choose_target(self) -> int:
        """Return the target that a new body is made for: at first each in turn, then by the miss of its best body."""
        first, least = self.options.first, min(self._started)
        if least < first:
            coming = {start.target for start in self._coming}
            coming |= {job.target for jobs in (self._ready, *self._asked) for job in jobs}
            # Until each target is hit by one body: 2 * first bodies are enough to find that none can.
            lacking = [
                k
                for k, n in enumerate(self._started)
                if least and n < 2 * first and not self._elites[k] and k not in coming
            ]
            return int(self.space.rng.choice(lacking or [k for k, n in enumerate(self._started) if n == least]))
        misses = np.array([100 - elites[0].fitness if elites else 100.0 for elites in self._elites])
        weights = np.maximum(misses, 1e-9) ** self.options.pressure
        return int(self.space.rng.choice(len(weights), p=weights / weights.sum()))

    def _draw_elite(self, elites: Sequence[_Elite]) -> _Elite:
        """Return the best with probability 1/2, the second with 1/4, and so on."""
        return elites[min(int(self.space.rng.geometric(0.5)), len(elites)) - 1]

    def _make_candidate(self, job: Job, generation: int) -> Candidate:
        """Return the next flight of a body, which matters if it hits, or, where none did, if it passes nearer than all before."""
        target = job.target
        if job.hit is None:
            missed = self._started[target] > self.options.first and self._aims[target].outlet is None
            job.bar = max(self._near[target], self._nearest[target] if missed else 0.0)
        threshold = [inf] * len(self.space.targets)
        threshold[target] = 100 * (1 - job.bar / float(self._reach[target]))
        genome = replace(job.shape.genome, tuning=job.tuning)
        return Candidate(genome, job.parents, generation, self.space.targets[target], tuple(threshold))


class DirectStrategy(TunedStrategy):
    """No evolution: a plain body, near to a cylinder, is tuned for each target, then another one.

    The body is that of some random ones whose wall is inclined least. It shows what is gained without a search for shapes.
    """

    name = "direct"

    def _prepare(self, target: int) -> _Start:
        self._started[target] += 1
        for shape in self._fresh:
            if target not in shape.tried:
                return self._take(target, None, shape)
        return self._let_draw(target, None, draw_even, EVEN)
