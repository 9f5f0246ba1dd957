"""The fit coupon: plugs at several clearances in a frame and a loose socket, drawn by the functions that draw kits.

Each plug has the sleeve of a kit, a groove for an O-ring and a seat for the core, and a label with a hole for each 0.05 mm of its clearance. They are
printed to find the clearance of a printer: the least at which the socket slides on and the core drops to its seat.
"""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from manifold3d import CrossSection

from driftform.types import Body, Detail
from driftform_frusta.csg import Difference, Extrude, Node, Revolve, Translate, Union
from driftform_frusta.fittings import add_details
from driftform_frusta.kit_options import CORD, PartOptions
from driftform_frusta.parts import Part
from driftform_frusta.solid import to_solid
from driftform_kit.cutting import meridian
from driftform_kit.cutting.bay import SEAT, Ball, draw_seat
from driftform_kit.cutting.cut import LOCKS, make_sleeve
from driftform_kit.cutting.gland import choose_gland
from driftform_kit.cutting.joint import LIP, draw_joint, seal_bore
from driftform_kit.cutting.meridian import MM

CLEARANCES = (0.1, 0.15, 0.2, 0.25, 0.3)
"""mm, of the plugs."""

MAX_LINES = 4
"""Printed lines of its wall: a hull under pressure may have more."""

_COLUMNS = 3
_SHARED = 0.5
"""mm of wall that two neighbours share."""

_STEP = 0.05
"""mm of clearance for which a label has a hole."""

_PITCH, _HOLE, _THICK = 3.0, 0.9, 1.6
"""mm: distance and radius of the holes of a label, and its thickness."""

_APART = 3.0
"""mm between the frame and the loose socket."""


def make_coupon(body: Body, options: PartOptions) -> Part:
    """Return the fit coupon for the core and the wall of a body, and sleeves and O-rings of some options.

    Raises WorkFailedError if it has no solid.
    """
    core, sealed = MM * body.core.radius, options.model_copy(update={"o_ring": options.cord or CORD})
    models = [make_sleeve(0.0, -1, sealed.model_copy(update={"clearance": gap / MM}), True) for gap in CLEARANCES]
    gland, lap, lock = choose_gland(MM * sealed.o_ring), models[0].lap, LOCKS.get(models[0].kind)
    # A wall of more lines fits alike, and takes longer to print.
    wall = MM * min(body.wall, MAX_LINES * options.nozzle)
    # The sleeve is thinnest at the largest clearance. A ring that is sold fits within a step of the sizes.
    need = core + 2 * CLEARANCES[-1] + models[0].plug
    bore = next(r for r in (seal_bore(gland, need + 0.05 * k) for k in range(100)) if r >= need)
    tube = bore + max(0.0, gland.proud + LIP - wall)
    # A seat ends at the wall, at 45 degrees.
    low, high = -(tube + 2 * SEAT), lap + 1.0
    hull = meridian.draw_tube(tube, wall, core, low, high)
    cells = []
    for model in models:
        # The core passes the plug with this clearance.
        joint = replace(model, plug=bore - core - 2 * model.gap)
        pad, pocket, ring = draw_joint(hull, joint)
        plug = (hull.material ^ meridian.make_slab(low, 0.0)) + ring
        seat = draw_seat(hull, Ball(0.0, core), [plug], 0, meridian.make_slab(high, high + 1), -1, joint.gap)
        assert seat is not None  # A straight tube has room.
        cells.append(_make_cell(plug + seat.section, lock.cut_tracks(joint, bore, plug) if lock else ()))
    socket = (hull.material + pad ^ meridian.make_slab(0.0, high)) - pocket
    ring_cell = _make_cell(socket, [lock.draw_lugs(joint, bore, socket)] if lock else ())
    cells.append(Translate((0.0, 0.0, low), ring_cell))
    pitch = 2 * hull.widest - _SHARED
    placed: list[Node] = []
    for place, cell in enumerate(cells):
        row, column = divmod(place, _COLUMNS)
        loose = _APART if place == len(CLEARANCES) else 0.0
        at = (column * pitch + loose, row * pitch + loose, -low)
        placed.append(Translate(at, cell))
        if not loose:
            placed.append(_make_label(round(CLEARANCES[place] / _STEP), at, hull.widest, -1 if row == 0 else 1))
    tree = Union(tuple(placed))
    return Part("fit coupon", tree, to_solid(tree, options.segments))


def _make_cell(section: CrossSection, details: Iterable[Detail]) -> Node:
    shape = Revolve(*meridian.split_rings(meridian.list_rings(meridian.take_half(section))))
    return add_details(shape, details)


def describe_coupon(body: Body, options: PartOptions) -> dict[str, Any]:
    """Return the ``core_mm`` and the ``o_ring_mm`` of a coupon, and the ``next`` step."""
    return {
        "core_mm": 2 * MM * body.core.radius,
        "o_ring_mm": MM * (options.cord or CORD),
        "next": "print it as you print kits; take the fewest holes, of 0.05 mm each, at which the loose ring slides on by hand, with a greased "
        "O-ring too if you use some, and at which the core drops to its seat; then give that clearance, in m, to all kits: "
        "--option clearance=0.00015",
    }


def _make_label(count: int, at: tuple[float, float, float], widest: float, side: int) -> Node:
    """Return a plate with a row of holes on one side of a cell."""
    half, wide = _PITCH * count / 2, _PITCH / 2
    plate = Extrude(((-half, -wide), (half, -wide), (half, wide), (-half, wide)), (), _THICK)
    hole = Revolve(((0.0, -1.0), (_HOLE, -1.0), (_HOLE, _THICK + 1), (0.0, _THICK + 1)))
    holes = tuple(Translate((_PITCH * (place + 0.5) - half, 0.0, 0.0), hole) for place in range(count))
    return Translate((at[0], at[1] + side * (widest + wide - 0.5), 0.0), Difference(plate, holes))
