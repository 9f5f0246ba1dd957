"""Numbers of straight strokes, for the labels of the fit coupon: the same on every machine, whatever its fonts."""

from itertools import pairwise

from manifold3d import CrossSection, OpType

STROKE = 0.8
"""Width of a stroke, in units."""

_HEIGHT, _ADVANCE = 6.0, 5.5
"""Units of the grid: height of a digit, and from one to the next."""

# Each line of a digit is a row of points, two digits each, x and y in units.
_DIGITS = {
    ".": "2020",
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
}


def draw_number(text: str, size: float) -> CrossSection:
    """Return the strokes of a number united, mm, with ``size`` as the height of a digit; the first one begins at the origin."""
    pen = CrossSection.circle(STROKE / 2, 8)
    drawn = []
    for place, digit in enumerate(text):
        for line in _DIGITS[digit].split():
            points = [(place * _ADVANCE + int(x), float(y)) for x, y in zip(line[::2], line[1::2], strict=True)]
            ends = [pen.translate(point) for point in points]
            drawn += [CrossSection.batch_hull(list(pair)) for pair in pairwise(ends)]
    return CrossSection.batch_boolean(drawn, OpType.Add).scale((size / _HEIGHT,) * 2)
