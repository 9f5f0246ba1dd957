"""The paths of the water through a pipe with parts, along which a page lets the arrows of its current drift."""

import math
from functools import lru_cache

import numpy as np

from driftform.figures.projection import find_corners
from driftform.types import FloatArray
from driftform.water import Pipe, Scenario
from driftform.water.parts.shapes import Straight, Tee

STREAMS = 40
"""Number of paths; they begin in the middle of parts of the inlet of equal area."""

NEAREST = 0.97
"""Greatest distance from the axis at which a path begins, in radii of the inlet."""

STEP = 0.2
"""Length of a step in a fitting, in radii of its bore."""

STEPS_OF_STRAIGHT = 30
"""Largest number of steps in a straight, apart from those near its end."""

TOLERANCE = 0.02
"""Distance by which a position may be moved where points of a path are left out, in radii of the narrowest bore."""

MAX_STEPS = 2000
"""Steps after which a path ends: it goes round in water that hardly moves."""

SLOWEST = 1e-3
"""Speed at which a path ends, as a share of that at the inlet."""


def trace_streams(scenario: Scenario) -> list[FloatArray]:
    """Return paths of the mean flow from the inlet to the outlets: time (s) and position (m) at each point, (n, 4) each.

    None in a straight pipe, whose current is its profile, in open water, and with a tee whose flow is not solved yet: that
    takes a minute, and is left to the first flight.
    """
    from driftform.water.fittings import fitting_array
    from driftform.water.parts.tee_flow import is_tee_solved
    from driftform.water.velocity import flow_array

    if scenario.pipe.is_open or scenario.pipe.straight is not None:
        return []
    tees = [placed.part for placed in scenario.pipe.layout.parts if isinstance(placed.part, Tee)]
    if not all(is_tee_solved(tee.radius, tee.branch_radius, tee.angle, tee.fillet) for tee in tees):
        return []
    fittings = fitting_array(scenario)
    assert fittings is not None
    return _trace(scenario.pipe, tuple(flow_array(scenario)), fittings.tobytes())


@lru_cache(maxsize=16)
def _trace(pipe: Pipe, flow: tuple[float, ...], fittings: bytes) -> list[FloatArray]:
    """Integrate the paths by the midpoint rule; a page asks for the same pipe again and again."""
    from driftform.water.parts.profiles import AT_A_POINT
    from driftform.water.velocity import water_motion

    no_pipe, current = np.empty((0, 8)), np.array(flow)
    parts = np.frombuffer(fittings)

    def velocity(points: FloatArray) -> FloatArray:
        return np.array(
            [water_motion((x, y, z), 0.0, no_pipe, current, AT_A_POINT, parts)[0] for x, y, z in points.tolist()]
        )

    inlet = pipe.layout.inlet
    places = spread_over_disc(STREAMS) * NEAREST * inlet.radius
    position = inlet.centre + places @ inlet.axes[1:]
    time = np.zeros(STREAMS)
    paths = [[np.array([0.0, *p])] for p in position]
    going = np.arange(STREAMS)
    fastest = float(np.linalg.norm(velocity(position), axis=1).max())
    for _ in range(MAX_STEPS):
        here = pipe.layout.find_part(position[going])
        # The inlet's section itself may be outside by rounding.
        going, here = going[here >= 0], here[here >= 0]
        if not len(going):
            break
        start = velocity(position[going])
        speed = np.linalg.norm(start, axis=1)
        moving = speed > SLOWEST * fastest
        going, here, start, speed = going[moving], here[moving], start[moving], speed[moving]
        if not len(going):
            break
        duration = _choose_steps(pipe, here, position[going]) / speed
        middle = velocity(position[going] + 0.5 * duration[:, None] * start)
        position[going] += duration[:, None] * middle
        time[going] += duration
        for k in going:
            paths[k].append(np.array([time[k], *position[k]]))
    tolerance = TOLERANCE * pipe.layout.narrowest
    return [simplify_motion(np.stack(path), tolerance) for path in paths if len(path) > 1]


def simplify_motion(path: FloatArray, tolerance: float) -> FloatArray:
    """Return the points of a motion, time and position in each row, that keep each position within ``tolerance`` (m).

    Between two points the position is linear in time.
    """

    def measure(first: int, last: int) -> FloatArray:
        (t0, *_), between = path[first], path[first + 1 : last]
        share = (between[:, :1] - t0) / (path[last, 0] - t0)
        expected = path[first, 1:] + share * (path[last, 1:] - path[first, 1:])
        return np.asarray(np.linalg.norm(between[:, 1:] - expected, axis=1) ** 2)

    return path[find_corners(len(path), measure, tolerance)]


def _choose_steps(pipe: Pipe, parts: np.ndarray, points: FloatArray) -> FloatArray:
    """Return the length of the next step at each point, m: short in fittings and at the ends of straights."""
    steps = np.empty(len(points))
    for index in np.unique(parts):
        part, here = pipe.layout.parts[index].part, parts == index
        least = STEP * min(opening.radius for opening in part.list_exits())
        steps[here] = least
        if isinstance(part, Straight):
            left = part.length - part.to_local(points[here])[:, 0]
            steps[here] = np.clip(left - 2 * part.radius, least, max(least, part.length / STEPS_OF_STRAIGHT))
    return steps


def spread_over_disc(count: int) -> FloatArray:
    """Return points of the unit disc, each in the middle of the same area, on the spiral of sunflowers, (count, 2)."""
    k = np.arange(count) + 0.5
    radius, angle = np.sqrt(k / count), math.pi * (3 - math.sqrt(5)) * k
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
