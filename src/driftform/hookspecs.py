"""The hooks, one for each seam: the table of contents of what a plugin may bring.

Each returns a class, or a list of classes, of its interface in :mod:`driftform.interfaces`. The hook body is
where the implementation is imported, so that a missing dependency makes one row "unavailable" and no crash.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TypeVar

import pluggy

if TYPE_CHECKING:
    from driftform.interfaces import (
        Checker,
        Exporter,
        Fitness,
        Grammar,
        Hydrodynamics,
        PhenotypeBuilder,
        Recorder,
        Renderer,
        Simulator,
        Strategy,
    )

T = TypeVar("T")
OneOrMore = type[T] | Sequence[type[T]]
"""What a hook returns."""

hookspec = pluggy.HookspecMarker("driftform")
"""Marks a function of this module as the specification of a hook."""


@hookspec
def driftform_grammar() -> "OneOrMore[Grammar[Any]]":  # type: ignore[empty-body]
    """Genome -> morphology, and how genomes are made, mutated and crossed."""


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
    """Which genomes to evaluate next: ask and tell."""


@hookspec
def driftform_exporter() -> "OneOrMore[Exporter[Any]]":  # type: ignore[empty-body]
    """Agent -> a file for a printer, a slicer or another program."""


@hookspec
def driftform_recorder() -> "OneOrMore[Recorder[Any]]":  # type: ignore[empty-body]
    """Agent and its flight -> files of samples for other programs."""


@hookspec
def driftform_renderer() -> "OneOrMore[Renderer[Any]]":  # type: ignore[empty-body]
    """Agent and its flight -> a film, or a still."""


@hookspec
def driftform_checker() -> "OneOrMore[Checker[Any]]":  # type: ignore[empty-body]
    """Printable files -> whether they can be printed, and are what was simulated."""
