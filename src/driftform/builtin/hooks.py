"""Hook implementations of driftform itself: fitness by the closest approach, and the recorders of tables."""

from driftform import hookimpl


@hookimpl
def driftform_fitness() -> list[type]:
    """Return the paper's fitness, equation 25, that of outlets, and that of groups of targets."""
    from driftform.builtin.fitness import ClosestApproach, GroupFitness, OutletFitness

    return [ClosestApproach, GroupFitness, OutletFitness]


@hookimpl
def driftform_recorder() -> list[type]:
    """Return the recorders of tables, CSV and Parquet."""
    from driftform.builtin.table_recorders import CsvRecorder, ParquetRecorder

    return [CsvRecorder, ParquetRecorder]
