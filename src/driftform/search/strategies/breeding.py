"""Offspring of one or two parents, by the operators of any grammar."""

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
    """Return a child that differs from both parents, and True if it descends from ``other`` too.

    ``crossover`` is the probability of two parents, ``mutation_rate`` that of each symbol to flip. If the child equals a
    parent, one of its symbols is flipped: otherwise it would fly as the parent did.
    """
    crossed = bool(rng.random() < crossover)
    child = grammar.crossover(one, other, rng)[0] if crossed else one
    child = grammar.mutate(child, rng, mutation_rate)
    if child in (one, other) and child.symbols:
        child = grammar.flip(child, int(rng.integers(len(child.symbols))), rng)
    return child, crossed
