"""Whether a body passes the port, fits into its pipe where it is released, and is in the water there."""

import math
from itertools import pairwise

import numpy as np

from driftform.agent.clearance import farthest_from_line, lowest_along
from driftform.types import Body, FloatArray
from driftform.water import Scenario
from driftform.water.parts.shapes import Opening, Straight

_ROUNDING = 1e-9
"""Overlap, relative to the radius of the bore, that counts as touching."""

_HALVINGS = 20

_AROUND, _BETWEEN = 48, 8
"""Points of a body's surface, around its axis and along each edge of its contour, that must lie in a pipe with parts."""


def find_misfit(body: Body, scenario: Scenario) -> str | None:
    """Return why a body cannot be released in a scenario, in one line with the two numbers; ``None`` if it can.

    The body is compared with the bore by its contour, exactly; beyond the inlet the bore continues.
    """
    over, wide = _find_excess(body, scenario), body.max_diameter
    if over["port"]:
        return (
            f"it does not pass the port: {show_length(wide)} across, {show_length(over['port'])} more than release.port = "
            f"{scenario.release.port:g} m: make it narrower (builder.max_radius), or the port wider"
        )
    if over["bore"]:
        return (
            f"it is too wide for the pipe: {show_length(wide)} across, in a bore of {show_length(wide - over['bore'])}"
        )
    released = _find_fault_of_release(body, scenario)
    return released and released[1]


def find_violations(body: Body, scenario: Scenario) -> dict[str, float]:
    """Return by how much a body is wider than the port and the bore, and beyond the wall or the water where it is released.

    All are in m, by name; 0 for one that can be released. In a pipe with parts the last is its length times the share of its
    surface that is outside.
    """
    released = _find_fault_of_release(body, scenario)
    return _find_excess(body, scenario) | {"release": released[0] if released else 0.0}


def _find_fault_of_release(body: Body, scenario: Scenario) -> tuple[float, str] | None:
    """Return by how much a body is beyond the wall or the water where it is released, m, and a line on it; ``None`` if it is not."""
    position, axis = scenario.release_position(), scenario.release_axis()
    level = scenario.fluid.water_level
    if level is not None:
        bottom = lowest_along(body.outer, position, axis, np.array([0.0, 0.0, 1.0]))
        if bottom >= level:
            return bottom - level, (
                f"it is released above the water: its lowest point is at z {bottom:.4g} m, and fluid.water_level is "
                f"{level:g} m"
            )
    if scenario.pipe.is_open:
        return None
    inlet = scenario.pipe.layout.inlet
    if not _lies_in_first_straight(body, scenario):
        return _find_misfit_in_parts(body, scenario)
    reach = _reach_from_axis(body, position, axis, inlet)
    if reach > inlet.radius * (1 + _ROUNDING):
        return reach - inlet.radius, (
            f"it is released in the wall: it reaches {show_length(reach)} from the axis of a bore with the radius "
            f"{show_length(inlet.radius)}; it is {show_length(body.length)} long: change release.position, pitch_deg or yaw_deg"
        )
    return None


def _find_excess(body: Body, scenario: Scenario) -> dict[str, float]:
    """Return by how much a body is wider than the port and the bore at the inlet, m, by name; 0 for one that passes."""
    wide, port = body.max_diameter, scenario.release.port or math.inf
    bore = math.inf if scenario.pipe.is_open else 2 * scenario.pipe.layout.inlet.radius
    over = {"port": wide - port, "bore": wide - bore}
    return {name: excess if excess > _ROUNDING * wide else 0.0 for name, excess in over.items()}


def _reach_from_axis(body: Body, position: FloatArray, axis: FloatArray, inlet: Opening) -> float:
    """Return the greatest distance (m) of a released body from the axis of the inlet; a bound of it if that fits already."""
    direction = inlet.axes[0]
    off_axis = math.hypot(*np.cross(position - inlet.centre, direction).tolist())
    bound = off_axis + float(np.hypot(*body.outer.T).max())
    if bound < inlet.radius:
        return bound
    return farthest_from_line(body.outer, position, axis, inlet.centre, direction)


def _lies_in_first_straight(body: Body, scenario: Scenario) -> bool:
    """Return whether a body that is released in a pipe lies in its first straight part, or upstream of the inlet."""
    if scenario.pipe.straight is not None:
        return True
    first = scenario.pipe.layout.parts[0].part
    along = float((scenario.release_position() - first.entry) @ first.axes[0])
    return isinstance(first, Straight) and along + float(np.hypot(*body.outer.T).max()) <= first.length


def _find_misfit_in_parts(body: Body, scenario: Scenario) -> tuple[float, str] | None:
    layout, axis = scenario.pipe.layout, scenario.release_axis()
    across = np.linalg.svd(axis[None])[2][1:]
    angle = np.linspace(0, 2 * np.pi, _AROUND, endpoint=False)
    circle = np.cos(angle)[:, None] * across[0] + np.sin(angle)[:, None] * across[1]
    steps = np.linspace(0, 1, _BETWEEN, endpoint=False)
    contour = np.concatenate([a + steps[:, None] * (b - a) for a, b in pairwise(body.outer)])
    rings = contour[:, :1, None] * axis + contour[:, 1, None, None] * circle
    points = scenario.release_position() + rings.reshape(-1, 3)
    inlet = layout.inlet
    off = (points - inlet.centre) @ inlet.axes.T
    upstream = (off[:, 0] <= 0) & (np.hypot(off[:, 1], off[:, 2]) <= inlet.radius)
    outside = (layout.find_part(points) < 0) & ~upstream
    if not outside.any():
        return None
    x, y, z = points[outside][0].tolist()
    return float(outside.mean()) * body.length, (
        f"it is released in the wall, at x {x:.4g}, y {y:.4g}, z {z:.4g} m; it is {show_length(body.length)} long: "
        "change release.position, pitch_deg or yaw_deg, or begin the pipe with a longer straight"
    )


def ease_release(body: Body, nominal: Scenario, disturbed: Scenario) -> Scenario:
    """Return the disturbed scenario with a release that the wall leaves room for.

    The deviation of the release from the nominal one is halved until the body fits: the hand that releases it feels the wall.
    """
    share, release = 1.0, disturbed.release
    for _ in range(_HALVINGS):
        if find_misfit(body, disturbed) is None:
            break
        share = 0.5 * share
        values = {}
        for name in ("position", "pitch_deg", "yaw_deg"):
            usual = np.array(getattr(nominal.release, name))
            moved = usual + share * (np.array(getattr(release, name)) - usual)
            values[name] = tuple(moved.tolist()) if moved.ndim else float(moved)
        disturbed = disturbed.model_copy(update={"release": release.model_copy(update=values)})
    return disturbed


def show_length(length: float) -> str:
    """Return a length in mm, or in m from 10 m on."""
    return f"{length:.4g} m" if length >= 10 else f"{1000 * length:.4g} mm"
