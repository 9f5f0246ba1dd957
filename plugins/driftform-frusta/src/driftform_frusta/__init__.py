"""Bodies of conical frustums, their solids and mesh files, as driftform plugins."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from driftform import hookimpl

if TYPE_CHECKING:
    import typer

    from driftform.interfaces import Exporter, Fitting, Grammar, Hydrodynamics, PhenotypeBuilder, ReportJob


@hookimpl
def driftform_builder() -> "list[type[PhenotypeBuilder[Any]]]":
    """A chain of conical frustums around the core, and a body by its profile."""
    from driftform_frusta.builder import FrustaBuilder
    from driftform_frusta.own.builder import ProfileBuilder

    return [FrustaBuilder, ProfileBuilder]


@hookimpl
def driftform_fitting() -> "type[Fitting[Any]]":
    """An eyelet."""
    from driftform_frusta.eyelet import Eyelet

    return Eyelet


@hookimpl
def driftform_grammar() -> "type[Grammar[Any]]":
    """The one genome of a body by its profile."""
    from driftform_frusta.own.builder import FixedGrammar

    return FixedGrammar


@hookimpl
def driftform_hydrodynamics() -> "type[Hydrodynamics[Any]]":
    """The coefficients of a body, as they were measured or computed elsewhere."""
    from driftform_frusta.own.coefficients import MatrixModel

    return MatrixModel


@hookimpl
def driftform_commands(app: "typer.Typer") -> None:
    """Add ``driftform body``."""
    from driftform_frusta.own.command import body

    app.command("body", rich_help_panel="Design")(body)


@hookimpl
def driftform_exporter() -> "list[type[Exporter[Any]]]":
    """Files for printers, viewers, modelling programs and OpenSCAD."""
    from driftform_frusta.exporters.meshes import GlbExporter, ObjExporter, PlyExporter, StlExporter
    from driftform_frusta.exporters.scad import ScadExporter
    from driftform_frusta.exporters.step import StepExporter
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


@hookimpl
def driftform_report(job: "ReportJob") -> Mapping[str, str]:
    """Return a table of what the hulls of a run withstand from outside; nothing if none is sealed."""
    from html import escape

    from driftform_frusta.strength import describe_strength

    hulls = {target: describe_strength(best.agent.body, job.scenario.fluid) for target, best in job.best.items()}
    rows = "".join(f"<li>{escape(target)}: {hull['summary']}</li>" for target, hull in hulls.items() if hull)
    return {"Hulls under pressure": f"<ul>{rows}</ul>"} if rows else {}
