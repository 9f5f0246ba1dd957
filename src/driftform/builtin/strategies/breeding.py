"""Offspring of one parent or of two, by the operators of any grammar."""

from typing import Any

import numpy as np

from driftform.interfaces import Grammar
from driftform.types import Genome


def breed(
    grammar: Grammar[Any],
    one: Genome,
    other: Genome,
    rng: np.random.Generator,
    *,
    crossover: float,
    mutation_rate: float,
) -> tuple[Genome, bool]:
    """Return a child that differs from both, and whether it descends from ``other`` too.

    ``crossover`` is the probability of that, ``mutation_rate`` that of each symbol to flip. A child that comes out
    like a parent has one symbol flipped: it would fly as the parent did.
    """
    crossed = bool(rng.random() < crossover)
    child = grammar.crossover(one, other, rng)[0] if crossed else one
    child = grammar.mutate(child, rng, mutation_rate)
    if child in (one, other) and child.symbols:
        child = grammar.flip(child, int(rng.integers(len(child.symbols))), rng)
    return child, crossed
