"""Hook implementations of driftform itself: the paper's fitness, the strategies, and the recorders of tables."""

from typing import TYPE_CHECKING, Any

from driftform import hookimpl

if TYPE_CHECKING:
    from driftform.interfaces import Fitness, Recorder, Strategy


@hookimpl
def driftform_fitness() -> "list[type[Fitness[Any]]]":
    """Return the paper's fitness, equation 25, that of outlets, and that of groups of targets."""
    from driftform.builtin.closest_approach import ClosestApproach
    from driftform.builtin.group import GroupFitness
    from driftform.builtin.outlet import OutletFitness

    return [ClosestApproach, GroupFitness, OutletFitness]


@hookimpl
def driftform_recorder() -> "list[type[Recorder[Any]]]":
    """Return the recorders of tables, CSV and Parquet."""
    from driftform.builtin.table_recorders import CsvRecorder, ParquetRecorder

    return [CsvRecorder, ParquetRecorder]


@hookimpl
def driftform_strategy() -> "list[type[Strategy[Any]]]":
    """Return evolution by single symbols, random search, and the searches of tuned bodies."""
    from driftform.search.strategies.direct import DirectStrategy
    from driftform.search.strategies.evolution import EvolutionStrategy
    from driftform.search.strategies.random import RandomStrategy
    from driftform.search.strategies.tuned import TunedStrategy

    return [DirectStrategy, EvolutionStrategy, RandomStrategy, TunedStrategy]
