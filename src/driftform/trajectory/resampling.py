"""What a flight is like between its samples, and what moves it: attitudes, accelerations, forces."""

from dataclasses import replace

import numpy as np

from driftform.dynamics.rotations import matrix_from_quaternion
from driftform.trajectory.interpolation import interpolate_positions, interpolate_turns, locate_stretches
from driftform.trajectory.path import hermite_coefficients, world_velocity
from driftform.types import FloatArray, Trajectory


def even_times(duration: float, step: float) -> FloatArray:
    """Return times from 0 to ``duration``, ``step`` apart, the last one nearer, (n,); all in s.

    >>> even_times(0.5, 0.2)
    array([0. , 0.2, 0.4, 0.5])
    """
    # A thousandth of a step is no step of its own: durations are rounded too.
    return np.append(np.arange(np.ceil(duration / step - 1e-3)) * step, duration)


def resample(trajectory: Trajectory, rate: float) -> Trajectory:
    """Return the flight with ``rate`` samples for each second, and its very end besides.

    Positions lie on the cubic path that fitness measures, attitudes on the cubic turn between samples; velocities are
    their slopes.
    """
    if len(trajectory.t) == 1:
        return trajectory
    t = even_times(float(trajectory.t[-1]), 1 / rate)
    quaternion, omega = interpolate_turns(trajectory, t)
    i, step, u = locate_stretches(trajectory, t)
    curve = hermite_coefficients(trajectory.t, trajectory.position, world_velocity(trajectory))[i]
    slope = (curve[:, 1] + u * (2 * curve[:, 2] + 3 * u * curve[:, 3])) / step
    along = np.einsum("kji,kj->ki", matrix_from_quaternion(quaternion), slope)
    velocity = np.column_stack([along, omega])
    return replace(
        trajectory,
        t=t,
        position=interpolate_positions(trajectory, t),
        quaternion=quaternion,
        velocity=velocity,
    )
