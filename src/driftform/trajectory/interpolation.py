"""Where a body is between the samples of its trajectory."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from driftform.dynamics.rotations import quaternion_from_rotation_vector
from driftform.trajectory.path import closest_approach, hermite_coefficients, world_velocity
from driftform.types import FloatArray, Trajectory


@dataclass(frozen=True, eq=False)
class Approach:
    """Where a flight is closest to a point: ``distance`` (m), ``t`` (s), ``position`` (world, m, (3,))."""

    distance: float
    t: float
    position: FloatArray


def interpolate_positions(trajectory: Trajectory, t: FloatArray) -> FloatArray:
    """Return the core's centre at times ``t`` (n,), world, m, (n, 3), on the path that fitness measures."""
    if len(trajectory.t) == 1:
        return np.repeat(trajectory.position, len(t), axis=0)
    curve = hermite_coefficients(trajectory.t, trajectory.position, world_velocity(trajectory))
    i = np.clip(np.searchsorted(trajectory.t, t, side="right") - 1, 0, len(curve) - 1)
    u = (t - trajectory.t[i]) / (trajectory.t[i + 1] - trajectory.t[i])
    return np.asarray(np.einsum("np,npd->nd", u[:, None] ** np.arange(4), curve[i]), dtype=np.float64)


def find_approaches(trajectory: Trajectory, points: FloatArray) -> list[Approach]:
    """Return the closest approach to each of ``points``, world frame, m, (n, 3)."""
    distances, times = closest_approach(trajectory, points)
    places = interpolate_positions(trajectory, times)
    return [Approach(float(d), float(t), p) for d, t, p in zip(distances, times, places, strict=True)]


@dataclass(frozen=True, eq=False)
class Pose:
    """Where and how a body lies: ``position`` (world, m, (3,)), ``quaternion`` (body to world, (4,))."""

    position: FloatArray
    quaternion: FloatArray


def interpolate_pose(trajectory: Trajectory, t: float) -> Pose:
    """Return the pose at time ``t`` (s); the attitude is the nearest sample's: it is shown, not measured."""
    nearest = int(np.argmin(np.abs(trajectory.t - t)))
    return Pose(interpolate_positions(trajectory, np.array([t]))[0], trajectory.quaternion[nearest])


def interpolate_attitudes(trajectory: Trajectory, t: FloatArray) -> FloatArray:
    """Return the quaternions at times ``t`` (s, (n,)), on the cubic turn between samples, (n, 4)."""
    return interpolate_turns(trajectory, t)[0]


def interpolate_turns(trajectory: Trajectory, t: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Quaternions (n, 4) and angular velocities in the body frame (rad/s, (n, 3)) at times ``t``.

    Between two samples the rotation vector that leads on from the first is the cubic that has the angular velocities
    of both. A rotation vector a that changes with a' turns at J(a) a', J being the right Jacobian of the rotations
    (Chirikjian, Stochastic Models, Information Theory, and Lie Groups, volume 2, 2012).
    """
    if len(trajectory.t) == 1:
        return np.repeat(trajectory.quaternion, len(t), axis=0), np.repeat(
            trajectory.velocity[:, 3:], len(t), axis=0
        )
    i, step, u = locate_stretches(trajectory, t)
    first, omega = trajectory.quaternion[i], trajectory.velocity[:, 3:]
    gap = _multiply(first * [1, -1, -1, -1], trajectory.quaternion[i + 1])
    # q and -q are one attitude: the nearer one is meant.
    gap = np.where(gap[:, :1] < 0, -gap, gap)
    sine = np.linalg.norm(gap[:, 1:], axis=1, keepdims=True)
    half = np.arctan2(sine, gap[:, :1])
    turn = 2 * gap[:, 1:] / np.sinc(half / np.pi)
    # The inverse of J: a' = w + a x w / 2 + c a x (a x w), with c -> 1 / 12.
    square = np.maximum(4 * half**2, 1e-8)
    c = (1 - np.maximum(half, 5e-5) / np.tan(np.maximum(half, 5e-5))) / square
    start, end = step * omega[i], step * omega[i + 1]
    across = np.cross(turn, end)
    end = end + across / 2 + c * np.cross(turn, across)
    b, d = 3 * turn - 2 * start - end, start + end - 2 * turn
    vector = u * (start + u * (b + u * d))
    slope = (start + u * (2 * b + 3 * u * d)) / step
    angle = np.maximum(np.linalg.norm(vector, axis=1, keepdims=True), 1e-4)
    across = np.cross(vector, slope)
    spin = slope - (1 - np.cos(angle)) / angle**2 * across
    spin = spin + (angle - np.sin(angle)) / angle**3 * np.cross(vector, across)
    return _multiply(first, quaternion_from_rotation_vector(vector)), spin


def _multiply(p: FloatArray, q: FloatArray) -> FloatArray:
    """The quaternions p q, (n, 4)."""
    scalar = p[:, :1] * q[:, :1] - np.einsum("ki,ki->k", p[:, 1:], q[:, 1:])[:, None]
    vector = p[:, :1] * q[:, 1:] + q[:, :1] * p[:, 1:] + np.cross(p[:, 1:], q[:, 1:])
    return np.concatenate([scalar, vector], axis=1)


def locate_stretches(
    trajectory: Trajectory, t: FloatArray
) -> tuple[npt.NDArray[np.intp], FloatArray, FloatArray]:
    """The stretch between two samples that each time lies in (n,), how long that takes (s), and the share, (n, 1)."""
    i = np.clip(np.searchsorted(trajectory.t, t, side="right") - 1, 0, len(trajectory.t) - 2)
    step = (trajectory.t[i + 1] - trajectory.t[i])[:, None]
    return i, step, (t - trajectory.t[i])[:, None] / step
