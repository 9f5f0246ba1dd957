"""The paper's analytic added mass, as a driftform plugin."""

from typing import TYPE_CHECKING, Any

from driftform import hookimpl

if TYPE_CHECKING:
    from driftform.interfaces import Hydrodynamics


@hookimpl
def driftform_hydrodynamics() -> "type[Hydrodynamics[Any]]":
    """Equations 1 to 10."""
    from driftform_striptheory.coefficients import StripTheory

    return StripTheory
