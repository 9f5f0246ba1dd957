"""Genotype -> instructions -> morphology: the rewriting of an L-system, and what its quintuples build along the axis."""

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Literal

from driftform.interfaces import Table, option
from driftform.types import Module, Morphology
from driftform_lsystem.alphabet import CORE, LETTER_PLACE, LETTERS, QUINTUPLE, QUINTUPLES_PER_RULE, RULES

Step = tuple[str, ...]
"""A quintuple: add, tilt, degree, letter and move."""

MAX_TILT_DEG = 80.0
"""Largest tilt of a wall against the axis, deg: near 90 the meridian would fold back on itself."""


class LSystemOptions(Table):
    """The table ``[grammar]`` of a study that uses ``lsystem``: readings of the paper where it is silent, too."""

    # The number of modules triples with each iteration; six already make 1092.
    iterations: int = option(3, "number of times that the rules are applied to the axiom", ge=1, le=6)
    small: float = option(0.0025, "length along the slant of a module S", "m", ge=1e-4, le=0.5)
    medium: float = option(0.005, "length along the slant of a module M", "m", ge=1e-4, le=0.5)
    large: float = option(0.01, "length along the slant of a module L", "m", ge=1e-4, le=0.5)
    tilt_0_deg: float = option(0.0, "tilt of degree 0", "deg", ge=0, le=MAX_TILT_DEG)
    tilt_1_deg: float = option(10.0, "tilt of degree 1", "deg", ge=0, le=MAX_TILT_DEG)
    tilt_2_deg: float = option(20.0, "tilt of degree 2", "deg", ge=0, le=MAX_TILT_DEG)
    repetition: Literal["first", "last"] = option(
        "first", "which symbol counts in a run of adds, tilts, degrees or moves between two modules"
    )
    occupied: Literal["insert", "skip"] = option(
        "insert", "adding a module at an occupied place: insert it between, or skip it"
    )
    tilt_reference: Literal["axis", "neighbour"] = option(
        "axis", "reference of a tilt: the axis, or the wall of the next module towards the core"
    )


def split(symbols: tuple[str, ...]) -> list[Step]:
    """Return symbols without the core's letter as quintuples."""
    width = len(QUINTUPLE)
    return [symbols[k : k + width] for k in range(0, len(symbols), width)]


def grow(genotype: tuple[str, ...], iterations: int, *, last: bool = False) -> list[Step]:
    """Return one quintuple for each module of the word that the axiom C grows into.

    The core's rule keeps its letter, C -> C q q q, and so adds three modules in each iteration. The letters
    S, M, L are consumed, S -> q q q: the symbols around a letter, its "add tilt degree" and its move, remain
    around its children. n modules become 3 n + 3. Of the symbols in a row that this leaves before the first child and
    after the last one, the first counts, or the ``last``.
    """
    quintuples = split(genotype)
    rules = {rule: quintuples[i * QUINTUPLES_PER_RULE : (i + 1) * QUINTUPLES_PER_RULE] for i, rule in enumerate(RULES)}
    # What the letters have grown into so far. An iteration puts what the core's rule has grown into after what is there.
    grown, word = rules, list(rules[CORE])
    for iteration in range(1, iterations):
        if iteration > 1:
            grown = {letter: _replace_letters(rules[letter], grown, last) for letter in LETTERS}
        word += _replace_letters(rules[CORE], grown, last)
    return word


def _replace_letters(rule: Sequence[Step], grown: dict[str, list[Step]], last: bool) -> list[Step]:
    """Return the steps of a rule with each letter replaced by what it has grown into."""
    steps: list[Step] = []
    for step in rule:
        first = len(steps)
        steps += grown[step[LETTER_PLACE]]
        if last:
            steps[-1] = steps[-1][: LETTER_PLACE + 1] + step[LETTER_PLACE + 1 :]
        else:
            steps[first] = step[:LETTER_PLACE] + steps[first][LETTER_PLACE:]
    return steps


def interpret(steps: Sequence[Sequence[str]], options: LSystemOptions) -> Morphology:
    """Return the modules that quintuples build: lengths in m, tilts in rad."""
    modules = _make_catalogue(options)
    aft, fore = (
        tuple([modules[kind] for kind in side]) for side in place_modules(steps, skip=options.occupied == "skip")
    )
    if options.tilt_reference == "neighbour":
        aft, fore = _lean(aft), _lean(fore)
    return Morphology(fore, aft)


def place_modules(steps: Sequence[Sequence[str]], *, skip: bool = False) -> tuple[list[str], list[str]]:
    """Place the modules; return those aft and those fore of the core, each from the core outward.

    A module is named by its tilt, degree and letter in one string, such as ``"tiltn1M"``. If another
    module, or the core, is already next to the reference, the new module is inserted between, or left out with
    ``skip``; its move counts in both cases.
    """
    places = [CORE]
    reference = 0
    for add, tilt, degree, letter, move in steps:
        at = reference + (add == "addF")
        # Only the places beyond the two ends of the chain are free.
        if not skip or at in (0, len(places)):
            places.insert(at, f"{tilt}{degree}{letter}")
            if at == reference:
                reference += 1
        if move == "moveF":
            if reference < len(places) - 1:
                reference += 1
        elif move == "moveB" and reference > 0:
            reference -= 1
    core = places.index(CORE)
    return places[:core][::-1], places[core + 1 :]


def _lean(side: Sequence[Module]) -> tuple[Module, ...]:
    """Return the modules on a side with each tilt taken from the wall of the next module towards the core."""
    limit = math.radians(MAX_TILT_DEG)
    leaning = []
    wall = 0.0
    for module in side:
        # Each step is clipped, and not the sum: the tilt of the next module refers to the clipped wall.
        wall = min(max(wall + module.tilt, -limit), limit)
        leaning.append(Module(module.length, wall))
    return tuple(leaning)


@lru_cache(maxsize=16)
def _make_catalogue(options: LSystemOptions) -> dict[str, Module]:
    """Return the modules by their names in :func:`place_modules`, with their tilt against the axis."""
    lengths = {"S": options.small, "M": options.medium, "L": options.large}
    degrees = {"0": options.tilt_0_deg, "1": options.tilt_1_deg, "2": options.tilt_2_deg}
    # Subtracted from zero, because the negative of 0.0 is -0.0 and would be printed as such.
    tilts = {"tiltp" + d: math.radians(deg) for d, deg in degrees.items()}
    tilts |= {"tiltn" + d: 0.0 - math.radians(deg) for d, deg in degrees.items()}
    return {tilt + letter: Module(length, angle) for tilt, angle in tilts.items() for letter, length in lengths.items()}
