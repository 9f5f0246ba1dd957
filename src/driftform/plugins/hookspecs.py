"""The hooks that a plugin may implement: one for each seam, and those for scenarios, commands and reports.

The hook of a seam, such as ``driftform_grammar``, takes no argument, and returns a class, or a list of classes, that implement
its interface in :data:`driftform.interfaces.SEAMS`. Import the implementation in the body of the hook: then a missing
dependency makes only this plugin unavailable, which ``driftform plugins`` reports. The functions here are the other hooks.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from driftform.interfaces import SEAMS

if TYPE_CHECKING:
    import typer

    from driftform.interfaces import ReportJob


def driftform_scenarios() -> str:  # type: ignore[empty-body]
    """Name of a package, such as ``"driftform_robotics.scenarios"``, whose TOML files become scenarios by their names."""


def driftform_commands(app: "typer.Typer") -> None:
    """Add commands to the command line, as in ``app.command("weigh")(weigh)``, or groups by ``app.add_typer``.

    Errors of :mod:`driftform.errors` become one line and an exit code. Import what a command works with in its body:
    this hook is called whenever the commands are listed.
    """


def driftform_report(job: "ReportJob") -> Mapping[str, str]:  # type: ignore[empty-body]
    """Return sections of the report of a run by their headings, each a fragment of HTML, such as a picture in SVG.

    A section must not need anything else: no network, no other file, no script. The same run must give the same text.
    Escape names, which come from files, with ``html.escape``.
    """


HOOKS = tuple(
    [f"driftform_{seam}" for seam in SEAMS]
    + [hook.__name__ for hook in (driftform_scenarios, driftform_commands, driftform_report)]
)
"""The names of all hooks."""
