"""driftform plugin: a grammar of real numbers."""

from driftform import hookimpl


@hookimpl
def driftform_grammar() -> type:
    """Return the grammar of B-splines."""
    from driftform_bspline.grammar import BSplineGrammar

    return BSplineGrammar
