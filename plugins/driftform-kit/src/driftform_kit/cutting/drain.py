"""Holes on the axis through both ends, to fill the hull and to drain it."""

from manifold3d import CrossSection

from driftform.errors import WorkFailedError
from driftform_kit.cutting.meridian import FAR, Hull, make_polygon

RIM = 1.0
"""mm of material that must stay around a hole."""

MAX_DEPTH = 10.0
"""mm of solid end that a hole goes through."""


def add_drain(hull: Hull, section: CrossSection, side: int, diameter: float) -> CrossSection:
    """Return the section of an end part with a hole through its end.

    Fails if the end is too slim, or too thick, for the hole.
    """
    r = diameter / 2
    skin, bore = (hull.skin, hull.bore) if side < 0 else (hull.skin[::-1], hull.bore[::-1])
    end = float(skin[0, 0])
    what = f"no hole of {diameter:g} mm can be made in the {'fore' if side > 0 else 'aft'} end"
    wide = bore[bore[:, 1] >= r]
    if not len(wide) or abs(float(wide[0, 0]) - end) > MAX_DEPTH:
        raise WorkFailedError(
            f"{what}: the cavity is not wider than that within {MAX_DEPTH:g} mm of the end; make drain smaller"
        )
    inner = float(wide[0, 0])
    through = skin[(skin[:, 0] - inner) * side >= 0][1:, 1]
    if len(through) and float(through.max()) < r + RIM:
        raise WorkFailedError(f"{what}: it is {2 * float(through.max()):.1f} mm wide; make drain smaller")
    hole = make_polygon([(-r, end + side * FAR), (r, end + side * FAR), (r, inner), (-r, inner)])
    return section - hole
