"""Parts laid out on the bed of a printer: in rows, the deepest first, so that the same parts give the same plate.

Shelf packing: rows fill the bed from the front, and a part goes into the first row that has room for it (first fit,
decreasing). Parts that do not fit on one plate are put on further ones.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

GAP = 5.0
"""Room between two parts, mm: a skirt and a nozzle pass through it."""


@dataclass(frozen=True)
class Spot:
    """The place of a part: the number of its plate, and the middle of its rectangle, mm from the bed's middle."""

    plate: int
    x: float
    y: float


def arrange(sizes: Sequence[tuple[float, float]], bed: tuple[float, float]) -> tuple[Spot, ...]:
    """Return the places of rectangles on plates of the size of ``bed``, in the order of ``sizes``; all in mm.

    Rows, and the parts in them, are centred. A part that is larger than the bed has a plate to itself.
    """

    def span(parts: Iterable[int], side: int) -> float:
        return sum(sizes[part][side] + GAP for part in parts) - GAP

    plates: list[list[list[int]]] = []
    for part in sorted(range(len(sizes)), key=lambda i: (-sizes[i][1], -sizes[i][0], i)):
        width, depth = sizes[part]
        for rows in plates:
            if row := next((row for row in rows if span(row, 0) + GAP + width <= bed[0]), None):
                row.append(part)
                break
            # The first part of a row is the deepest.
            if span((row[0] for row in rows), 1) + GAP + depth <= bed[1] and width <= bed[0]:
                rows.append([part])
                break
        else:
            plates.append([[part]])
    spots: dict[int, Spot] = {}
    for number, rows in enumerate(plates):
        y = -span((row[0] for row in rows), 1) / 2
        for row in rows:
            x = -span(row, 0) / 2
            for part in row:
                spots[part] = Spot(number, x + sizes[part][0] / 2, y + sizes[row[0]][1] / 2)
                x += sizes[part][0] + GAP
            y += sizes[row[0]][1] + GAP
    return tuple(spots[part] for part in range(len(sizes)))
