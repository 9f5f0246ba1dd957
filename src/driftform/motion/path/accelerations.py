"""Accelerations and forces along a trajectory."""

import numpy as np

from driftform.motion.path.curve import world_velocity
from driftform.types import Agent, FloatArray, MassProperties, Trajectory
from driftform.util.rotations import matrix_from_quaternion
from driftform.water import Scenario


def accelerations_along(trajectory: Trajectory, agent: Agent, scenario: Scenario) -> FloatArray:
    """Return the accelerations that the equations of motion give at each sample, (k, 6).

    The linear acceleration of the body's origin is in the world frame (m/s2), the angular acceleration in the body frame
    (rad/s2). They are not differences of velocities: they are as exact as the samples, and one sample is enough. Where the
    body touches a wall with friction, they are differences: the samples do not hold how far friction's bristles are bent.
    """
    from driftform.motion.forces.contact import deepest_depth
    from driftform.motion.forces.equations import accelerations
    from driftform.motion.forces.model import flight_model
    from driftform.util.rotations import rotation_from_quaternion

    model = flight_model(agent, scenario)
    velocity = world_velocity(trajectory)
    out, touching = np.empty((len(trajectory.t), 6)), np.zeros(len(trajectory.t), dtype=bool)
    rows = zip(
        trajectory.t, trajectory.position, trajectory.quaternion, velocity, trajectory.velocity[:, 3:], strict=True
    )
    for k, (t, position, quaternion, v, omega) in enumerate(rows):
        R = rotation_from_quaternion(*quaternion.tolist())
        a, alpha = accelerations(float(t), tuple(position.tolist()), R, tuple(v.tolist()), tuple(omega.tolist()), model)
        out[k] = (*a, *alpha)
        touching[k] = len(model.bristles) > 0 and deepest_depth(tuple(position.tolist()), R, model) > 0.0
    if touching.any() and len(touching) > 1:
        rates = np.column_stack([velocity, trajectory.velocity[:, 3:]])
        out[touching] = np.gradient(rates, trajectory.t, axis=0)[touching]
    return out


def net_wrench(trajectory: Trajectory, accelerations: FloatArray, mass: MassProperties) -> FloatArray:
    """Return the net force (N) and torque (N m) on the body about its centre of gravity, in body axes, (k, 6).

    Newton's and Euler's laws: F = m a and T = I w' + w x I w, where a is the acceleration of the centre of gravity. The
    sum includes weight, buoyancy, the contact force of the wall and all forces of the water, also of the added mass.
    ``accelerations`` (k, 6) are those of :func:`accelerations_along`.
    """
    omega, alpha = trajectory.velocity[:, 3:], accelerations[:, 3:]
    a = acceleration_at(trajectory, accelerations, mass.cog)
    spin = omega @ mass.inertia.T
    return np.column_stack([mass.mass * a, alpha @ mass.inertia.T + np.cross(omega, spin)])


def acceleration_at(trajectory: Trajectory, accelerations: FloatArray, point: FloatArray) -> FloatArray:
    """Return the acceleration (m/s2, (k, 3)) of a ``point`` of the body (m, (3,)), both in body axes.

    ``accelerations`` (k, 6) are those of :func:`accelerations_along`.
    """
    omega, alpha = trajectory.velocity[:, 3:], accelerations[:, 3:]
    R = matrix_from_quaternion(trajectory.quaternion)
    a = np.einsum("kji,kj->ki", R, accelerations[:, :3])
    return np.asarray(a + np.cross(alpha, point) + np.cross(omega, np.cross(omega, point)), dtype=np.float64)
