"""Values that cross the seams: each that a plugin returns is checked where it crosses.

What a seam does not allow becomes one line that names seam, plugin and method, says what came, and what was expected.
"""

import math
import re
import reprlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from driftform.errors import InputError, WorkFailedError, describe_error
from driftform.interfaces import Fitness, Grammar, Plugin, Result
from driftform.plugins.faults import name_plugin, report_faults
from driftform.types import (
    Body,
    Candidate,
    Coefficients,
    Core,
    End,
    Finding,
    FloatArray,
    Genome,
    Module,
    Morphology,
    State,
    Trajectory,
    Verdict,
    WrittenFile,
)

T = TypeVar("T")


def require(value: object, expected: type[T], plugin: Plugin[Any], method: str) -> T:
    """Return what a method of a plugin returned. Raises WorkFailedError if it is not of the expected type."""
    if not isinstance(value, expected):
        raise _refuse(plugin, method, _describe(value), f"a {expected.__name__}")
    return value


def require_flights(
    flights: object, count: int, plugin: Plugin[Any], method: str = "simulate_batch"
) -> list[Trajectory]:
    """Return the flights of a simulator, one for each agent.

    Raises WorkFailedError if one is missing, empty, without an end, or not finite although it did not fail.
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
        if not flight.end.failed:
            arrays = (t, flight.position, flight.quaternion, flight.velocity)
            if not all(np.isfinite(array).all() for array in arrays):
                raise _refuse(plugin, method, "a flight that is not finite", "an end that says so")
            squares = np.einsum("ij,ij->i", flight.quaternion, flight.quaternion)
            if squares.min() < 0.998 or squares.max() > 1.002:
                raise _refuse(plugin, method, "a flight with quaternions of another length", "length 1")
        for name in ("contact", "energy_drift", "error"):
            value = getattr(flight, name)
            if value is not None and not value >= 0:
                raise _refuse(plugin, method, f"a flight with {name} = {value}", "a number from 0, or None")
    return list(flights)


def require_candidates(
    candidates: object, most: int, plugin: Plugin[Any], grammar: str, targets: Sequence[str], first: int
) -> Sequence[Candidate]:
    """Return the candidates of a strategy, at least one and not more than are left of the budget.

    Args:
        candidates: what ``ask`` returned.
        most: what is left of the budget, evaluations.
        plugin: the strategy.
        grammar: name of the grammar of all genomes.
        targets: names of the targets.
        first: number of evaluations before these.

    Raises WorkFailedError if there are fewer or more, or other things among them, or one has another genome,
    target, parent or threshold than there is.
    """
    expected = f"1 to {most} candidates"
    if not isinstance(candidates, Sequence):
        raise _refuse(plugin, "ask", _describe(candidates), expected)
    if not 1 <= len(candidates) <= most:
        raise _refuse(plugin, "ask", f"{len(candidates)} candidates", expected)
    for candidate in candidates:
        genome = require(candidate, Candidate, plugin, "ask").genome
        if not isinstance(genome, Genome) or genome.grammar != grammar:
            what = f"a candidate whose genome is {_describe_genome(genome)}"
            raise _refuse(plugin, "ask", what, f"a Genome of grammar '{grammar}'")
        if candidate.target not in ("", *targets):
            what = f"a candidate for target {_show(candidate.target)}"
            raise _refuse(plugin, "ask", what, f"one of {', '.join(targets)}, or an empty text")
        if not all(0 <= parent < first for parent in candidate.parents) or not 0 <= candidate.generation < 2**63:
            what = f"a candidate of generation {candidate.generation} with parents {_show(candidate.parents)}"
            raise _refuse(plugin, "ask", what, f"evaluations before number {first}, and a generation from 0")
        threshold = candidate.threshold
        if threshold is not None and not _are_numbers(threshold, len(targets), -np.inf, np.inf):
            what = f"a candidate with threshold {_show(threshold)}"
            raise _refuse(plugin, "ask", what, f"None or {_count_numbers(len(targets))}")
    return candidates


def require_results(results: object, plugin: Plugin[Any]) -> Mapping[str, Result]:
    """Return what a strategy found. Raises WorkFailedError unless these are results by names that files can have."""
    if not isinstance(results, Mapping) or not all(re.fullmatch(r"[a-z0-9_-]{1,40}", str(name)) for name in results):
        raise _refuse(plugin, "collect_results", _show(results), "results by names of small letters, digits, - and _")
    return {str(name): require(result, Result, plugin, "collect_results") for name, result in results.items()}


def require_genome(genome: object, grammar: Grammar[Any], method: str) -> Genome:
    """Return a genome that a method of a grammar returned.

    Raises WorkFailedError if it is another thing, or names another grammar.
    """
    if not isinstance(genome, Genome) or genome.grammar != grammar.name:
        raise _refuse(grammar, method, _describe_genome(genome), f"a Genome of grammar '{grammar.name}'")
    return genome


def require_morphology(morphology: object, grammar: Grammar[Any]) -> Morphology:
    """Return what a grammar expressed.

    Raises WorkFailedError if it is another thing, or a module has a length or a tilt that no body has.
    """
    found = require(morphology, Morphology, grammar, "express")
    # Modules of a kind are often one object, which is checked once.
    for module in {id(module): module for module in (*found.fore, *found.aft)}.values():
        size = require(module, Module, grammar, "express")
        length, tilt = size.length, size.tilt
        are_numbers = type(length) is type(tilt) is float or _are_numbers([length, tilt], 2, -np.inf, np.inf)
        if not (are_numbers and 0 < length < math.inf and abs(tilt) < math.pi / 2):
            what = f"{_show(length)} m and {_show(tilt)} rad as length and tilt of a module"
            error = _refuse(grammar, "express", what, "a length above 0 and a tilt below a right angle")
            if are_numbers:
                error.violations = {"module": max(0.0, -length, abs(tilt) - math.pi / 2)}
            raise error
    return found


def require_body(body: object, builder: Plugin[Any]) -> Body:
    """Return what a builder built.

    Raises WorkFailedError if it is another thing, or its contours do not run from the axis to the axis.
    """
    found = require(body, Body, builder, "build")
    require(found.core, Core, builder, "build")
    for name, contour in (("outer", found.outer), ("cavity", found.cavity)):
        if name == "cavity" and not len(contour):
            continue
        x, r = contour.T
        if len(contour) < 3 or not (np.isfinite(contour).all() and x[0] < x[-1] and r.min() >= 0 == r[0] == r[-1]):
            raise _refuse(
                builder, "build", f"a body whose {name} contour is wrong", "finite points from axis to axis, aft first"
            )
    return found


def require_coefficients(coefficients: object, body: Body, model: Plugin[Any]) -> Coefficients:
    """Return the coefficients of a body by a hydrodynamics model.

    Raises WorkFailedError if they are something else, or not finite, or the added mass is not symmetric and
    positive semi-definite.
    """
    found = require(coefficients, Coefficients, model, "coefficients")
    for name in ("added_mass", "origin", "linear_damping", "quadratic_damping"):
        if not np.isfinite(getattr(found, name)).all():
            raise _refuse(model, "coefficients", f"{name} that is not finite", "numbers")
    if not _is_semidefinite(found.added_mass, body.length):
        what = "an added mass that is not symmetric and positive semi-definite"
        raise _refuse(model, "coefficients", what, "one that is")
    return found


def require_scores(scores: object, targets: int, fitness: Fitness[Any]) -> FloatArray:
    """Return what a fitness scored as fitness, %, (targets,).

    Raises WorkFailedError if it is not one real number within its bounds for each target.
    """
    low, high = sorted((fitness.worst, fitness.best))
    if not _are_numbers(scores, targets, low, high):
        what = _show(scores.tolist() if isinstance(scores, np.ndarray) else scores)
        expected = f"an array of {_count_numbers(targets)} from {low:g} to {high:g}, one for each target"
        raise _refuse(fitness, "score", "nothing" if scores is None else what, expected)
    return (np.asarray(scores, dtype=np.float64) - fitness.worst) * (100 / (fitness.best - fitness.worst))


def require_measures(found: object, fitness: Fitness[Any]) -> dict[str, float]:
    """Return what a fitness measured, by name.

    Raises WorkFailedError if these are not the measures that it declares, each within its bounds.
    """
    known = fitness.measures
    if not isinstance(found, Mapping) or set(found) != set(known):
        raise _refuse(fitness, "find_measures", _show(found), f"the measures {', '.join(known) or '(none)'}")
    for name, value in found.items():
        low, high = max(known[name].low, 0.0 if known[name].is_violation else -math.inf), known[name].high
        if not _are_numbers([value], 1, low, high):
            bounds = f"a number from {low:g} to {high:g} for '{name}'"
            raise _refuse(fitness, "find_measures", _show(value), bounds)
    return {name: float(value) for name, value in found.items()}


def require_files(files: object, plugin: Plugin[Any], method: str = "write") -> tuple[WrittenFile, ...]:
    """Return the files that a plugin says it wrote.

    Raises WorkFailedError if it says nothing of the kind, or one is not there.
    """
    if not isinstance(files, list | tuple) or not files:
        raise _refuse(plugin, method, _describe(files), "the files that it wrote")
    return tuple(require_file(file, plugin, method) for file in files)


def require_file(file: object, plugin: Plugin[Any], method: str) -> WrittenFile:
    """Return a file that a plugin says it wrote.

    Raises WorkFailedError if it says nothing of the kind, or the file is not there.
    """
    found = require(file, WrittenFile, plugin, method)
    if not isinstance(found.path, str) or not Path(found.path).exists():
        raise _refuse(plugin, method, f"a WrittenFile of {_show(found.path)}", "the path of what it wrote, as text")
    if not isinstance(found.facts, dict):
        raise _refuse(plugin, method, f"a WrittenFile with facts = {_show(found.facts)}", "a dict")
    return found


def require_findings(findings: object, checker: Plugin[Any]) -> Iterator[Finding]:
    """Yield the findings of a checker.

    Raises WorkFailedError if one is something else, or its state or a text of it is.
    """
    if not isinstance(findings, Iterable):
        raise _refuse(checker, "check", _describe(findings), "a list of Findings")
    for finding in findings:
        found = require(finding, Finding, checker, "check")
        if not isinstance(found.state, State):
            raise _refuse(checker, "check", f"a Finding with state = {_show(found.state)}", "a State")
        for name in ("check", "detail", "part"):
            if not isinstance(value := getattr(found, name), str):
                raise _refuse(checker, "check", f"a Finding with {name} = {_show(value)}", "text")
        yield found


def _is_semidefinite(matrix: FloatArray, length: float) -> bool:
    """Whether an added mass (6, 6) of a body of that length is symmetric and positive semi-definite, within rounding."""
    # In units in which masses and moments of inertia are alike.
    scale = np.array([1.0, 1.0, 1.0, *[1 / length] * 3])
    scaled = matrix * np.outer(scale, scale)
    rounding = 1e-6 * np.abs(scaled).max()
    return bool(np.abs(scaled - scaled.T).max() <= rounding and np.linalg.eigvalsh(scaled).min() >= -rounding)


def _are_numbers(values: object, count: int, least: float, most: float) -> bool:
    """Whether values are ``count`` real numbers in a row, none of them NaN, from ``least`` to ``most``."""
    try:
        array = np.asarray(values)
    except Exception:
        return False
    # Of a masked array the values under the mask would count.
    are_given = array.dtype.kind in "iuf" and array.shape == (count,) and not np.any(getattr(values, "mask", False))
    return are_given and bool(((array >= least) & (array <= most)).all())


def _count_numbers(count: int) -> str:
    return "1 number" if count == 1 else f"{count} numbers"


def _describe(value: object) -> str:
    if value is None or (isinstance(value, list | tuple) and not value):
        return "nothing"
    return f"a {type(value).__name__}"


def _describe_genome(genome: object) -> str:
    return f"a Genome of grammar '{genome.grammar}'" if isinstance(genome, Genome) else _describe(genome)


def _show(value: object) -> str:
    """Return a value in one short line, also if its own description fails."""
    return " ".join(reprlib.repr(value).split())


def _refuse(plugin: Plugin[Any], method: str, what: str, expected: str) -> WorkFailedError:
    return WorkFailedError(f"{name_plugin(plugin)} returned {what} from {method}(), expected {expected}")


def check_grammar(grammar: Grammar[Any]) -> None:
    """Check what a grammar returns by a few genomes, before a run is full of them.

    Raises WorkFailedError if a method does not return what :class:`driftform.interfaces.Grammar` says, or a genome
    is not read back from its text.
    """
    rng = np.random.default_rng(0)
    with report_faults():
        genome, other = (require_genome(grammar.random(rng), grammar, "random") for _ in range(2))
        text = require(grammar.to_text(genome), str, grammar, "to_text")
        try:
            found = require_genome(grammar.parse(text), grammar, "parse")
        except InputError as error:
            raise WorkFailedError(
                f"{name_plugin(grammar)} cannot read what to_text() returned: {describe_error(error)}"
            ) from None
        if found != genome:
            raise _refuse(grammar, "parse", "another genome", "that of which to_text() returned the text")
        if genome.symbols:
            require_genome(grammar.flip(genome, 0, rng), grammar, "flip")
        pair = grammar.crossover(genome, other, rng)
        if not isinstance(pair, list | tuple) or len(pair) != 2:
            raise _refuse(grammar, "crossover", _describe(pair), "two genomes")
        for child in pair:
            require_genome(child, grammar, "crossover")
        require_genome(grammar.mutate(genome, rng, 0.5), grammar, "mutate")
        require_morphology(grammar.express(genome), grammar)


def check_wording(fitness: Fitness[Any]) -> None:
    """Check the words of a fitness before a search, at the end of which they are needed.

    Raises WorkFailedError if a word is not text, or a method does not return what
    :class:`driftform.interfaces.Fitness` says.
    """
    for attribute in ("heading", "unit", "goal", "share"):
        if not isinstance(value := getattr(fitness, attribute), str):
            raise WorkFailedError(f"{name_plugin(fitness)} has {attribute} = {_show(value)}, expected text")
    bounds = f"worst = {_show(fitness.worst)} and best = {_show(fitness.best)}"
    if not _are_numbers([fitness.worst, fitness.best], 2, -1e300, 1e300) or fitness.worst == fitness.best:
        raise WorkFailedError(f"{name_plugin(fitness)} has {bounds}, expected two finite numbers that differ")
    with report_faults():
        for value in (0.0, 50.0, 99.0, 100.0):
            measured = fitness.measure(value)
            if not isinstance(measured, float | int) or not math.isfinite(measured):
                raise _refuse(fitness, "measure", f"{_show(measured)} of {value:g} %", "a finite number")
            require(fitness.judge(value), Verdict, fitness, "judge")
            require(fitness.describe(value), str, fitness, "describe")
