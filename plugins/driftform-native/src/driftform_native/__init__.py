"""driftform plugin: flights by the compiled integrator of driftform."""

from typing import TYPE_CHECKING, Any

from driftform import hookimpl

if TYPE_CHECKING:
    from driftform.interfaces import Simulator


@hookimpl
def driftform_simulator() -> "type[Simulator[Any]]":
    """Return the simulator with an adaptive high-order integrator in compiled code."""
    from driftform_native.simulator import NativeSimulator

    return NativeSimulator
