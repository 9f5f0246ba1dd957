"""The paper's L-system grammar, as a driftform plugin."""

from typing import TYPE_CHECKING, Any

from driftform import hookimpl

if TYPE_CHECKING:
    from driftform.interfaces import Grammar


@hookimpl
def driftform_grammar() -> "type[Grammar[Any]]":
    """The paper's L-system."""
    from driftform_lsystem.grammar import LSystemGrammar

    return LSystemGrammar
