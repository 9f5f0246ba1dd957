"""Body -> CSG tree of its hull and printable solid, in the printed frame, compared with the closed form of its section.

Printed frame: millimetres, the body's axis along z, the fore end up, the lowest point at z = 0. The core lies
loose in the cavity and is not part of the hull. A mesh whose cavity is turned inside out is closed and manifold too: only
its volume shows the fault.
"""

import math
from dataclasses import replace

import numpy as np

from driftform.agent import distance_from, solid_of_revolution
from driftform.errors import WorkFailedError
from driftform.types import Body, FloatArray, Moments
from driftform_frusta.csg import MM, Node, Point, Revolve
from driftform_frusta.solid import Solid, to_solid

MM3_PER_M3 = 1e9

# Relative, between the mesh in double precision and the closed form.
_VOLUME_TOLERANCE = 1e-6

_PROUD = 0.001
"""m by which the tool of a trim pocket leaves the hull, so that no skin is left in its mouth."""

# m: contours nearer than this touch.
_NO_WALL = 1e-6

# Coordinates are rounded to multiples of 2^-30 mm (about 1e-9 mm): sums and differences of such numbers are
# exact in double precision, so that two frustums which share a vertex of the section meet without a gap.
_GRID = 2.0**30


def wall_moments(body: Body) -> Moments:
    """Return the volume integrals of the hull's wall: outer contour less cavity and trim pockets, without fittings."""
    holes = (body.cavity, *(pocket.contour() for pocket in body.pockets))
    return sum((Moments() - solid_of_revolution(hole) for hole in holes), solid_of_revolution(body.outer))


def hull_volume(body: Body) -> float:
    """Return the volume of the hull's wall, m3, as of :func:`wall_moments`."""
    return wall_moments(body).volume


def printed_volume(body: Body) -> float:
    """Return the volume of the material of the hull in one piece, m3: its wall and its details."""
    return hull_volume(body) + sum(detail.moments.volume for detail in body.fittings.details)


def build_hull(body: Body) -> Node:
    """Return the hull as its meridian section revolved: outer contour less cavity; errors as of :func:`read_contours`."""
    outer, cavity = read_contours(body)
    holes = (*((_points(cavity),) if len(cavity) else ()), *map(_points, list_pockets(body)))
    return Revolve(_points(outer), holes)


def list_pockets(body: Body) -> list[FloatArray]:
    """Return the contour of each trim pocket as (n, 2) of z and r in the printed frame; it leaves the hull by :data:`_PROUD`."""
    longer = [replace(p, mouth=p.mouth + math.copysign(_PROUD, p.mouth - p.tip)) for p in body.pockets]
    return [_place(pocket.contour(), body) for pocket in longer]


def read_contours(body: Body) -> tuple[FloatArray, FloatArray]:
    """Return outer contour and cavity as (n, 2) of z and r in the printed frame; the cavity may be empty.

    Raises WorkFailedError if one does not run from the axis to the axis.
    """
    contours = []
    for what, contour in (("outer contour", body.outer), ("cavity", body.cavity))[: 1 + bool(len(body.cavity))]:
        if not np.isfinite(contour).all():
            raise WorkFailedError(f"the hull has no solid: its {what} has coordinates that are not finite")
        if len(contour) < 3:
            raise WorkFailedError(f"the hull has no solid: its {what} has {len(contour)} points, fewer than 3")
        printed = _place(contour, body)
        if printed[0, 1] or printed[-1, 1]:
            raise WorkFailedError(f"the hull has no solid: its {what} does not begin and end on the axis")
        if not (printed[:, 1] > 0).any():
            raise WorkFailedError(f"the hull has no solid: its {what} never leaves the axis")
        contours.append(printed)
    return contours[0], contours[1] if contours[1:] else body.cavity


def _place(contour: FloatArray, body: Body) -> FloatArray:
    """Return a contour, x and r in m, as z and r in the printed frame."""
    return np.asarray(np.round((contour - (body.outer[:, 0].min(), 0.0)) * MM * _GRID) / _GRID)


def _points(contour: FloatArray) -> tuple[Point, ...]:
    return tuple((float(r), float(z)) for z, r in contour)


def build_printable_hull(body: Body, segments: int) -> tuple[Node, Solid]:
    """Return the hull's tree and its solid.

    The solid is checked: it is in one piece, and of the section's volume. A sealed hull has two closed surfaces, the
    outside and a hollow.

    Raises WorkFailedError if the body has no such solid; the message has the reason.
    """
    check_printable_section(body)
    tree = build_hull(body)
    solid = to_solid(tree, segments)
    refuse_other_volume(solid.volume, hull_volume(body), "hull")
    if solid.pieces != 1:
        raise WorkFailedError(f"the hull falls into {solid.pieces} pieces")
    return tree, solid


def check_printable_section(body: Body) -> None:
    """Check that the hull's contours have a wall between them all round.

    Raises WorkFailedError if the contours have no wall between them, or touch the axis; the message has the reason.
    """
    read_contours(body)
    if len(body.cavity):
        _refuse_without_wall(body)
    off_axis = np.flatnonzero(body.outer[:, 1] > _NO_WALL)
    gaps = np.flatnonzero(np.diff(off_axis) > 1)
    if len(gaps):
        x = body.outer[off_axis[gaps[0]] + 1, 0]
        raise WorkFailedError(
            f"the hull is not one printable part: its outer contour touches the axis at x = {x:.6f} m"
        )


def refuse_other_volume(volume: float, expected: float, what: str, tolerance: float = _VOLUME_TOLERANCE) -> None:
    """Compare the volume of a solid, mm3, with that of its section in closed form, m3.

    Raises WorkFailedError if they differ.
    """
    closed_form = expected * MM3_PER_M3
    if not abs(volume - closed_form) <= tolerance * closed_form:
        raise WorkFailedError(
            f"the solid of the {what} has {volume:.3f} mm3, its section {closed_form:.3f} mm3: a contour "
            "crosses itself or the axis, or the cavity leaves the outer contour"
        )


def _refuse_without_wall(body: Body) -> None:
    to_outer = distance_from(body.cavity, body.outer)
    to_cavity = distance_from(body.outer, body.cavity)
    if min(to_outer.min(), to_cavity.min()) >= _NO_WALL:
        return
    points, distances = (body.cavity, to_outer) if to_outer.min() <= to_cavity.min() else (body.outer, to_cavity)
    x = float(points[np.argmin(distances), 0])
    ends = (("aft", body.outer[0, 0]), ("fore", body.outer[-1, 0]))
    where = next((f"at its {name} end" for name, end in ends if abs(x - end) < _NO_WALL), f"at x = {x:.6f} m")
    raise WorkFailedError(
        f"the hull has no closed printable solid: the cavity touches the outer contour {where}, so that the "
        "hull is open there; give it a wall all round, and caps at its ends"
    )
