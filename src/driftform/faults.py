"""Faults of plugins: errors that are not meant for users, and values that a seam does not allow.

A plugin may do anything: raise what it likes, end the program, or return nothing. Whatever it is becomes one line that
names seam, plugin and method.
"""

import math
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, TypeVar

import numpy as np

from driftform.errors import DriftformError, WorkFailedError, describe_error
from driftform.interfaces import SEAMS, Fitness, Plugin
from driftform.types import Candidate, End, FloatArray, Genome, Trajectory, Verdict, WrittenFile

T = TypeVar("T")


def name_plugin(plugin: Plugin[Any]) -> str:
    """Return seam and name of a plugin, such as ``simulator 'native'``."""
    seam = next((seam for seam, interface in SEAMS.items() if isinstance(plugin, interface)), "plugin")
    return f"{seam} '{getattr(plugin, 'name', type(plugin).__name__)}'"


def describe_fault(error: BaseException) -> str:
    """Describe an error in one line, with its place and the plugin that raised it unless it is meant for users."""
    if isinstance(error, DriftformError):
        return describe_error(error)
    return trace_fault(error) or describe_error(error, with_place=True)


def trace_fault(error: BaseException) -> str | None:
    """Describe an error that a plugin raised in one line, ``None`` if no plugin was at work; of nested ones the innermost."""
    found = None
    for frame, _ in traceback.walk_tb(error.__traceback__):
        acting = frame.f_locals.get("self")
        if isinstance(acting, Plugin):
            found = f"{name_plugin(acting)} failed in {frame.f_code.co_name}()"
    return found and f"{found}: {describe_error(error, with_place=True)}"


@contextmanager
def report_faults() -> Iterator[None]:
    """Turn an error of a plugin that is not meant for users into one that is; errors of other code pass.

    Raises
    ------
    WorkFailedError
        for any error of a plugin, also if the plugin ends the program by ``sys.exit``.
    """
    try:
        yield
    except (DriftformError, OSError):
        raise
    except (Exception, SystemExit) as error:
        fault = trace_fault(error)
        if fault is None:
            raise
        raise WorkFailedError(fault) from None


def require(value: object, expected: type[T], plugin: Plugin[Any], method: str) -> T:
    """Return what a method of a plugin returned.

    Raises
    ------
    WorkFailedError
        if it is not of the expected type.
    """
    if not isinstance(value, expected):
        raise _refuse(plugin, method, _describe(value), f"a {expected.__name__}")
    return value


def require_flights(
    flights: object, count: int, plugin: Plugin[Any], method: str = "simulate_batch"
) -> list[Trajectory]:
    """Return the flights of a simulator, one for each agent.

    Raises
    ------
    WorkFailedError
        if one is missing, empty, without an end, or not finite although it did not fail.
    """
    if not isinstance(flights, list | tuple) or len(flights) != count:
        what = f"{len(flights)} flights" if isinstance(flights, list | tuple) else _describe(flights)
        raise _refuse(plugin, method, what, f"a list of {count}")
    for flight in flights:
        t = require(flight, Trajectory, plugin, method).t
        if not isinstance(flight.end, End):
            raise _refuse(plugin, method, f"a flight that ended by {_describe(flight.end)}", "an End")
        if not len(t) or t[0] != 0 or not (np.diff(t) > 0).all():
            raise _refuse(plugin, method, "a flight without increasing times", "times from 0 s")
        if not flight.end.failed and not all(
            np.isfinite(array).all() for array in (t, flight.position, flight.quaternion, flight.velocity)
        ):
            raise _refuse(plugin, method, "a flight that is not finite", "an end that says so")
    return list(flights)


