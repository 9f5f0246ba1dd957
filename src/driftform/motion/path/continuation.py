"""The end of a flight as the release of another one, in water that moves differently."""

import numpy as np

from driftform.motion.forces.buoyancy import buoyancy
from driftform.motion.forces.model import flight_model
from driftform.types import Agent, FloatArray, Trajectory
from driftform.util import rotations
from driftform.water import Scenario


def change_current(flown: Trajectory, agent: Agent, scenario: Scenario, change: FloatArray) -> Trajectory:
    """Return the end of a flight, after the velocity of the water has changed at once, everywhere by ``change``, m/s, world, (3,).

    It is the limit of an ever shorter acceleration of the water, which moves the body by added mass and pressure gradient
    (:mod:`driftform.motion.forces.equations`). With u = R^T change, the velocity relative to the water changes by
    M^-1 (-m u + rho V u, x_G x -m u + x_B x rho V u) in a frame that moves with it: a neutral body keeps up with the water.
    """
    model, q = flight_model(agent, scenario), flown.quaternion[-1].tolist()
    n, u = model.numbers[0], change @ rotations.matrix_from_quaternion(flown.quaternion[-1])
    displaced, cob = n["displaced_mass"], n["cob"].copy()
    if n["water_level"] < np.inf:
        height, R = float(flown.position[-1, 2]), rotations.rotation_from_quaternion(*q)
        _, volume, cob[0] = buoyancy(height, R, tuple(cob.tolist()), n["water_level"], 0.0, model.slices)
        displaced = n["density"] * volume
    weight, lift = -n["body_mass"] * u, displaced * n["has_pressure_gradient"] * u
    turning = np.cross(n["cog"], weight) + np.cross(cob, lift)
    velocity = flown.velocity[-1] + n["inverse"] @ np.concatenate([weight + lift, turning])
    velocity[:3] += u
    return Trajectory(flown.t[-1:], flown.position[-1:], flown.quaternion[-1:], velocity[None], flown.end)
