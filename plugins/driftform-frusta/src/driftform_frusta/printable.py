"""Body -> its hull as a printable solid, compared with the closed form of its section.

A mesh whose cavity is turned inside out is closed and manifold too: only its volume shows the fault.
"""

import numpy as np

from driftform.agent import distance_from
from driftform.errors import WorkFailedError
from driftform.types import Body
from driftform_frusta.boundary import Solid
from driftform_frusta.csg import Node
from driftform_frusta.hull import build_hull, hull_volume, read_contours
from driftform_frusta.solid import to_solid

MM3_PER_M3 = 1e9

# Relative, between the mesh in double precision and the closed form.
_VOLUME_TOLERANCE = 1e-6

# m: contours nearer than this touch.
_NO_WALL = 1e-6


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
    _refuse_without_wall(body)
    _refuse_pinched(body)


def refuse_other_volume(volume: float, expected: float, what: str) -> None:
    """Compare the volume of a solid, mm3, with that of its section in closed form, m3.

    Raises WorkFailedError if they differ.
    """
    closed_form = expected * MM3_PER_M3
    if not abs(volume - closed_form) <= _VOLUME_TOLERANCE * closed_form:
        raise WorkFailedError(
            f"the solid of the {what} has {volume:.3f} mm3, its section {closed_form:.3f} mm3: a contour "
            "crosses itself or the axis, or the cavity leaves the outer contour"
        )


def _refuse_without_wall(body: Body) -> None:
    if not len(body.cavity):
        return
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


def _refuse_pinched(body: Body) -> None:
    off_axis = np.flatnonzero(body.outer[:, 1] > _NO_WALL)
    gaps = np.flatnonzero(np.diff(off_axis) > 1)
    if len(gaps):
        x = body.outer[off_axis[gaps[0]] + 1, 0]
        raise WorkFailedError(
            f"the hull is not one printable part: its outer contour touches the axis at x = {x:.6f} m"
        )
