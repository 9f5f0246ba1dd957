"""What a flight is like between its samples, and what moves it: attitudes, accelerations, forces."""

from dataclasses import replace

import numpy as np

from driftform.dynamics.rotations import matrix_from_quaternion
from driftform.errors import InputError
from driftform.trajectory.interpolation import interpolate_positions, interpolate_turns, locate_stretches
from driftform.trajectory.path import hermite_coefficients, world_velocity
from driftform.types import FloatArray, Trajectory

MAX_RATE_HZ = 10_000.0
"""Highest rate of samples, 1/s: a flight of 20 s then has two hundred thousand of them."""


def check_rate(rate_hz: float) -> None:
    """Refuse a rate of samples (1/s) that is out of range; 0 stands for the samples of the simulator.

    Raises
    ------
    InputError
        with the range.
    """
    if not 0 <= rate_hz <= MAX_RATE_HZ:
        raise InputError(f"--rate-hz {rate_hz:g}: should be from 0 to {MAX_RATE_HZ:g}")


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
