"""Options of the grammar: readings of the paper where it is silent or contradicts itself."""

from typing import Literal

from driftform.interfaces import Table, option

MAX_TILT_DEG = 80.0
"""Largest tilt of a wall against the axis, deg: near 90 the meridian would fold back on itself."""


class LSystemOptions(Table):
    """The table ``[grammar]`` of a study that uses ``lsystem``."""

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
