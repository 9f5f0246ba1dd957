"""Where the agent is, and how it lies, at any time of its flight."""

from dataclasses import dataclass

import numpy as np

from driftform.dynamics.rotations import matrix_from_quaternion
from driftform.figures.projection import positions
from driftform.types import FloatArray, Trajectory


@dataclass(frozen=True, eq=False)
class Pose:
    """The ``position`` of the core's centre (world, m, (3,)) and the ``rotation``, body to world, (3, 3)."""

    position: FloatArray
    rotation: FloatArray


def frame_times(duration: float, step: float) -> FloatArray:
    """Return times from 0 to ``duration``, ``step`` apart, the last one nearer, (n,); all in s.

    >>> frame_times(0.5, 0.2)
    array([0. , 0.2, 0.4, 0.5])
    """
    # A thousandth of a step is no frame of its own: durations are rounded too.
    return np.append(np.arange(np.ceil(duration / step - 1e-3)) * step, duration)


def poses(flight: Trajectory, t: FloatArray) -> list[Pose]:
    """Return the poses at times ``t`` (s, (n,)): on the cubic path that fitness measures, and turning steadily."""
    rotations = matrix_from_quaternion(attitudes(flight, t))
    return [Pose(*pose) for pose in zip(positions(flight, t), rotations, strict=True)]


def attitudes(flight: Trajectory, t: FloatArray) -> FloatArray:
    """Return the quaternions at times ``t`` (s, (n,)), between samples on the great circle (slerp), (n, 4)."""
    if len(flight.t) == 1:
        return np.repeat(flight.quaternion, len(t), axis=0)
    i = np.clip(np.searchsorted(flight.t, t, side="right") - 1, 0, len(flight.t) - 2)
    u = ((t - flight.t[i]) / (flight.t[i + 1] - flight.t[i]))[:, None]
    p, q = flight.quaternion[i], flight.quaternion[i + 1]
    cosine = np.einsum("ij,ij->i", p, q)[:, None]
    # q and -q are one attitude: the nearer one is meant.
    q, cosine = np.where(cosine < 0, -q, q), np.minimum(np.abs(cosine), 1.0)
    angle = np.arccos(cosine)
    # np.sinc(x) is sin(pi x) / (pi x): where the angle vanishes the weights become 1 - u and u.
    weight = [share * np.sinc(share * angle / np.pi) / np.sinc(angle / np.pi) for share in (1 - u, u)]
    turned = weight[0] * p + weight[1] * q
    return np.asarray(turned / np.linalg.norm(turned, axis=1, keepdims=True), dtype=np.float64)
