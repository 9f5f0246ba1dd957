"""A fitness in words and in the cells of tables: those of the fitness in use."""

from collections.abc import Mapping
from typing import Any

from driftform.interfaces import Fitness
from driftform.types import Verdict


def list_headings(fitness: Fitness[Any]) -> tuple[str, ...]:
    """Return the headings of the columns of :func:`list_cells`."""
    return ("fitness %",) if fitness.heading == Fitness.heading else ("fitness %", fitness.heading)


def list_cells(fitness: Fitness[Any], value: float) -> tuple[str, ...]:
    """Return a fitness (%), and beside it what people read of it."""
    return (f"{value:.3f}", f"{fitness.measure(value):.3f}")[: len(list_headings(fitness))]


def summarise(fitness: Fitness[Any], values: Mapping[str, float]) -> str:
    """Return how many targets are reached, and the worst one, from the fitness (%) for each target."""
    reached = sum(fitness.judge(value) == Verdict.REACHED for value in values.values())
    subject = f"{reached} of {len(values)} targets are"
    if len(values) == 1:
        subject = "The target is" if reached else "The target is not"
    return f"{subject} reached: {fitness.goal}; {describe_worst(fitness, values)}"


def describe_worst(fitness: Fitness[Any], values: Mapping[str, float]) -> str:
    """Return the target with the least fitness, and what people read of it."""
    worst = min(values, key=lambda target: values[target])
    return f"{fitness.heading} at worst {fitness.measure(values[worst]):.2f} ({worst})"
