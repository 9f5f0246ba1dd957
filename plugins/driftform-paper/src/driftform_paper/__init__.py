"""The paper's experiment, repeated, and its tables and figures made of our own flights."""

from typing import TYPE_CHECKING

from driftform import hookimpl

if TYPE_CHECKING:
    import typer


@hookimpl
def driftform_commands(app: "typer.Typer") -> None:
    """Add ``driftform reproduce``."""
    from driftform_paper.command import reproduce

    app.command("reproduce")(reproduce)
