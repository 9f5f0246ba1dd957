"""The closest approach of a trajectory's path to given points, and of the agent to the wall."""

from dataclasses import dataclass

import numpy as np

from driftform.motion.path.clearance import wall_clearances
from driftform.motion.path.curve import row_vector, stretch_cubic, world_velocity
from driftform.types import FloatArray, Trajectory
from driftform.util.compiled import allocating
from driftform.util.cubic import cubic_point, nearest_on_cubic
from driftform.util.small_vectors import add, distance_between, norm, scale, subtract

__all__ = ["Approach", "closest_approach", "wall_clearances"]

_STATIONS = 4
"""Points of each stretch, its start among them, that are compared before Newton's method starts."""

_COARSE = 16
"""Every 16th sample is compared first; the nearest of them bounds the distance from above."""

_ROUNDING = 1e-9
"""Margin for the rounding of lengths along the path, m; the rounding errors are far smaller."""


@dataclass(frozen=True, eq=False)
class Approach:
    """The closest approach to a point: ``distance`` (m), ``t`` (s), ``position`` (world, m, (3,))."""

    distance: float
    t: float
    position: FloatArray


def closest_approach(trajectory: Trajectory, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return distance (m) and time (s) at which the path comes closest to each of ``points`` (n, 3); two (n,).

    The path between samples is their cubic Hermite curve. Newton's method finds the foot of the perpendicular: it
    starts from the nearest of four stations on every stretch, and also searches the stretch before that one.
    """
    distances = np.empty(len(points))
    times = np.empty(len(points))
    if len(trajectory.t) == 1:
        distances[:] = np.linalg.norm(points - trajectory.position[0], axis=1)
        times[:] = trajectory.t[0]
    else:
        velocity = world_velocity(trajectory)
        _find_closest(trajectory.t, trajectory.position, velocity, np.array(points, order="C"), distances, times)
    return distances, times


@allocating
def _find_closest(
    t: FloatArray,
    position: FloatArray,
    velocity: FloatArray,
    points: FloatArray,
    distances: FloatArray,
    times: FloatArray,
) -> None:
    """Fill ``distances`` and ``times`` (n,) with the closest approach to each of ``points`` (n, 3)."""
    stretches = t.shape[0] - 1
    longest = _longest_lengths(t, position, velocity)
    for index in range(points.shape[0]):
        point = row_vector(points, index)
        bound = np.inf
        for s in range(0, stretches, _COARSE):
            bound = min(bound, distance_between(row_vector(position, s), point))
        nearest, stretch, station = np.inf, 0, 0.0
        s = 0
        while s < stretches:
            cubic = stretch_cubic(t, position, velocity, s)
            for g in range(_STATIONS):
                distance = distance_between(cubic_point(cubic, g / _STATIONS), point)
                if distance < nearest:
                    nearest, stretch, station = distance, s, g / _STATIONS
            bound = min(bound, nearest)
            # The path must be at least this long before it can come nearer than the bound: skip those stretches.
            needed = longest[s + 1] + distance_between(row_vector(position, s + 1), point) - bound - _ROUNDING
            s += 1
            while s < stretches and longest[s + 1] < needed:
                s += 1
        distances[index], u = nearest_on_cubic(stretch_cubic(t, position, velocity, stretch), point, station)
        times[index] = t[stretch] + u * (t[stretch + 1] - t[stretch])
        # The end of the path is not a station, and the foot may lie on either side of the nearest station.
        for s in (stretch - 1, stretches - 1):
            if s >= 0:
                distance, u = nearest_on_cubic(stretch_cubic(t, position, velocity, s), point, 1.0)
                if distance < distances[index]:
                    distances[index] = distance
                    times[index] = t[s] + u * (t[s + 1] - t[s])


@allocating
def _longest_lengths(t: FloatArray, position: FloatArray, velocity: FloatArray) -> FloatArray:
    """Return an upper bound of the length of the path from the release to each sample, m, (k,).

    A stretch is no longer than the polygon of its Bezier points p, p + h v / 3, q - h w / 3, q.
    """
    longest = np.zeros(t.shape[0])
    q, w = row_vector(position, 0), row_vector(velocity, 0)
    end = norm(w)
    for i in range(t.shape[0] - 1):
        third = (t[i + 1] - t[i]) / 3
        p, v, start = q, w, end
        q, w = row_vector(position, i + 1), row_vector(velocity, i + 1)
        end = norm(w)
        middle = distance_between(add(p, scale(third, v)), subtract(q, scale(third, w)))
        longest[i + 1] = longest[i] + third * (start + end) + middle
    return longest
