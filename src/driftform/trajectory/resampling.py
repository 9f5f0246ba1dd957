"""A trajectory with other samples: at a given rate, or thinned."""

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from driftform.dynamics.rotations import matrix_from_quaternion
from driftform.errors import InputError
from driftform.trajectory.interpolation import interpolate_positions, interpolate_turns
from driftform.trajectory.path import hermite_coefficients, locate_stretches, world_velocity
from driftform.types import FloatArray, Trajectory
from driftform.util.compiled import allocating

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
        trajectory,
        t=t,
        position=interpolate_positions(trajectory, t),
        quaternion=quaternion,
        velocity=velocity,
    )


@allocating
def select_spaced(t: FloatArray, gap: float) -> npt.NDArray[np.int64]:
    """Return indices of times (k,) that are at least ``gap`` apart, always with the first and the last time.

    The times are ascending; only where they last less than ``gap`` in all are the first and the last closer.
    """
    kept, count = np.zeros(t.shape[0], dtype=np.int64), 1
    for index in range(1, t.shape[0]):
        if t[index] - t[kept[count - 1]] >= gap:
            kept[count] = index
            count += 1
    last = t.shape[0] - 1
    if kept[count - 1] != last:
        # The last time replaces the one before, which may be too near to it.
        count += count == 1
        kept[count - 1] = last
    return kept[:count]


def byte_planes(
    t: FloatArray, position: FloatArray, quaternion: FloatArray, velocity: FloatArray, gap: float
) -> npt.NDArray[np.uint8]:
    """Return the samples that are at least ``gap`` (s) apart, in single precision: their n-th lowest bytes in row n.

    A row has the bytes of t, then those of each column of position, quaternion and velocity, (4, 14 k).
    """
    samples = np.vstack([t, position.T, quaternion.T, velocity.T])
    with np.errstate(over="ignore"):
        # Thin by the rounded times, so that a trajectory that was thinned before keeps all its samples.
        kept = select_spaced(samples[0].astype(np.float32).astype(float), gap)
        values = np.ascontiguousarray(samples[:, kept], "<f4")
    return np.ascontiguousarray(values.view(np.uint8).reshape(-1, 4).T)
