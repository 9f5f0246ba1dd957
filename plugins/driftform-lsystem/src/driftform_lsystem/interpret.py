"""Quintuples -> morphology: they are building instructions along the axis."""

import math
from collections.abc import Sequence
from functools import lru_cache

from driftform.types import Module, Morphology
from driftform_lsystem.alphabet import CORE
from driftform_lsystem.options import MAX_TILT_DEG, LSystemOptions


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
