"""Added mass in potential flow by boundary elements on the meridian, as a driftform plugin."""

from typing import TYPE_CHECKING, Any

from driftform import hookimpl

if TYPE_CHECKING:
    from driftform.interfaces import Hydrodynamics


@hookimpl
def driftform_hydrodynamics() -> "type[Hydrodynamics[Any]]":
    """Axisymmetric boundary elements."""
    from driftform_panels.coefficients import PanelMethod

    return PanelMethod
