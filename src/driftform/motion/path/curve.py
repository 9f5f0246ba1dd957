"""The path between the samples of a trajectory: cubic Hermite curves through positions and velocities."""

import math

import numpy as np
import numpy.typing as npt

from driftform.motion.forces.state import position_of, velocity_of
from driftform.types import FloatArray, Trajectory
from driftform.util.compiled import compiled
from driftform.util.cubic import Cubic, cubic_between
from driftform.util.rotations import rotation_from_quaternion
from driftform.util.small_vectors import Vector, norm, scale, subtract, to_world


def world_velocity(trajectory: Trajectory) -> FloatArray:
    """Return the velocity over ground in the world frame, m/s, (k, 3)."""
    out = np.empty_like(trajectory.position)
    _rotate_to_world(trajectory.quaternion, trajectory.velocity, out)
    return out


def hermite_coefficients(t: FloatArray, position: FloatArray, velocity: FloatArray) -> FloatArray:
    """Return the polynomials of the path in u = (t - t_i) / (t_{i+1} - t_i), lowest power first, (k - 1, 4, 3)."""
    h = np.diff(t)[:, None]
    p, q = position[:-1], position[1:]
    m, n = h * velocity[:-1], h * velocity[1:]
    return np.stack([p, m, 3 * (q - p) - 2 * m - n, 2 * (p - q) + m + n], axis=1)


def locate_stretches(samples: FloatArray, times: FloatArray) -> tuple[npt.NDArray[np.intp], FloatArray, FloatArray]:
    """Return the stretch between two ``samples`` (s, (k,)) that each of ``times`` (s, (n,)) lies in.

    Returns:
        index: of the stretch, (n,).
        step: duration of the stretch, s, (n, 1).
        u: share of the stretch that lies before the time, (n, 1).
    """
    index = np.clip(np.searchsorted(samples, times, side="right") - 1, 0, len(samples) - 2)
    step = (samples[index + 1] - samples[index])[:, None]
    return index, step, (times - samples[index])[:, None] / step


def evaluate_path(t: FloatArray, position: FloatArray, velocity: FloatArray, times: FloatArray) -> FloatArray:
    """Return the points at ``times`` (n,) of the path through the samples ``t``, of which there are at least two.

    ``position`` and ``velocity`` (k, 3) are in one frame of reference; the points are in the same frame, (n, 3).
    """
    index, _, u = locate_stretches(t, times)
    curve = hermite_coefficients(t, position, velocity)
    return np.asarray(np.einsum("np,npd->nd", u ** np.arange(4), curve[index]), dtype=np.float64)


@compiled
def stretch_cubic(t: FloatArray, position: FloatArray, velocity: FloatArray, s: int) -> Cubic:
    """Return row ``s`` of :func:`hermite_coefficients`, for kernels."""
    p, q = row_vector(position, s), row_vector(position, s + 1)
    return cubic_between(p, row_vector(velocity, s), q, row_vector(velocity, s + 1), t[s + 1] - t[s])


@compiled
def sample_path(before: FloatArray, after: FloatArray) -> Cubic:
    """Return the cubic path (m, world frame) between two raw samples."""
    h = after[0] - before[0]
    return cubic_between(position_of(before), velocity_of(before), position_of(after), velocity_of(after), h)


@compiled
def bound_cubic_error(samples: FloatArray) -> float:
    """Return how far (m) the cubic path between raw samples, (k, 14), may be from a smooth motion.

    In the middle of a step of h s it is h^4 / 384 times the fourth derivative (Hairer, Norsett and Wanner, *Solving Ordinary
    Differential Equations I*, section II.6), here the smaller change of the cubics' third derivative at both its ends.
    """
    greatest, last, h, third, fourth = 0.0, 0, 0.0, (0.0, 0.0, 0.0), math.inf
    for k in range(1, samples.shape[0]):
        length = samples[k, 0] - samples[last, 0]
        # Rounding may leave a step without length.
        if length > 0.0:
            next_third = scale(6.0 / length**3, sample_path(samples[last], samples[k])[3])
            if h > 0.0:
                change = norm(subtract(next_third, third)) / (0.5 * (length + h))
                greatest = max(greatest, h**4 * min(fourth, change))
                fourth = change
            last, h, third = k, length, next_third
    if fourth < math.inf:
        greatest = max(greatest, h**4 * fourth)
    return float(greatest / 384.0)


@compiled
def row_vector(array: FloatArray, i: int) -> Vector:
    """Return the first three numbers of a row."""
    return array[i, 0], array[i, 1], array[i, 2]


@compiled
def _rotate_to_world(quaternion: FloatArray, velocity: FloatArray, out: FloatArray) -> None:
    for i in range(out.shape[0]):
        w, x, y, z = quaternion[i]
        R = rotation_from_quaternion(w, x, y, z)
        out[i, 0], out[i, 1], out[i, 2] = to_world(R, row_vector(velocity, i))