def require_candidates(
    candidates: object, most: int, targets: int, plugin: Plugin[Any]
) -> Sequence[Candidate]:
    """Return the candidates of a strategy, at least one and not more than are left of the budget.

    Raises
    ------
    WorkFailedError
        if there are fewer or more, other things among them, or one whose genome or threshold is no such thing.
    """
    expected = f"1 to {most} candidates"
    if not isinstance(candidates, Sequence):
        raise _refuse(plugin, "ask", _describe(candidates), expected)
    if not 1 <= len(candidates) <= most:
        raise _refuse(plugin, "ask", f"{len(candidates)} candidates", expected)
    for candidate in candidates:
        genome = require(candidate, Candidate, plugin, "ask").genome
        if not _is_genome(genome):
            raise WorkFailedError(
                f"{name_plugin(plugin)} asked for {genome!r:.80}, expected a Genome whose symbols are a tuple of texts; "
                "genomes come from random(), flip() and crossover() of the grammar"
            )
        threshold = candidate.threshold
        if threshold is not None and (np.shape(threshold) != (targets,) or np.isnan(threshold).any()):
            raise _refuse(
                plugin,
                "ask",
                f"a candidate with the threshold {threshold!r:.80}",
                f"one of {targets} numbers",
            )
    return candidates


def _is_genome(value: object) -> bool:
    return (
        isinstance(value, Genome)
        and isinstance(value.grammar, str)
        and isinstance(value.symbols, tuple)
        and all(isinstance(symbol, str) for symbol in value.symbols)
    )


def require_fitness(value: object, targets: int, plugin: Plugin[Any]) -> FloatArray:
    """Return the fitness that was scored, %, (targets,).

    Raises
    ------
    WorkFailedError
        if it is not one real number from 0 to 100 for each target.
    """
    expected = "an array of one number from 0 to 100" if targets == 1 else f"{targets} numbers from 0 to 100"
    try:
        scores = np.asarray(value)
    except ValueError:
        scores = np.array(None)
    if scores.dtype.kind not in "biuf":
        what = "complex numbers" if scores.dtype.kind == "c" else _describe(value)
        raise _refuse(plugin, "score", what, expected)
    if scores.shape != (targets,):
        what = f"an array of shape {scores.shape}" if scores.shape else f"the single number {scores}"
        raise _refuse(plugin, "score", what, expected)
    if not np.all((scores >= 0) & (scores <= 100)):
        raise _refuse(plugin, "score", str(scores.tolist()), expected)
    return scores.astype(np.float64)


def require_files(files: object, plugin: Plugin[Any], method: str = "write") -> tuple[WrittenFile, ...]:
    """Return the files that a plugin says it wrote.

    Raises
    ------
    WorkFailedError
        if it says nothing of the kind.
    """
    if not isinstance(files, list | tuple) or not files:
        raise _refuse(plugin, method, _describe(files), "the files that it wrote")
    return tuple(require(file, WrittenFile, plugin, method) for file in files)


def _describe(value: object) -> str:
    if value is None or (isinstance(value, list | tuple) and not value):
        return "nothing"
    return f"a {type(value).__name__}"


def _refuse(plugin: Plugin[Any], method: str, what: str, expected: str) -> WorkFailedError:
    return WorkFailedError(f"{name_plugin(plugin)} returned {what} from {method}(), expected {expected}")


def check_wording(fitness: Fitness[Any]) -> None:
    """Check the words of a fitness before a search, at the end of which they are needed.

    Raises
    ------
    WorkFailedError
        if a word is no text, or a method does not return what :class:`driftform.interfaces.Fitness` says.
    """
    for attribute in ("heading", "unit", "goal", "share"):
        if not isinstance(value := getattr(fitness, attribute), str):
            raise WorkFailedError(f"{name_plugin(fitness)} has {attribute} = {value!r}, expected text")
    with report_faults():
        for value in (0.0, 50.0, 99.0, 100.0):
            measured = fitness.measure(value)
            if not isinstance(measured, float | int) or not math.isfinite(measured):
                raise _refuse(fitness, "measure", f"{measured!r} of {value:g} %", "a finite number")
            require(fitness.judge(value), Verdict, fitness, "judge")
            require(fitness.describe(value), str, fitness, "describe")
