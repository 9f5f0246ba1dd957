"""driftform plugin: a grammar of real numbers."""

from typing import TYPE_CHECKING, Any

from driftform import hookimpl

if TYPE_CHECKING:
    from driftform.interfaces import Grammar


@hookimpl
def driftform_grammar() -> "type[Grammar[Any]]":
    """Return the grammar of B-splines."""
    from driftform_bspline.grammar import BSplineGrammar

    return BSplineGrammar
