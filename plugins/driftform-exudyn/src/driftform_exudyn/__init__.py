"""Rigid-body flights integrated by Exudyn, as a driftform plugin."""

from typing import TYPE_CHECKING, Any

from driftform import hookimpl

if TYPE_CHECKING:
    from driftform.interfaces import Simulator


@hookimpl
def driftform_simulator() -> "type[Simulator[Any]]":
    """Flights integrated by Exudyn."""
    from driftform_exudyn.simulator import ExudynSimulator

    return ExudynSimulator
