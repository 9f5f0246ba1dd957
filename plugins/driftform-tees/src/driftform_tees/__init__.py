"""driftform plugin: solves the ideal flow in tees and wyes of any shape, and writes the current in a pipe as a file."""

from typing import TYPE_CHECKING

from driftform import hookimpl

if TYPE_CHECKING:
    import typer


@hookimpl
def driftform_commands(app: "typer.Typer") -> None:
    """Add ``driftform export-flow``."""
    from driftform_tees.export_flow_command import export_flow

    app.command("export-flow")(export_flow)
