"""The hooks that a plugin may implement: one for each seam, and those for scenarios, commands and reports.

The hook of a seam returns a class, or a list of classes, that implement its interface in :mod:`driftform.interfaces`. Import
the implementation in the body of the hook: then a missing dependency makes only this plugin unavailable, which
``driftform plugins`` reports.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

import pluggy

if TYPE_CHECKING:
    import typer

    from driftform.interfaces import (
        Checker,
        Exporter,
        Fitness,
        Grammar,
        Hydrodynamics,
        PhenotypeBuilder,
        Recorder,
        Renderer,
        ReportJob,
        Simulator,
        Strategy,
    )

T = TypeVar("T")
OneOrMore = type[T] | Sequence[type[T]]
"""The return type of a hook."""

hookspec = pluggy.HookspecMarker("driftform")
"""Marks a function of this module as the specification of a hook."""


@hookspec
def driftform_grammar() -> "OneOrMore[Grammar[Any]]":  # type: ignore[empty-body]
    """Genome -> morphology, and the operators that create, mutate and cross genomes."""


@hookspec
def driftform_builder() -> "OneOrMore[PhenotypeBuilder[Any]]":  # type: ignore[empty-body]
    """Morphology -> body."""


@hookspec
def driftform_hydrodynamics() -> "OneOrMore[Hydrodynamics[Any]]":  # type: ignore[empty-body]
    """Body -> coefficients."""


@hookspec
def driftform_simulator() -> "OneOrMore[Simulator[Any]]":  # type: ignore[empty-body]
    """Agent in a scenario -> trajectory."""


@hookspec
def driftform_fitness() -> "OneOrMore[Fitness[Any]]":  # type: ignore[empty-body]
    """Trajectory -> one fitness for each target."""


@hookspec
def driftform_strategy() -> "OneOrMore[Strategy[Any]]":  # type: ignore[empty-body]
    """Search strategy: decides which genomes to evaluate next (ask and tell)."""


@hookspec
def driftform_exporter() -> "OneOrMore[Exporter[Any]]":  # type: ignore[empty-body]
    """Agent -> files for a printer, a slicer or another program."""


@hookspec
def driftform_recorder() -> "OneOrMore[Recorder[Any]]":  # type: ignore[empty-body]
    """Agent and trajectory -> files of samples for other programs."""


@hookspec
def driftform_renderer() -> "OneOrMore[Renderer[Any]]":  # type: ignore[empty-body]
    """Agent and trajectory -> a film or a still."""


@hookspec
def driftform_checker() -> "OneOrMore[Checker[Any]]":  # type: ignore[empty-body]
    """Printable files -> findings: whether they can be printed, and match the simulated agent."""


@hookspec
def driftform_scenarios() -> str:  # type: ignore[empty-body]
    """Name of a package, such as ``"driftform_robotics.scenarios"``, whose TOML files become scenarios by their names."""


@hookspec
def driftform_commands(app: "typer.Typer") -> None:
    """Add commands to the command line, as in ``app.command("weigh")(weigh)``, or groups by ``app.add_typer``.

    Errors of :mod:`driftform.errors` become one line and an exit code. Import what a command works with in its body:
    this hook is called whenever the commands are listed.
    """


@hookspec
def driftform_report(job: "ReportJob") -> Mapping[str, str]:  # type: ignore[empty-body]
    """Return sections of the report of a run by their headings, each a fragment of HTML, such as a picture in SVG.

    A section must not need anything else: no network, no other file, no script. The same run must give the same text.
    Escape names, which come from files, with ``html.escape``.
    """
