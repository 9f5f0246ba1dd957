"""driftform plugin: the L-system grammar of the paper."""

from typing import TYPE_CHECKING, Any

from driftform import hookimpl

if TYPE_CHECKING:
    from driftform.interfaces import Grammar


@hookimpl
def driftform_grammar() -> "type[Grammar[Any]]":
    """Return the L-system of the paper."""
    from driftform_lsystem.grammar import LSystemGrammar

    return LSystemGrammar
