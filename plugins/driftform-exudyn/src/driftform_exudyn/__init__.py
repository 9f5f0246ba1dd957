"""driftform plugin: flights integrated by Exudyn, and films of them."""

from typing import TYPE_CHECKING, Any

from driftform import hookimpl

if TYPE_CHECKING:
    from driftform.interfaces import Renderer, Simulator


@hookimpl
def driftform_simulator() -> "type[Simulator[Any]]":
    """Return the simulator. Check here that Exudyn is installed; import it only to simulate."""
    from driftform.util import foreign
    from driftform_exudyn.simulator import ExudynSimulator

    foreign.require_module("exudyn")
    return ExudynSimulator


@hookimpl
def driftform_renderer() -> "type[Renderer[Any]]":
    """Return the renderer of films and stills by Exudyn's ray tracer."""
    from driftform.util import foreign
    from driftform_exudyn.film import ExudynRenderer

    foreign.require_module("exudyn")
    return ExudynRenderer
