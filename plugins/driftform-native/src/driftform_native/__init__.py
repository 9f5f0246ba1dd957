"""Flights by driftform's own compiled integrator, as a driftform plugin."""

from typing import TYPE_CHECKING, Any

from driftform import hookimpl

if TYPE_CHECKING:
    from driftform.interfaces import Simulator


@hookimpl
def driftform_simulator() -> "type[Simulator[Any]]":
    """Flights by an adaptive high-order integrator in compiled code."""
    from driftform_native.simulator import NativeSimulator

    return NativeSimulator
