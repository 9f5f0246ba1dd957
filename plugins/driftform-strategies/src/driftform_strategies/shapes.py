"""Shapes that can be tuned: drawn and weighed by functions that a worker of the run may call."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from hashlib import blake2b
from math import sqrt
from typing import Any

import numpy as np

from driftform.interfaces import Grammar, PhenotypeBuilder
from driftform.types import FloatArray, Genome, MassProperties
from driftform.water import Fluid
from driftform_strategies.tuning import root_weight, square_root_weight

MAX_DRAWS = 200
"""Number of genomes that are drawn in the search for a new shape that can be tuned."""

DRAG = 1.0
"""Drag coefficient, on length times greatest diameter, by which the first response to a change of weight is guessed."""


@dataclass(eq=False)
class Shape:
    """A shape, and how its flights passed the targets.

    Attributes:
        genome: untuned.
        bounds: least and greatest tuning.
        neutral, rate: tuning without net weight, and net weight (kg) for each unit of tuning above that.
        size: length times greatest diameter, m2.
        name: a number that hardly any other body has.
        points: of each flight the root of its net weight, and its offset from each target, m, (targets, 3).
        tried: targets that it was tuned for.
        is_plain: whether it has no modules.
    """

    genome: Genome
    bounds: tuple[float, float]
    neutral: float
    rate: float
    size: float
    name: int = 0
    points: list[tuple[float, FloatArray]] = field(default_factory=list)
    tried: set[int] = field(default_factory=set)
    is_plain: bool = False

    def tune(self, root: float) -> float:
        """Return the tuning that gives a root of the net weight, within the bounds."""
        low, high = self.bounds
        return min(max(self.neutral + square_root_weight(root) / self.rate, low), high)

    def find_root(self, tuning: float) -> float:
        """Return the root of the net weight that a tuning gives."""
        return root_weight((tuning - self.neutral) * self.rate)


@dataclass(frozen=True)
class Aim:
    """A target as a body of some size sees it.

    Attributes:
        drop: its depth below the release, across the pipe, m; 0 in a pipe that is not straight, where depth does not decide how it is hit.
        way: its distance from the release, m.
        speed: of the current, m/s.
        fluid: the water.
        outlet: the outlet that is the target, however far from its centre a body leaves; ``None`` for a point.
    """

    drop: float
    way: float
    speed: float
    fluid: Fluid
    outlet: str | None = None

    def guess_response(self, size: float) -> float:
        """Return by how much a body should pass lower for each kg^1/2 of the root of its net weight, m."""
        sinking = sqrt(2 * self.fluid.gravity / (self.fluid.density * DRAG * size))
        return sinking * self.way / max(self.speed, 1e-6)

    def guess_root(self, size: float) -> float:
        """Return the root of the net weight with which a body should hit, by its size alone, kg^1/2."""
        return self.drop / self.guess_response(size)

    def may_be_hit(self, shape: Shape) -> bool:
        """Return whether a shape can be made as light or as heavy as it should have to be."""
        root = self.guess_root(shape.size)
        return self.outlet is not None or abs(shape.find_root(shape.tune(root)) - root) < 1e-6


def draw_random(grammar: Grammar[Any], builder: PhenotypeBuilder[Any], aim: Aim, draws: int, seed: int) -> Shape | None:
    """Return the first of some random shapes that may hit, or else the last that can be tuned; ``None`` without one."""
    rng, found = np.random.default_rng(seed), None
    for _ in range(draws):
        shape = _draw(lambda: grammar.random(rng), grammar, builder, aim.fluid.density)
        found = shape or found
        if shape is not None and aim.may_be_hit(shape):
            break
    return found


def draw_plain(grammar: Grammar[Any], builder: PhenotypeBuilder[Any], aim: Aim) -> Shape | None:
    """Return the body without modules, if the grammar has it and it can be tuned."""
    genome = grammar.plain()
    shape = None if genome is None else _examine(genome, grammar, builder, aim.fluid.density)
    return None if shape is None else replace(shape, is_plain=True)


def draw_even(grammar: Grammar[Any], builder: PhenotypeBuilder[Any], aim: Aim, draws: int, seed: int) -> Shape | None:
    """Return the random shape whose wall is inclined least, of some that may hit if there are any; ``None`` without one."""
    seeds = np.random.default_rng(seed).integers(2**63, size=draws)
    found = [draw_random(grammar, builder, aim, 1, int(one)) for one in seeds]
    shapes = [shape for shape in found if shape is not None]

    def measure_incline(shape: Shape) -> float:
        """Return the mean inclination of the wall, rad."""
        modules = grammar.express(shape.genome).modules
        length = sum(module.length for module in modules)
        return sum(abs(module.tilt) * module.length for module in modules) / max(length, 1e-9)

    return min(
        filter(aim.may_be_hit, shapes), key=measure_incline, default=min(shapes, key=measure_incline, default=None)
    )


def vary(
    grammar: Grammar[Any],
    builder: PhenotypeBuilder[Any],
    aim: Aim,
    parents: tuple[Genome, Genome],
    cross: float,
    seed: int,
) -> Shape | None:
    """Return a shape that descends from the first of two genomes, and with the share ``cross`` from both; ``None`` if it has no symbols."""
    genome, other = parents
    rng = np.random.default_rng(seed)

    def change() -> Genome:
        if rng.random() < cross:
            child = grammar.crossover(genome, other, rng)[0]
            if child != genome:
                return child
        return grammar.flip(genome, int(rng.integers(len(genome.symbols))), rng)

    return _draw(change, grammar, builder, aim.fluid.density) if genome.symbols else None


def _draw(
    draw: Callable[[], Genome], grammar: Grammar[Any], builder: PhenotypeBuilder[Any], water: float
) -> Shape | None:
    """Return the first shape that can be tuned to float freely in water of a density (kg/m3), of some that are drawn."""
    for _ in range(MAX_DRAWS):
        if (shape := _examine(draw(), grammar, builder, water)) is not None:
            return shape
    return None


def _examine(genome: Genome, grammar: Grammar[Any], builder: PhenotypeBuilder[Any], water: float) -> Shape | None:
    from driftform.agent import mass_properties

    def weigh(tuning: float) -> MassProperties:
        return mass_properties(builder.build(replace(morphology, tuning=tuning)))

    try:
        morphology = grammar.express(genome)
        body = builder.build(morphology)
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
    name = blake2b(body.outer.tobytes() + body.cavity.tobytes(), digest_size=8).digest()
    return Shape(genome, bounds, neutral, rate, body.length * body.max_diameter, int.from_bytes(name))
