"""driftform plugin: added mass in potential flow by boundary elements on the meridian."""

from typing import TYPE_CHECKING, Any

from driftform import hookimpl

if TYPE_CHECKING:
    from driftform.interfaces import Hydrodynamics


@hookimpl
def driftform_hydrodynamics() -> "type[Hydrodynamics[Any]]":
    """Return the axisymmetric boundary-element method."""
    from driftform_panels.solve import PanelMethod

    return PanelMethod
