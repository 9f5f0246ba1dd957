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
    """Files for printers, viewers, modelling programs and OpenSCAD."""
    from driftform_frusta.exporters.glb import GlbExporter
    from driftform_frusta.exporters.obj import ObjExporter
    from driftform_frusta.exporters.ply import PlyExporter
    from driftform_frusta.exporters.scad import ScadExporter
    from driftform_frusta.exporters.step import StepExporter
    from driftform_frusta.exporters.stl import StlExporter
    from driftform_frusta.exporters.svg import SvgExporter
    from driftform_frusta.exporters.threemf import ThreeMfExporter

    return [
        GlbExporter,
        ObjExporter,
        PlyExporter,
        ScadExporter,
        StepExporter,
        StlExporter,
        SvgExporter,
        ThreeMfExporter,
    ]
