"""Positions and attitudes between the samples of a trajectory, and the same trajectory with other samples."""

from dataclasses import dataclass, replace

import numpy as np

from driftform.motion.path.curve import evaluate_path, hermite_coefficients, locate_stretches, world_velocity
from driftform.types import FloatArray, Trajectory
from driftform.util.rotations import matrix_from_quaternion, quaternion_from_rotation_vector


@dataclass(frozen=True, eq=False)
class Pose:
    """Position and attitude of a body: ``position`` (world, m, (3,)), ``quaternion`` (body to world, (4,))."""

    position: FloatArray
    quaternion: FloatArray


def interpolate_pose(trajectory: Trajectory, t: float) -> Pose:
    """Return the pose at time ``t`` (s), for display: the attitude is that of the nearest sample."""
    nearest = int(np.argmin(np.abs(trajectory.t - t)))
    return Pose(interpolate_positions(trajectory, np.array([t]))[0], trajectory.quaternion[nearest])


def interpolate_positions(trajectory: Trajectory, t: FloatArray) -> FloatArray:
    """Return the core's centre at times ``t`` (s, (n,)), world, m, (n, 3), on the path that fitness measures."""
    if len(trajectory.t) == 1:
        return np.repeat(trajectory.position, len(t), axis=0)
    return evaluate_path(trajectory.t, trajectory.position, world_velocity(trajectory), t)


def interpolate_attitudes(trajectory: Trajectory, t: FloatArray) -> FloatArray:
    """Return the quaternions at times ``t`` (s, (n,)), on the cubic rotation between samples, (n, 4)."""
    return interpolate_turns(trajectory, t)[0]


def interpolate_turns(trajectory: Trajectory, t: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return quaternions (n, 4) and angular velocities in the body frame (rad/s, (n, 3)) at times ``t`` (s, (n,)).

    Between two samples, the rotation vector from the first attitude is the cubic that has the angular velocities of
    both samples. A rotation vector a with the rate a' turns at J(a) a', where J is the right Jacobian of the rotations
    (Chirikjian, Stochastic Models, Information Theory, and Lie Groups, volume 2, 2012).
    """
    if len(trajectory.t) == 1:
        return np.repeat(trajectory.quaternion, len(t), axis=0), np.repeat(trajectory.velocity[:, 3:], len(t), axis=0)
    i, step, u = locate_stretches(trajectory.t, t)
    first, omega = trajectory.quaternion[i], trajectory.velocity[:, 3:]
    gap = _multiply(first * [1, -1, -1, -1], trajectory.quaternion[i + 1])
    # q and -q are one attitude: take the nearer one.
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


def even_times(duration: float, step: float) -> FloatArray:
    """Return times from 0 to ``duration`` every ``step``; the last interval may be shorter, (n,); all in s.

    >>> even_times(0.5, 0.2)
    array([0. , 0.2, 0.4, 0.5])
    """
    # A remainder of less than a thousandth of a step is rounding of the duration, not another step.
    return np.append(np.arange(np.ceil(duration / step - 1e-3)) * step, duration)


def resample(trajectory: Trajectory, rate: float) -> Trajectory:
    """Return the trajectory with ``rate`` samples per second, and a last sample at its end.

    Positions lie on the cubic path that fitness measures, attitudes on the cubic rotation between samples; velocities
    are the derivatives of both.
    """
    if len(trajectory.t) == 1:
        return trajectory
    t = even_times(float(trajectory.t[-1]), 1 / rate)
    quaternion, omega = interpolate_turns(trajectory, t)
    i, step, u = locate_stretches(trajectory.t, t)
    curve = hermite_coefficients(trajectory.t, trajectory.position, world_velocity(trajectory))[i]
    slope = (curve[:, 1] + u * (2 * curve[:, 2] + 3 * u * curve[:, 3])) / step
    along = np.einsum("kji,kj->ki", matrix_from_quaternion(quaternion), slope)
    velocity = np.column_stack([along, omega])
    return replace(
        trajectory, t=t, position=interpolate_positions(trajectory, t), quaternion=quaternion, velocity=velocity
    )


def _multiply(p: FloatArray, q: FloatArray) -> FloatArray:
    """Return the quaternions p q, (n, 4)."""
    scalar = p[:, :1] * q[:, :1] - np.einsum("ki,ki->k", p[:, 1:], q[:, 1:])[:, None]
    vector = p[:, :1] * q[:, 1:] + q[:, :1] * p[:, 1:] + np.cross(p[:, 1:], q[:, 1:])
    return np.concatenate([scalar, vector], axis=1)
