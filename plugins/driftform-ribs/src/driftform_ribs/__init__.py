"""driftform plugin: quality diversity by pyribs."""

from driftform import hookimpl


@hookimpl
def driftform_strategy() -> type:
    """Return MAP-Elites with an archive of pyribs. Check here that it is installed; import it only to search."""
    from driftform.util import foreign
    from driftform_ribs.strategy import RibsStrategy

    foreign.require_module("ribs")
    return RibsStrategy
