"""driftform plugin: quality diversity by pyribs."""

from typing import TYPE_CHECKING, Any

from driftform import hookimpl

if TYPE_CHECKING:
    from driftform.interfaces import Strategy


@hookimpl
def driftform_strategy() -> "type[Strategy[Any]]":
    """Return MAP-Elites with an archive of pyribs. Check here that it is installed; import it only to search."""
    from driftform.util import foreign
    from driftform_ribs.strategy import RibsStrategy

    foreign.require_module("ribs")
    return RibsStrategy
