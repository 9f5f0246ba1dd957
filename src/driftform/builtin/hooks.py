"""driftform's own entry point: what is in the paper, and flights as tables, through the same hooks as any plugin."""

from typing import TYPE_CHECKING, Any

from driftform import hookimpl

if TYPE_CHECKING:
    from driftform.interfaces import Fitness, Recorder, Strategy


@hookimpl
def driftform_fitness() -> "type[Fitness[Any]]":
    """Equation 25."""
    from driftform.builtin.closest_approach import ClosestApproach

    return ClosestApproach


@hookimpl
def driftform_recorder() -> "list[type[Recorder[Any]]]":
    """A flight as a table."""
    from driftform.builtin.table_recorders import CsvRecorder, ParquetRecorder

    return [CsvRecorder, ParquetRecorder]


@hookimpl
def driftform_strategy() -> "list[type[Strategy[Any]]]":
    """The paper's genetic algorithm, random search, one that is far better, and a map of all that can be reached."""
    from driftform.builtin.strategies.atlas import AtlasStrategy
    from driftform.builtin.strategies.evolution import EvolutionStrategy
    from driftform.builtin.strategies.paper import PaperStrategy
    from driftform.builtin.strategies.random import RandomStrategy

    return [AtlasStrategy, EvolutionStrategy, PaperStrategy, RandomStrategy]
