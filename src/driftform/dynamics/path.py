"""The path between the samples of a trajectory: cubic Hermite curves through positions and velocities."""

import numpy as np

from driftform.dynamics.compiled import compiled
from driftform.dynamics.rotations import matrix_from_quaternion
from driftform.types import FloatArray, Trajectory

_STATIONS = 4


def world_velocity(trajectory: Trajectory) -> FloatArray:
    """Velocity over ground in the world frame, m/s, (k, 3)."""
    R = matrix_from_quaternion(trajectory.quaternion)
    return np.asarray(np.einsum("kij,kj->ki", R, trajectory.velocity[:, :3]), dtype=np.float64)


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
        curve = hermite_coefficients(trajectory.t, trajectory.position, world_velocity(trajectory))
        _closest(trajectory.t, curve, np.ascontiguousarray(points), distances, times)
    return distances, times


@compiled
def _closest(
    t: FloatArray, curve: FloatArray, points: FloatArray, distances: FloatArray, times: FloatArray
) -> None:
    for index in range(points.shape[0]):
        point = points[index]
        nearest, stretch, station = np.inf, 0, 0.0
        for s in range(curve.shape[0]):
            for g in range(_STATIONS):
                u = g / _STATIONS
                square = _square(curve[s], point, u)
                if square < nearest:
                    nearest, stretch, station = square, s, u
        distances[index], u = _foot(curve[stretch], point, station)
        times[index] = t[stretch] + u * (t[stretch + 1] - t[stretch])
        # The end of the path is no station, and the foot may lie on either side of the nearest station.
        for s, start in ((stretch - 1, 1.0), (curve.shape[0] - 1, 1.0)):
            if s >= 0:
                distance, u = _foot(curve[s], point, start)
                if distance < distances[index]:
                    distances[index] = distance
                    times[index] = t[s] + u * (t[s + 1] - t[s])


@compiled
def _square(curve: FloatArray, point: FloatArray, u: float) -> float:
    total = 0.0
    for i in range(3):
        total += (curve[0, i] + u * (curve[1, i] + u * (curve[2, i] + u * curve[3, i])) - point[i]) ** 2
    return total


@compiled
def _foot(curve: FloatArray, point: FloatArray, u: float) -> tuple[float, float]:
    best, best_u = _square(curve, point, u), u
    for _ in range(20):
        slope = curvature = speed = 0.0
        for i in range(3):
            p = curve[0, i] + u * (curve[1, i] + u * (curve[2, i] + u * curve[3, i])) - point[i]
            v = curve[1, i] + u * (2 * curve[2, i] + u * 3 * curve[3, i])
            w = 2 * curve[2, i] + 6 * u * curve[3, i]
            slope += p * v
            curvature += v * v + p * w
            speed += v * v
        if curvature <= 0.0:
            # Where the distance is not convex Newton's step would climb: step as if the path were straight.
            curvature = speed
        if curvature == 0.0:
            break
        new = min(1.0, max(0.0, u - slope / curvature))
        square = _square(curve, point, new)
        if square < best:
            best, best_u = square, new
        if abs(new - u) < 1e-12:
            break
        u = new
    return np.sqrt(best), best_u
