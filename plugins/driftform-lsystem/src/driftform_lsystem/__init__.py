"""driftform plugin: the L-system grammar of the paper."""

from driftform import hookimpl


@hookimpl
def driftform_grammar() -> type:
    """Return the L-system of the paper."""
    from driftform_lsystem.grammar import LSystemGrammar

    return LSystemGrammar
