"""What a flight is like between its samples, and what moves it: attitudes, accelerations, forces."""

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from driftform.dynamics.path import hermite_coefficients, world_velocity
from driftform.dynamics.rotations import matrix_from_quaternion, quaternion_from_rotation_vector
from driftform.figures.projection import positions
from driftform.scenario import Scenario
from driftform.types import Agent, FloatArray, MassProperties, Trajectory


def even_times(duration: float, step: float) -> FloatArray:
    """Return times from 0 to ``duration``, ``step`` apart, the last one nearer, (n,); all in s.

    >>> even_times(0.5, 0.2)
    array([0. , 0.2, 0.4, 0.5])
    """
    # A thousandth of a step is no step of its own: durations are rounded too.
    return np.append(np.arange(np.ceil(duration / step - 1e-3)) * step, duration)


def attitudes(flight: Trajectory, t: FloatArray) -> FloatArray:
    """Return the quaternions at times ``t`` (s, (n,)), on the cubic turn between samples, (n, 4)."""
    return _turned(flight, t)[0]


def resampled(flight: Trajectory, rate: float) -> Trajectory:
    """Return the flight with ``rate`` samples for each second, and its very end besides.

    Positions lie on the cubic path that fitness measures, attitudes on the cubic turn between samples; velocities are
    their slopes.
    """
    if len(flight.t) == 1:
        return flight
    t = even_times(float(flight.t[-1]), 1 / rate)
    quaternion, omega = _turned(flight, t)
    i, step, u = _stretches(flight, t)
    curve = hermite_coefficients(flight.t, flight.position, world_velocity(flight))[i]
    slope = (curve[:, 1] + u * (2 * curve[:, 2] + 3 * u * curve[:, 3])) / step
    along = np.einsum("kji,kj->ki", matrix_from_quaternion(quaternion), slope)
    velocity = np.column_stack([along, omega])
    return replace(flight, t=t, position=positions(flight, t), quaternion=quaternion, velocity=velocity)


def _turned(flight: Trajectory, t: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Quaternions (n, 4) and angular velocities in the body frame (rad/s, (n, 3)) at times ``t``.

    Between two samples the rotation vector that leads on from the first is the cubic that has the angular velocities
    of both. A rotation vector a that changes with a' turns at J(a) a', J being the right Jacobian of the rotations
    (Chirikjian, Stochastic Models, Information Theory, and Lie Groups, volume 2, 2012).
    """
    if len(flight.t) == 1:
        return np.repeat(flight.quaternion, len(t), axis=0), np.repeat(flight.velocity[:, 3:], len(t), axis=0)
    i, step, u = _stretches(flight, t)
    first, omega = flight.quaternion[i], flight.velocity[:, 3:]
    gap = _product(first * [1, -1, -1, -1], flight.quaternion[i + 1])
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
    return _product(first, quaternion_from_rotation_vector(vector)), spin


def _product(p: FloatArray, q: FloatArray) -> FloatArray:
    """The quaternions p q, (n, 4)."""
    scalar = p[:, :1] * q[:, :1] - np.einsum("ki,ki->k", p[:, 1:], q[:, 1:])[:, None]
    vector = p[:, :1] * q[:, 1:] + q[:, :1] * p[:, 1:] + np.cross(p[:, 1:], q[:, 1:])
    return np.concatenate([scalar, vector], axis=1)


def _stretches(flight: Trajectory, t: FloatArray) -> tuple[npt.NDArray[np.intp], FloatArray, FloatArray]:
    """The stretch between two samples that each time lies in (n,), how long that takes (s), and the share, (n, 1)."""
    i = np.clip(np.searchsorted(flight.t, t, side="right") - 1, 0, len(flight.t) - 2)
    step = (flight.t[i + 1] - flight.t[i])[:, None]
    return i, step, (t - flight.t[i])[:, None] / step


def accelerations_along(flight: Trajectory, agent: Agent, scenario: Scenario) -> FloatArray:
    """Return what the equations of motion say at each sample, (k, 6).

    The acceleration of the body's origin in the world frame (m/s2), and that of rotation in the body frame (rad/s2).
    They are no differences of velocities, so that they are as exact as the samples, and one sample is enough.
    """
    from driftform.dynamics.equations import accelerations
    from driftform.dynamics.model import flight_model
    from driftform.dynamics.rotations import rotation_from_quaternion

    model = flight_model(agent, scenario)
    velocity = world_velocity(flight)
    found = np.empty((len(flight.t), 6))
    rows = zip(flight.t, flight.position, flight.quaternion, velocity, flight.velocity[:, 3:], strict=True)
    for k, (t, place, turned, moving, turning) in enumerate(rows):
        R = rotation_from_quaternion(*turned.tolist())
        a, alpha = accelerations(
            float(t), tuple(place.tolist()), R, tuple(moving.tolist()), tuple(turning.tolist()), model
        )
        found[k] = (*a, *alpha)
    return found


def net_wrench(flight: Trajectory, accelerations: FloatArray, mass: MassProperties) -> FloatArray:
    """Return the sum of all that acts on the body, about its centre of gravity, in body axes, (k, 6), N and N m.

    Newton's and Euler's laws: F = m a and T = I w' + w x I w, with the acceleration a of the centre of gravity. So
    weight, buoyancy, the wall's push and all forces of the water are in it, those of the added mass too.
    ``accelerations`` (k, 6) are those of :func:`accelerations_along`.
    """
    omega, alpha = flight.velocity[:, 3:], accelerations[:, 3:]
    a = acceleration_at(flight, accelerations, mass.cog)
    spin = omega @ mass.inertia.T
    return np.column_stack([mass.mass * a, alpha @ mass.inertia.T + np.cross(omega, spin)])


def acceleration_at(flight: Trajectory, accelerations: FloatArray, point: FloatArray) -> FloatArray:
    """Return the acceleration of a point of the body (m, (3,)), in body axes, m/s2, (k, 3).

    ``accelerations`` (k, 6) are those of :func:`accelerations_along`.
    """
    omega, alpha = flight.velocity[:, 3:], accelerations[:, 3:]
    R = matrix_from_quaternion(flight.quaternion)
    a = np.einsum("kji,kj->ki", R, accelerations[:, :3])
    return np.asarray(a + np.cross(alpha, point) + np.cross(omega, np.cross(omega, point)), dtype=np.float64)
