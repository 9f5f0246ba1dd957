"""From a simulated agent to a printed one that flies like it: kits, ballast, trim and checks, as driftform plugins."""

from typing import TYPE_CHECKING, Any

from driftform import hookimpl

if TYPE_CHECKING:
    import typer

    from driftform.interfaces import Checker


@hookimpl
def driftform_checker() -> "list[type[Checker[Any]]]":
    """Checks of the meshes, by their triangles and by OpenSCAD, PrusaSlicer and admesh."""
    from driftform_kit.checks.admesh import AdmeshChecker
    from driftform_kit.checks.mesh import MeshChecker
    from driftform_kit.checks.openscad import OpenScadChecker
    from driftform_kit.checks.prusaslicer import PrusaSlicerChecker

    return [MeshChecker, OpenScadChecker, PrusaSlicerChecker, AdmeshChecker]


@hookimpl
def driftform_commands(app: "typer.Typer") -> None:
    """Add ``driftform check`` and ``driftform trim``."""
    from driftform_kit.check_command import check
    from driftform_kit.trim_command import trim

    app.command("check", rich_help_panel="Workshop")(check)
    app.command("trim", rich_help_panel="Workshop")(trim)
