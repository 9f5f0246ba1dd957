"""Archives of quality diversity by pyribs, as a driftform plugin."""

from typing import TYPE_CHECKING, Any

from driftform import hookimpl

if TYPE_CHECKING:
    from driftform.interfaces import Strategy


@hookimpl
def driftform_strategy() -> "type[Strategy[Any]]":
    """MAP-Elites with an archive of pyribs, which is looked for here and imported where a search begins."""
    from driftform.registry import require_module
    from driftform_ribs.strategy import RibsStrategy

    require_module("ribs")
    return RibsStrategy
