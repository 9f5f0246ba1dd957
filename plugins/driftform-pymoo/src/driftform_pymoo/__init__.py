"""driftform plugin: the optimisers of pymoo."""

from driftform import hookimpl


@hookimpl
def driftform_strategy() -> type:
    """Return the optimisers of pymoo. Check here that it is installed; import it only to search."""
    from driftform.util import foreign
    from driftform_pymoo.strategy import PymooStrategy

    foreign.require_module("pymoo")
    return PymooStrategy
