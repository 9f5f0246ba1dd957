"""driftform's own entry point: the strategies and the fitness of the paper, through the same hooks as any plugin."""

from typing import TYPE_CHECKING, Any

from driftform import hookimpl

if TYPE_CHECKING:
    from driftform.interfaces import Fitness, Strategy


@hookimpl
def driftform_fitness() -> "type[Fitness[Any]]":
    """Equation 25."""
    from driftform.fitness import ClosestApproach

    return ClosestApproach


@hookimpl
def driftform_strategy() -> "list[type[Strategy[Any]]]":
    """The paper's genetic algorithm, and the random search it has to beat."""
    from driftform.strategies.paper import PaperStrategy
    from driftform.strategies.random import RandomStrategy

    return [PaperStrategy, RandomStrategy]
