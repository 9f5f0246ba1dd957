"""driftform plugin: the analytic added mass of the paper."""

from typing import TYPE_CHECKING, Any

from driftform import hookimpl

if TYPE_CHECKING:
    from driftform.interfaces import Hydrodynamics


@hookimpl
def driftform_hydrodynamics() -> "type[Hydrodynamics[Any]]":
    """Return the strip theory of the paper, equations 1 to 10."""
    from driftform_striptheory.coefficients import StripTheory

    return StripTheory
