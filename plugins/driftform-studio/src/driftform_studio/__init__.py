"""A local page to design a pipe, search, and take the files: ``driftform studio``.

The page holds no physics and no state: a design in the making lives in its tab, and everything else is a run directory,
which the command line opens too.
"""

from typing import TYPE_CHECKING

from driftform import hookimpl

if TYPE_CHECKING:
    import typer


@hookimpl
def driftform_commands(app: "typer.Typer") -> None:
    """Add ``driftform studio``."""
    from driftform_studio.command import studio

    app.command("studio", rich_help_panel="Design")(studio)
