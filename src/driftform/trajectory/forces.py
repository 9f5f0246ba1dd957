"""What moves a body along its trajectory: accelerations and forces."""

import numpy as np

from driftform.dynamics.rotations import matrix_from_quaternion
from driftform.scenario import Scenario
from driftform.trajectory.path import world_velocity
from driftform.types import Agent, FloatArray, MassProperties, Trajectory


def accelerations_along(trajectory: Trajectory, agent: Agent, scenario: Scenario) -> FloatArray:
    """Return what the equations of motion say at each sample, (k, 6).

    The acceleration of the body's origin in the world frame (m/s2), and that of rotation in the body frame (rad/s2).
    They are no differences of velocities, so that they are as exact as the samples, and one sample is enough.
    """
    from driftform.dynamics.equations import accelerations
    from driftform.dynamics.model import flight_model
    from driftform.dynamics.rotations import rotation_from_quaternion

    model = flight_model(agent, scenario)
    velocity = world_velocity(trajectory)
    found = np.empty((len(trajectory.t), 6))
    rows = zip(
        trajectory.t,
        trajectory.position,
        trajectory.quaternion,
        velocity,
        trajectory.velocity[:, 3:],
        strict=True,
    )
    for k, (t, place, turned, moving, turning) in enumerate(rows):
        R = rotation_from_quaternion(*turned.tolist())
        a, alpha = accelerations(
            float(t), tuple(place.tolist()), R, tuple(moving.tolist()), tuple(turning.tolist()), model
        )
        found[k] = (*a, *alpha)
    return found


def net_wrench(trajectory: Trajectory, accelerations: FloatArray, mass: MassProperties) -> FloatArray:
    """Return the sum of all that acts on the body, about its centre of gravity, in body axes, (k, 6), N and N m.

    Newton's and Euler's laws: F = m a and T = I w' + w x I w, with the acceleration a of the centre of gravity. So
    weight, buoyancy, the wall's push and all forces of the water are in it, those of the added mass too.
    ``accelerations`` (k, 6) are those of :func:`accelerations_along`.
    """
    omega, alpha = trajectory.velocity[:, 3:], accelerations[:, 3:]
    a = acceleration_at(trajectory, accelerations, mass.cog)
    spin = omega @ mass.inertia.T
    return np.column_stack([mass.mass * a, alpha @ mass.inertia.T + np.cross(omega, spin)])


def acceleration_at(trajectory: Trajectory, accelerations: FloatArray, point: FloatArray) -> FloatArray:
    """Return the acceleration of a point of the body (m, (3,)), in body axes, m/s2, (k, 3).

    ``accelerations`` (k, 6) are those of :func:`accelerations_along`.
    """
    omega, alpha = trajectory.velocity[:, 3:], accelerations[:, 3:]
    R = matrix_from_quaternion(trajectory.quaternion)
    a = np.einsum("kji,kj->ki", R, accelerations[:, :3])
    return np.asarray(a + np.cross(alpha, point) + np.cross(omega, np.cross(omega, point)), dtype=np.float64)
