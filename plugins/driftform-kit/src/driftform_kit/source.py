"""OpenSCAD source of a kit, to edit: its hull, and joints and seats that follow from clearance, wall and sleeve.

The source repeats the steps of :mod:`driftform_kit.cutting`. What is searched for there, such as the place of a joint, is in a table
by the clearance.
"""

import json
from contextlib import suppress
from typing import Any

from driftform.errors import WorkFailedError
from driftform.types import Body
from driftform_frusta.kit_options import PartOptions
from driftform_frusta.scad import fill_source, format_number, write_module, write_points
from driftform_kit.cutting import bay, bayonet, joint, meridian, thread
from driftform_kit.cutting.gland import choose_gland, list_rings
from driftform_kit.cutting.meridian import MM
from driftform_kit.cutting.pieces import Kit, make_kit

_CLEARANCES = tuple(0.01 * step for step in range(5, 41))
"""mm, for which the source has the cuts."""


def write_kit(body: Body, options: PartOptions, low: float, high: float) -> tuple[str, str]:
    """Return what a user sets in the source of a kit, and the modules of that, of which ``made(k)`` is part k.

    The ends of the kit are at the heights ``low`` and ``high`` in the assembled hull, mm.

    Raises WorkFailedError if no kit can be made of the body; the message has the reason.
    """
    kit, gland = make_kit(body, options), choose_gland(MM * options.cord)
    rows = _list_cuts(body, options, len(kit.joints))
    hull = kit.hull
    values: dict[str, float] = {
        name.lower(): value
        for module in (bay, bayonet, joint, meridian, thread)
        for name, value in vars(module).items()
        if name.isupper() and isinstance(value, int | float)
    }
    values |= {name: MM * getattr(options, name) for name in ("clearance", "sleeve", "lap", "nozzle")}
    values |= {
        "least": _CLEARANCES[0],
        "most": max(clearance for clearance, _ in rows.values()),
        "wall": hull.wall,
        "low": low,
        "high": high,
    }
    values |= {"cord": gland.cord, "depth": gland.depth, "width": gland.bottom}
    values |= {"far": 2 * float(abs(hull.skin).max()) + 100, "core_joint": kit.joints.index(kit.core_joint)}
    trees = [
        (part, f"{what}_{number}", tree)
        for number, detail in enumerate(body.fittings.details)
        for part, piece in enumerate(kit.pieces)
        if any(one is detail for one in piece.details)
        for what, tree in (("added", detail.added), ("removed", detail.removed))
        if tree is not None
    ]
    texts = {
        what: " ".join(f"if (i == {part}) {name}();" for part, name, _ in trees if what in name)
        for what in ("added", "removed")
    } | {
        "outline": write_points(hull.skin[:, ::-1]),
        "cavity": write_points(hull.bore[:, ::-1]),
        "pockets": _write([ring.tolist() for ring in meridian.list_rings(meridian.take_right(hull.pockets))]),
        "cuts": "\n".join(
            f"    [{format_number(up_to)}, {cut}, {fills}]," for (cut, _), (up_to, fills) in rows.items()
        ),
        "rings": _write([inside for _, inside in list_rings(gland.cord)]),
        "trees": "\n".join(write_module(name, tree) for _, name, tree in trees),
    }
    filled = {name: format_number(value) for name, value in values.items()} | texts
    return fill_source("parameters", **filled), fill_source("parts", **filled)


def _list_cuts(body: Body, options: PartOptions, count: int) -> dict[tuple[str, int], tuple[float, str]]:
    """Return how a hull is cut by ``count`` joints, with the number of pockets that are filled, the greatest of the clearances that cut
    it so, mm, and these pockets.
    """
    found = dict[tuple[str, int], tuple[float, str]]()
    for clearance in sorted({*_CLEARANCES, MM * options.clearance}):
        with suppress(WorkFailedError):
            kit = make_kit(body, options.model_copy(update={"clearance": clearance / MM}))
            if len(kit.joints) == count:
                fills = [[place, ring.tolist()] for place, piece in enumerate(kit.pieces) for ring in piece.filled]
                found[_write_cut(kit, clearance), len(fills)] = clearance, _write(fills)
    return found


def _write_cut(kit: Kit, clearance: float) -> str:
    joints = []
    for one in kit.joints:
        steps = "rabbet" if one is kit.core_joint else "step"
        kind = {"rabbet": steps, "sleeve": "seal" if one.gland else "sleeve"}.get(one.kind, one.kind)
        joints.append([one.z, one.side, kind, 2 * one.plug + clearance if one.kind == "rabbet" else 0.0])
    seats = [[s.part, s.ball.z, s.ball.radius, s.foot, s.angle_deg, s.reach] for s in kit.seats]
    return f"{_write(joints)}, {_write(seats)}"


def _write(value: Any) -> str:
    if isinstance(value, list):
        return f"[{', '.join(map(_write, value))}]"
    return json.dumps(value) if isinstance(value, str) else format_number(value)
