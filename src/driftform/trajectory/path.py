"""The path between the samples of a trajectory: cubic Hermite curves through positions and velocities."""

import numpy as np
import numpy.typing as npt

from driftform.dynamics.cubic import Cubic, _distance, at, cubic_between, foot
from driftform.dynamics.rotations import rotation_from_quaternion
from driftform.dynamics.vectors import Vector, add, scale, subtract, to_world
from driftform.types import FloatArray, Trajectory
from driftform.util.compiled import compiled

_STATIONS = 4
"""Points of each stretch, its start among them, from which the nearest is sought."""

_COARSE = 16
"""The nearest of every so many samples is a first bound."""

_ROUNDING = 1e-9
"""m, far more than lengths along the path are rounded by."""


def world_velocity(trajectory: Trajectory) -> FloatArray:
    """Velocity over ground in the world frame, m/s, (k, 3)."""
    out = np.empty_like(trajectory.position)
    _turn(trajectory.quaternion, trajectory.velocity, out)
    return out


def hermite_coefficients(t: FloatArray, position: FloatArray, velocity: FloatArray) -> FloatArray:
    """Polynomials of the path in u = (t - t_i) / (t_{i+1} - t_i), lowest power first, (k - 1, 4, 3)."""
    h = np.diff(t)[:, None]
    p, q = position[:-1], position[1:]
    m, n = h * velocity[:-1], h * velocity[1:]
    return np.stack([p, m, 3 * (q - p) - 2 * m - n, 2 * (p - q) + m + n], axis=1)


def closest_approach(trajectory: Trajectory, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Distance (m) and time (s) at which the path comes closest to each of ``points`` (n, 3); two (n,).

    The path between samples is their cubic Hermite curve. The nearest of four stations of every stretch starts
    Newton's method for the foot of the perpendicular, on its stretch and on the one before.
    """
    distances = np.empty(len(points))
    times = np.empty(len(points))
    if len(trajectory.t) == 1:
        distances[:] = np.linalg.norm(points - trajectory.position[0], axis=1)
        times[:] = trajectory.t[0]
    else:
        velocity = world_velocity(trajectory)
        _closest(trajectory.t, trajectory.position, velocity, np.ascontiguousarray(points), distances, times)
    return distances, times


@compiled
def select_spaced(t: FloatArray, gap: float) -> npt.NDArray[np.int64]:
    """Return indices of times (k,) that are at least ``gap`` apart, among them the first and the last."""
    kept, count = np.zeros(t.shape[0], dtype=np.int64), 1
    for index in range(1, t.shape[0]):
        if t[index] - t[kept[count - 1]] >= gap:
            kept[count] = index
            count += 1
    last = t.shape[0] - 1
    if kept[count - 1] != last:
        # It takes the place of the one before, which may be too near.
        count += count == 1
        kept[count - 1] = last
    return kept[:count]


@compiled
def _turn(quaternion: FloatArray, velocity: FloatArray, out: FloatArray) -> None:
    for i in range(out.shape[0]):
        w, x, y, z = quaternion[i]
        R = rotation_from_quaternion(w, x, y, z)
        out[i, 0], out[i, 1], out[i, 2] = to_world(R, _row(velocity, i))


@compiled
def _closest(
    t: FloatArray,
    position: FloatArray,
    velocity: FloatArray,
    points: FloatArray,
    distances: FloatArray,
    times: FloatArray,
) -> None:
    stretches = t.shape[0] - 1
    gone = _gone(t, position, velocity)
    for index in range(points.shape[0]):
        point = _row(points, index)
        bound = np.inf
        for s in range(0, stretches, _COARSE):
            bound = min(bound, _distance(_row(position, s), point))
        nearest, stretch, station = np.inf, 0, 0.0
        s = 0
        while s < stretches:
            cubic = _cubic(t, position, velocity, s)
            for g in range(_STATIONS):
                distance = _distance(at(cubic, g / _STATIONS), point)
                if distance < nearest:
                    nearest, stretch, station = distance, s, g / _STATIONS
            bound = min(bound, nearest)
            # Before it has gone this far, the path cannot come nearer than the bound: those stretches are passed by.
            needed = gone[s + 1] + _distance(_row(position, s + 1), point) - bound - _ROUNDING
            s += 1
            while s < stretches and gone[s + 1] < needed:
                s += 1
        distances[index], u = foot(_cubic(t, position, velocity, stretch), point, station)
        times[index] = t[stretch] + u * (t[stretch + 1] - t[stretch])
        # The end of the path is no station, and the foot may lie on either side of the nearest station.
        for s in (stretch - 1, stretches - 1):
            if s >= 0:
                distance, u = foot(_cubic(t, position, velocity, s), point, 1.0)
                if distance < distances[index]:
                    distances[index] = distance
                    times[index] = t[s] + u * (t[s + 1] - t[s])


@compiled
def _gone(t: FloatArray, position: FloatArray, velocity: FloatArray) -> FloatArray:
    """How far the path has gone at most when it comes to each sample, m, (k,).

    A stretch is no longer than the polygon of its Bezier points p, p + h v / 3, q - h w / 3, q.
    """
    gone = np.zeros(t.shape[0])
    for i in range(t.shape[0] - 1):
        third = (t[i + 1] - t[i]) / 3
        p, q = _row(position, i), _row(position, i + 1)
        a = add(p, scale(third, _row(velocity, i)))
        b = subtract(q, scale(third, _row(velocity, i + 1)))
        gone[i + 1] = gone[i] + _distance(p, a) + _distance(a, b) + _distance(b, q)
    return gone


@compiled
def _cubic(t: FloatArray, position: FloatArray, velocity: FloatArray, s: int) -> Cubic:
    """The row ``s`` of :func:`hermite_coefficients`."""
    p, q = _row(position, s), _row(position, s + 1)
    return cubic_between(p, _row(velocity, s), q, _row(velocity, s + 1), t[s + 1] - t[s])


@compiled
def _row(array: FloatArray, i: int) -> Vector:
    return array[i, 0], array[i, 1], array[i, 2]
