"""What a simulator with an integrator of its own needs, from the model of a flight to its trajectory."""

import numpy as np

from driftform.motion.buoyancy import buoyancy
from driftform.motion.coordinates import WaterForces
from driftform.motion.flight import finish_trajectory, has_left_pipe, release_state
from driftform.motion.model import FlightModel, flight_model
from driftform.motion.rates import fill_rate_in_space
from driftform.types import Agent, FloatArray, Trajectory
from driftform.util import rotations
from driftform.water import Scenario

__all__ = [
    "FlightModel", "WaterForces", "change_current", "compute_rate", "finish_trajectory", "flight_model",
    "has_left", "release_state",
]  # fmt: skip


def compute_rate(t: float, state: FloatArray, model: FlightModel) -> FloatArray:
    """Return the time derivative of a state, (13,), or (17,) in gusts.

    Args:
        t: time since the release, s.
        state: position (m), quaternion, velocity (m/s) and angular velocity (rad/s, body axes), and in gusts their
            four numbers, as :func:`release_state` returns it; all but the angular velocity in the
            world frame.
        model: an agent in a scenario, from :func:`flight_model`.
    """
    out = np.empty(len(state))
    fill_rate_in_space(t, state, model, out)
    return out


def change_current(flown: Trajectory, agent: Agent, scenario: Scenario, change: FloatArray) -> Trajectory:
    """Return the end of a flight, after the velocity of the water has changed at once, everywhere by ``change``, m/s, world, (3,).

    It is the limit of an ever shorter acceleration of the water, which moves the body by added mass and pressure gradient
    (:mod:`driftform.motion.equations`). With u = R^T change, the velocity relative to the water changes by
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


def has_left(state: FloatArray, model: FlightModel) -> bool:
    """Return whether the agent is past an outlet of the pipe, or more than a radius upstream of its inlet."""
    x, y, z = state[:3].tolist()
    return bool(has_left_pipe((x, y, z), model.pipe, model.fittings))
