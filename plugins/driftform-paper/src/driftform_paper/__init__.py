"""The paper's genetic algorithm and its experiment, repeated, with tables and figures made of our own flights."""

from typing import TYPE_CHECKING, Any

from driftform import hookimpl

if TYPE_CHECKING:
    import typer

    from driftform.interfaces import Strategy


@hookimpl
def driftform_strategy() -> "type[Strategy[Any]]":
    """Return the paper's genetic algorithm."""
    from driftform_paper.strategy import PaperStrategy

    return PaperStrategy


@hookimpl
def driftform_commands(app: "typer.Typer") -> None:
    """Add ``driftform reproduce``."""
    from driftform_paper.command import reproduce

    app.command("reproduce", rich_help_panel="Design")(reproduce)
