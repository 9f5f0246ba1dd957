"""The parts of a pipe as a study file gives them: ``[[pipe.parts]]``, from the inlet on."""

from typing import Annotated, Any, Literal, TypeAlias

from pydantic import AfterValidator, Field, Tag

from driftform.util.options import Table, list_kinds, option, read_kind


def _check_name(name: str) -> str:
    if name and not name.replace("-", "").replace("_", "").replace(" ", "").isalnum():
        raise ValueError(f"'{name}' must consist of letters, digits, '-', '_' and spaces")
    return name


def _declare_roll(what: str) -> Any:
    clock = "as on a clock seen downstream: 0 up, 90 right, 180 down, 270 left"
    return option(0.0, f"direction of the {what}, {clock}", "deg", ge=-360, le=360)


Name: TypeAlias = Annotated[str, Field(max_length=40), AfterValidator(_check_name)]


class _Part(Table):
    """What all parts have in common."""

    name: Name = option("", "name of the part; by default its kind and a number, such as 'bend 2'")
    outlet: Name = option("", "name of the outlet at the end of the run, if nothing follows")


class StraightPart(_Part):
    """A straight piece of pipe."""

    kind: Literal["straight"] = option("straight", "kind of the part")
    length: float = option(..., "length", "m", ge=1e-4, le=1e5, strict=True)


class BendPart(_Part):
    """A bend: a part of a torus."""

    kind: Literal["bend"] = option("bend", "kind of the part")
    angle_deg: float = option(90.0, "angle by which the pipe turns", "deg", ge=0.1, le=180)
    radius: float = option(
        ..., "radius of the bend, from its centre to the pipe's axis", "m", ge=1e-3, le=1e4, strict=True
    )
    roll_deg: float = _declare_roll("turn")


class ReducerPart(_Part):
    """A smooth change of the bore, narrower or wider: an ogee."""

    kind: Literal["reducer"] = option("reducer", "kind of the part")
    length: float = option(..., "length", "m", ge=1e-4, le=1e3, strict=True)
    radius: float = option(..., "radius of the bore at the end", "m", ge=1e-3, le=100, strict=True)


class _Junction(_Part):
    """What tees and wyes have in common."""

    branch_radius: float = option(..., "radius of the bore of the branch", "m", ge=1e-3, le=100, strict=True)
    roll_deg: float = _declare_roll("branch")
    share: float = option(..., "share of the water that leaves by the branch", ge=0, le=1, strict=True)
    fillet: float | None = option(
        None,
        "radius of the rounded edge where the bores meet; by default a fifth of the branch's radius",
        "m",
        ge=1e-6,
        le=100,
        strict=True,
    )
    branch: "tuple[PartTable, ...]" = option((), "parts of the branch, from the junction on", min_length=1)


class TeePart(_Junction):
    """A junction whose branch leaves at a right angle."""

    kind: Literal["tee"] = option("tee", "kind of the part")


class WyePart(_Junction):
    """A junction whose branch leaves at another angle."""

    kind: Literal["wye"] = option("wye", "kind of the part")
    angle_deg: float = option(60.0, "angle between the run's downstream axis and the branch", "deg", ge=30, le=150)


PartTable: TypeAlias = Annotated[
    Annotated[StraightPart, Tag("straight")]
    | Annotated[BendPart, Tag("bend")]
    | Annotated[ReducerPart, Tag("reducer")]
    | Annotated[TeePart, Tag("tee")]
    | Annotated[WyePart, Tag("wye")],
    read_kind("straight"),
]
"""One part of a pipe: one of :data:`PARTS`, by its ``kind``; a straight without it."""

PARTS = list_kinds(PartTable)
"""The kinds of parts by name."""

TeePart.model_rebuild()
WyePart.model_rebuild()
