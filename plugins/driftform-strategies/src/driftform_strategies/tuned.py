"""Searches of tuned bodies: each is made to hit its target by its ballast, and judged by how well it keeps it."""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import count
from math import inf, sqrt

import numpy as np

from driftform.errors import InputError
from driftform.interfaces import SearchSpace, Strategy, Table, option
from driftform.types import Candidate, Evaluation, FloatArray, Genome, MassProperties
from driftform_strategies.evolution import remember
from driftform_strategies.tuning import find_next, root_weight, square_root_weight

HIT = 0.001
"""m: a tuned body that passes its target this near has hit it."""

MAX_DRAWS = 200
"""Number of genomes that are drawn in the search for a new shape that can be tuned."""

MAX_UNFIT = 10
"""Random shapes that are drawn at most to find one that can be heavy or light enough for a target."""

DRAG = 1.0
"""Drag coefficient, on length times greatest diameter, by which the first response to a change of weight is guessed."""

PLAIN = 30
"""Random shapes of which the plainest is taken."""


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


@dataclass(eq=False)
class Shape:
    """A shape, and how its flights passed the targets.

    Attributes:
        genome: untuned.
        bounds: least and greatest tuning.
        neutral, rate: tuning without net weight, and net weight (kg) for each unit of tuning above that.
        size: length times greatest diameter, m2.
        points: of each flight the root of its net weight, and its height above each target, m, (targets,).
        tried: targets that it was tuned for.
    """

    genome: Genome
    bounds: tuple[float, float]
    neutral: float
    rate: float
    size: float
    points: list[tuple[float, FloatArray]] = field(default_factory=list)
    tried: set[int] = field(default_factory=set)

    def tune(self, root: float) -> float:
        """Return the tuning that gives a root of the net weight, within the bounds."""
        low, high = self.bounds
        return min(max(self.neutral + square_root_weight(root) / self.rate, low), high)

    def find_root(self, tuning: float) -> float:
        """Return the root of the net weight that a tuning gives."""
        return root_weight((tuning - self.neutral) * self.rate)


@dataclass(eq=False)
class Job:
    """A shape on its way to hit a target: the tuning of its next flight, and how many it had; ``parents`` of the shape."""

    shape: Shape
    target: int
    tuning: float
    parents: tuple[int, ...] = ()
    flights: int = 0


@dataclass(frozen=True, eq=False)
class _Elite:
    fitness: float
    index: int
    shape: Shape
    root: float


