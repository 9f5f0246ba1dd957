"""Bodies of conical frustums, their solids and mesh files, as driftform plugins."""

from typing import TYPE_CHECKING, Any

from driftform import hookimpl

if TYPE_CHECKING:
    from driftform.interfaces import Exporter, PhenotypeBuilder


@hookimpl
def driftform_builder() -> "type[PhenotypeBuilder[Any]]":
    """A chain of conical frustums around the core."""
    from driftform_frusta.builder import FrustaBuilder

    return FrustaBuilder


@hookimpl
def driftform_exporter() -> "list[type[Exporter[Any]]]":
    """Mesh for printers, source for OpenSCAD."""
    from driftform_frusta.exporters import ScadExporter, StlExporter

    return [StlExporter, ScadExporter]
