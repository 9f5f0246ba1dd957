"""Body -> CSG tree of its hull, in the printed frame.

Printed frame: millimetres, the body's axis along z, the fore end up, the lowest point at z = 0. The core lies
loose in the cavity and is not part of the hull.
"""

import numpy as np

from driftform.agent import solid_of_revolution
from driftform.errors import WorkFailedError
from driftform.types import Body, FloatArray
from driftform_frusta.csg import MM, Named, Node, Point, Revolve

# Coordinates are rounded to multiples of 2^-30 mm (about 1e-9 mm): sums and differences of such numbers are
# exact in double precision, so that two frustums which share a vertex of the section meet without a gap.
_GRID = 2.0**30


def hull_volume(body: Body) -> float:
    """Return the volume of the hull's wall, m3: outer contour less cavity, without fittings."""
    return solid_of_revolution(body.outer).volume - solid_of_revolution(body.cavity).volume


def build_hull(body: Body) -> Node:
    """Return the hull as its meridian section revolved: outer contour less cavity.

    This is the fast route: booleans are done in the plane.

    Raises WorkFailedError if a contour does not run from the axis to the axis.
    """
    outer, cavity = read_contours(body)
    holes = (_points(cavity),) if len(cavity) else ()
    return Named("hull: the meridian section, revolved; fore end up", Revolve(_points(outer), holes))


def read_contours(body: Body) -> tuple[FloatArray, FloatArray]:
    """Return outer contour and cavity as (n, 2) of z and r in the printed frame; the cavity may be empty.

    Raises WorkFailedError if one does not run from the axis to the axis.
    """
    contours = []
    for what, contour in (("outer contour", body.outer), ("cavity", body.cavity)):
        if what == "cavity" and not len(contour):
            contours.append(contour)
            continue
        if not np.isfinite(contour).all():
            raise WorkFailedError(f"the hull has no solid: its {what} has coordinates that are not finite")
        if len(contour) < 3:
            raise WorkFailedError(f"the hull has no solid: its {what} has {len(contour)} points, fewer than 3")
        printed = np.array(contour)
        printed[:, 0] -= body.outer[:, 0].min()
        printed = np.round(printed * MM * _GRID) / _GRID
        if printed[0, 1] or printed[-1, 1]:
            raise WorkFailedError(f"the hull has no solid: its {what} does not begin and end on the axis")
        if not (printed[:, 1] > 0).any():
            raise WorkFailedError(f"the hull has no solid: its {what} never leaves the axis")
        contours.append(printed)
    return contours[0], contours[1]


def _points(contour: FloatArray) -> tuple[Point, ...]:
    return tuple((float(r), float(z)) for z, r in contour)