class TunedStrategy(Strategy[TunedOptions]):
    """Evolution of shapes: each body is tuned until it hits its target, and then judged by its flights in disturbed water.

    The tuning, such as the mass of ballast, is found by a secant on the height at which the body passes the target, with
    3 to 6 flights; for an outlet it is drawn until the body leaves there. Bodies that hit race against each other: under few disturbed conditions all of them, under many only
    the best. New shapes are those of the best bodies with one symbol changed, mixtures of two of them, shapes that are
    good for another target, and random ones. No body flies twice.
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
        self._fresh: deque[Shape] = deque()
        self._ready: deque[Job] = deque()
        self._asked: deque[list[Job]] = deque()
        self._bodies: dict[int, None] = {}
        self._numbers = count()
        self._unfit: set[int] = set()
        release = space.scenario.release_position()
        points = space.scenario.target_array().reshape(-1, 3)
        self._ways = np.linalg.norm(points - release, axis=1)
        # How far below the release each target is: in a straight pipe, by how much a neutral body passes above it.
        straight = space.scenario.pipe.straight is not None
        self._drops = release[2] - points[:, 2] if straight else np.zeros(len(points))
        # An outlet is hit by leaving there, however far from its centre.
        wanted = map(space.scenario.targets.get, space.targets)
        self._outlets = [target if isinstance(target, str) else None for target in wanted]
        self._bars = 100 * (1 - HIT / path.farthest_distances(space.scenario)) if space.targets else np.zeros(0)

    def ask(self, limit: int) -> list[Candidate]:
        """Return the next flights of bodies that are being tuned, and the first ones of new bodies."""
        jobs = [self._ready.popleft() for _ in range(min(len(self._ready), self.options.batch))]
        while len(jobs) < self.options.batch:
            jobs.append(self._start_job(self._choose_target()))
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
        offsets, outlet = path.find_offsets(evaluation, self.space.scenario), self._outlets[job.target]
        shape.points.append((root, offsets[:, 2]))
        if outlet is None:
            hits = bool(np.linalg.norm(offsets[job.target]) <= HIT)
        else:
            flight = evaluation.trajectory
            hits = flight is not None and path.name_outlet(flight, self.space.scenario) == outlet
        if hits:
            elites = self._elites[job.target]
            elites.append(_Elite(float(evaluation.fitness[job.target]), index, shape, root))
            elites.sort(key=lambda elite: -elite.fitness)
            del elites[self.options.elites :]
            return
        if job.flights < self.options.flights and (tuning := self._find_tuning(shape, job.target)) is not None:
            job.tuning = tuning
            self._ready.append(job)

    def _find_tuning(self, shape: Shape, target: int) -> float | None:
        """Return the tuning of the next flight of a shape for a target; ``None`` if it cannot come nearer."""
        if self._outlets[target] is not None:
            return self._draw_tuning(shape)
        points = [(root, float(heights[target])) for root, heights in shape.points]
        response = -self._guess_response(shape, target)
        if len(points) == 1 and points[0][0]:
            # With what a body without net weight should do, one flight shows the response.
            [(root, height)] = points
            seen = (height - self._drops[target]) / root
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

    def _guess_root(self, shape: Shape, target: int) -> float:
        """Return the root of the net weight with which a body should hit, by its size alone, kg^1/2."""
        return float(self._drops[target]) / self._guess_response(shape, target)

    def _may_hit(self, shape: Shape, target: int) -> bool:
        """Return whether a shape can be made as light or as heavy as it should have to be."""
        if self._outlets[target] is not None:
            return True
        root = self._guess_root(shape, target)
        return abs(shape.find_root(shape.tune(root)) - root) < 1e-6

    def _guess_response(self, shape: Shape, target: int) -> float:
        """Return by how much a body should pass lower for each kg^1/2 of the root of its net weight, m."""
        fluid = self.space.scenario.fluid
        sinking = sqrt(2 * fluid.gravity / (fluid.density * DRAG * shape.size))
        return sinking * float(self._ways[target]) / max(self.space.scenario.flow.speed, 1e-6)

    def _start_job(self, target: int) -> Job:
        rng, options = self.space.rng, self.options
        self._started[target] += 1
        elites = self._elites[target]
        shape, elite, draw = None, None, rng.random()
        if elites and draw >= options.random:
            if draw < options.random + options.retune:
                others = [one for them in self._elites for one in them if target not in one.shape.tried]
                if others:
                    elite = others[int(rng.integers(len(others)))]
                    shape = elite.shape
            if shape is None:
                elite = self._draw_elite(elites)
                shape = self._vary(elite, target)
        if shape is None:
            # Where so many were in vain before, the next will hardly be fit: each costs more than the flights of a body.
            draws = 1 if target in self._unfit else MAX_UNFIT
            shape, elite = self._take_random(target, draws), None
            if len(self._fresh) < self.options.shapes and shape not in self._fresh:
                self._fresh.append(shape)
        shape.tried.add(target)
        tuning = self._find_tuning(shape, target) if shape.points else None
        if tuning is None and elite is not None and not shape.points:
            tuning = shape.tune(elite.root * sqrt(shape.size / elite.shape.size))
        if tuning is None and self._outlets[target] is not None:
            tuning = self._draw_tuning(shape)
        if tuning is None:
            tuning = shape.tune(self._guess_root(shape, target))
        return Job(shape, target, tuning, () if elite is None else (elite.index,))

    def _choose_target(self) -> int:
        """Return the target that a new body is made for: at first each in turn, then by the miss of its best body."""
        first, least = self.options.first, min(self._started)
        if least < first:
            coming = {job.target for jobs in (self._ready, *self._asked) for job in jobs}
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

    def _take_random(self, target: int, draws: int = MAX_UNFIT) -> Shape:
        """Return a random shape, of some draws the first that may hit; at first one of a few that serve all targets."""
        untried = [shape for shape in self._fresh if target not in shape.tried and self._may_hit(shape, target)]
        if len(self._fresh) < self.options.shapes or not untried:
            found = None
            for _ in range(draws):
                shape = self._draw_shape(lambda: self.space.grammar.random(self.space.rng))
                found = shape or found
                if shape is not None and self._may_hit(shape, target):
                    break
            else:
                self._unfit.add(target)
            if found is not None:
                return found
        # In a small space all shapes may be known: one of them is tried again.
        known = untried or list(self._fresh)
        if not known:
            raise InputError(
                f"strategy '{self.name}': no shape of the grammar can be tuned: set [builder] tuning to 'ballast' or 'wall', "
                "or use the strategy 'evolution'"
            )
        return known[int(self.space.rng.integers(len(known)))]

    def _vary(self, elite: _Elite, target: int) -> Shape | None:
        rng, grammar, genome = self.space.rng, self.space.grammar, elite.shape.genome

        def change() -> Genome:
            if rng.random() < self.options.cross:
                other = self._draw_elite(self._elites[int(rng.integers(len(self._elites)))] or [elite])
                child = grammar.crossover(genome, other.shape.genome, rng)[0]
                if child != genome:
                    return child
            return grammar.flip(genome, int(rng.integers(len(genome.symbols))), rng)

        return self._draw_shape(change) if genome.symbols else None

    def _draw_shape(self, draw: Callable[[], Genome]) -> Shape | None:
        """Return the first new shape that can be tuned to float freely, of some that are drawn."""
        for _ in range(MAX_DRAWS):
            if (shape := self._examine(draw())) is not None:
                return shape
        return None

    def _examine(self, genome: Genome) -> Shape | None:
        from driftform.agent import mass_properties

        builder, water = self.space.builder, self.space.scenario.fluid.density
        assert builder is not None

        def weigh(tuning: float) -> MassProperties:
            return mass_properties(builder.build(replace(morphology, tuning=tuning)))

        try:
            morphology = self.space.grammar.express(genome)
            body = builder.build(morphology)
            name = hash((body.outer.tobytes(), body.cavity.tobytes()))
            if name in self._bodies:
                return None
            remember(self._bodies, [name])
            bounds = builder.find_tunings(morphology)
            if bounds is None or not bounds[0] < bounds[1]:
                return None
            light, heavy = (weigh(at) for at in bounds)
            rate = (heavy.mass - light.mass) / (bounds[1] - bounds[0])
            neutral = bounds[0] + (water * light.volume - light.mass) / rate
            if not bounds[0] < neutral < bounds[1]:
                return None
            # Joints and seats that follow the cavity make the weight not quite linear.
            near = weigh(neutral)
            neutral += (water * near.volume - near.mass) / rate
        except Exception:
            # A grammar or a builder may refuse some shapes, each with an error of its own.
            return None
        return Shape(genome, bounds, neutral, rate, body.length * body.max_diameter)

    def _make_candidate(self, job: Job, generation: int) -> Candidate:
        # Only a hit matters, and what else passes near is not tuned.
        threshold = [inf] * len(self.space.targets)
        threshold[job.target] = float(self._bars[job.target])
        genome = replace(job.shape.genome, tuning=job.tuning)
        return Candidate(genome, job.parents, generation, self.space.targets[job.target], tuple(threshold))


class DirectStrategy(TunedStrategy):
    """No evolution: a plain body, near to a cylinder, is tuned for each target, then another one.

    The body is that of some random ones whose wall is inclined least. It shows what is gained without a search for shapes.
    """

    name = "direct"

    def _start_job(self, target: int) -> Job:
        self._started[target] += 1
        shape = next((shape for shape in self._fresh if target not in shape.tried), None)
        if shape is None:
            found = [self._take_random(target) for _ in range(PLAIN)]
            shape = min(found, key=self._measure_incline)
            if shape not in self._fresh:
                self._fresh.append(shape)
        shape.tried.add(target)
        tuning = self._find_tuning(shape, target) if shape.points else None
        return Job(shape, target, shape.tune(self._guess_root(shape, target)) if tuning is None else tuning)

    def _measure_incline(self, shape: Shape) -> float:
        """Return the mean inclination of the wall of a shape, rad."""
        modules = self.space.grammar.express(shape.genome).modules
        length = sum(module.length for module in modules)
        return sum(abs(module.tilt) * module.length for module in modules) / max(length, 1e-9)
