"""Whether a body fits into its pipe where it is released, and is in the water there."""

import numpy as np

from driftform.geometry.clearance import farthest_from_line, lowest_along
from driftform.scenario import Scenario
from driftform.types import Body

_ROUNDING = 1e-9
"""Overlap, relative to the radius of the bore, that counts as touching."""

_HALVINGS = 20


def find_misfit(body: Body, scenario: Scenario) -> str | None:
    """Return why a body cannot be released in a scenario, in one line with the two numbers; ``None`` if it can.

    The body is compared with the bore by its contour, exactly; beyond the inlet the bore continues.
    """
    position, axis = scenario.release_position(), scenario.release_axis()
    level = scenario.fluid.water_level
    if level is not None:
        bottom = lowest_along(body.outer, position, axis, np.array([0.0, 0.0, 1.0]))
        if bottom >= level:
            return (
                f"it is released above the water: its lowest point is at z {bottom:.4g} m, and fluid.water_level is "
                f"{level:g} m"
            )
    if not scenario.pipe.segments:
        return None
    first = scenario.pipe.segments[0]
    bore = 2 * first.radius
    if body.max_diameter > bore * (1 + _ROUNDING):
        return f"it is too wide for the pipe: {show_length(body.max_diameter)} across, in a bore of {show_length(bore)}"
    start = np.array(first.start)
    reach = farthest_from_line(body.outer, position, axis, start, scenario.direction())
    if reach > first.radius * (1 + _ROUNDING):
        return (
            f"it is released in the wall: it reaches {show_length(reach)} from the axis of a bore with the radius "
            f"{show_length(first.radius)}; it is {show_length(body.length)} long: change release.position, pitch_deg or yaw_deg"
        )
    return None


def ease_release(body: Body, nominal: Scenario, disturbed: Scenario) -> Scenario:
    """Return the disturbed scenario with a release that the wall leaves room for.

    The deviation of the release from the nominal one is halved until the body fits: whoever releases it feels the wall.
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
