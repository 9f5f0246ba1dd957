"""Hook implementations of driftform itself: fitness by the closest approach, and the recorders of tables."""

from typing import TYPE_CHECKING, Any

from driftform import hookimpl

if TYPE_CHECKING:
    from driftform.interfaces import Fitness, Recorder


@hookimpl
def driftform_fitness() -> "list[type[Fitness[Any]]]":
    """Return the paper's fitness, equation 25, that of outlets, and that of groups of targets."""
    from driftform.builtin.fitness import ClosestApproach, GroupFitness, OutletFitness

    return [ClosestApproach, GroupFitness, OutletFitness]


@hookimpl
def driftform_recorder() -> "list[type[Recorder[Any]]]":
    """Return the recorders of tables, CSV and Parquet."""
    from driftform.builtin.table_recorders import CsvRecorder, ParquetRecorder

    return [CsvRecorder, ParquetRecorder]
