"""Letters of straight strokes, for texts on parts: the same on every machine, whatever its fonts.

Each letter is drawn on a grid of 4 by 6 units; small letters are drawn as capitals.
"""

from itertools import pairwise
from typing import TypeAlias

Stroke: TypeAlias = tuple[tuple[float, float], tuple[float, float]]
"""Both ends of the middle line of a stroke."""

STROKE = 0.8 / 6
"""Width of a stroke over the height of a capital."""

_HEIGHT, _WIDTH, _ADVANCE = 6.0, 4.0, 5.5

# Each line of a letter is a row of points, two digits each, x and y in units.
_LETTERS = {
    " ": "",
    "0": "100105163645413010 1234",
    "1": "152620 1030",
    "2": "05163645440040",
    "3": "0516364544334241301001 2333",
    "4": "30360242",
    "5": "460603334241301001",
    "6": "4536160501103041423303",
    "7": "064610",
    "8": "13040516364544331302011030414233",
    "9": "4313040516364541301001",
    "A": "002640 1232",
    "B": "00063645443342413000 0333",
    "C": "4536160501103041",
    "D": "00062644422000",
    "E": "46060040 0333",
    "F": "460600 0333",
    "G": "45361605011030414323",
    "H": "0006 4046 0343",
    "I": "2026 1030 1636",
    "J": "4641301001",
    "K": "0006 0246 1340",
    "L": "060040",
    "M": "0006234640",
    "N": "00064046",
    "O": "100105163645413010",
    "P": "00063645443303",
    "Q": "100105163645413010 2240",
    "R": "00063645443303 2340",
    "S": "453616050413334241301001",
    "T": "0646 2026",
    "U": "060110304146",
    "V": "062046",
    "W": "0610233046",
    "X": "0046 0640",
    "Y": "062346 2320",
    "Z": "06460040",
    "-": "1333",
    ".": "2020",
    "_": "0040",
    "/": "0046",
    ":": "2121 2424",
    "+": "0343 2125",
    "#": "1016 3036 0242 0444",
}


def missing_letters(text: str) -> str:
    """Return those letters of a text that cannot be drawn."""
    return "".join(sorted({letter for letter in text if letter.upper() not in _LETTERS}))


def draw_strokes(text: str, size: float) -> tuple[Stroke, ...]:
    """Return the strokes of a text whose capitals are ``size`` high; it begins at the origin and runs along x.

    Every letter is one that :func:`missing_letters` does not return.
    """
    unit = size / _HEIGHT
    found: list[Stroke] = []
    for place, letter in enumerate(text):
        for line in _LETTERS[letter.upper()].split():
            points = [
                (unit * (place * _ADVANCE + int(line[i])), unit * int(line[i + 1])) for i in range(0, len(line), 2)
            ]
            found.extend(pairwise(points))
    return tuple(found)


def text_length(text: str, size: float) -> float:
    """Return the length of a text, its strokes' ends included."""
    return size * ((len(text) - 1) * _ADVANCE + _WIDTH) / _HEIGHT + size * STROKE if text else 0.0
