"""Parts laid out on the bed of a printer: in rows, the deepest first, so that the same parts give the same plate.

Shelf packing: rows fill the bed from the front, and a part goes into the first row that has room for it (first fit,
decreasing). Parts that do not fit on one plate are put on further ones.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

GAP = 5.0
"""Room between two parts, mm: a skirt and a nozzle pass through it."""


@dataclass(frozen=True)
class Spot:
    """The place of a part: the number of its plate, and the middle of its rectangle, mm from the bed's middle."""

    plate: int
    x: float
    y: float


@dataclass
class _Row:
    depth: float
    width: float = 0.0
    parts: list[int] = field(default_factory=list)


@dataclass
class _Plate:
    depth: float = 0.0
    rows: list[_Row] = field(default_factory=list)


def arrange(sizes: Sequence[tuple[float, float]], bed: tuple[float, float]) -> tuple[Spot, ...]:
    """Return the places of rectangles on plates of the size of ``bed``, in the order of ``sizes``; all in mm.

    Rows, and the parts in them, are centred. A part that is larger than the bed has a plate to itself.
    """
    plates: list[_Plate] = []
    for part in sorted(range(len(sizes)), key=lambda i: (-sizes[i][1], -sizes[i][0], i)):
        _place(part, sizes[part], plates, bed)
    spots: dict[int, Spot] = {}
    for number, plate in enumerate(plates):
        y = -plate.depth / 2
        for row in plate.rows:
            x = -row.width / 2
            for part in row.parts:
                spots[part] = Spot(number, x + sizes[part][0] / 2, y + row.depth / 2)
                x += sizes[part][0] + GAP
            y += row.depth + GAP
    return tuple(spots[part] for part in range(len(sizes)))


def fits(size: tuple[float, float, float], bed: tuple[float, float, float]) -> bool:
    """Return whether a part, without turning it, fits the printer; both in mm."""
    return all(s <= b + 1e-6 for s, b in zip(size, bed, strict=True))


def _place(part: int, size: tuple[float, float], plates: list[_Plate], bed: tuple[float, float]) -> None:
    width, depth = size
    for plate in plates:
        for row in plate.rows:
            if depth <= row.depth and row.width + GAP + width <= bed[0]:
                row.width += GAP + width
                row.parts.append(part)
                return
        if plate.depth + GAP + depth <= bed[1] and width <= bed[0]:
            plate.depth += GAP + depth
            plate.rows.append(_Row(depth, width, [part]))
            return
    plates.append(_Plate(depth, [_Row(depth, width, [part])]))
