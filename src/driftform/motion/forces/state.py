"""The state of a body in flight, its release, and raw samples of it.

A state has 13 numbers: position (3) in the world frame, quaternion (4), velocity (3) in the world frame, and angular
velocity (3) in the body frame. A raw sample is a time and a state.
"""

import math

import numpy as np

from driftform.motion.forces.model import FlightModel
from driftform.types import FloatArray
from driftform.util.compiled import compiled
from driftform.util.rotations import rotation_from_quaternion
from driftform.util.small_vectors import Rotation, Vector, add
from driftform.water import Scenario
from driftform.water.outlets import has_left_pipe
from driftform.water.parts.profiles import AT_A_POINT
from driftform.water.velocity import gust_at, water_motion

STATE = 13
"""Numbers in a state."""

SAMPLE = 1 + STATE
"""Numbers in a raw sample: time, position, quaternion, velocity (world frame), angular velocity (body frame)."""


def release_state(model: FlightModel, scenario: Scenario) -> FloatArray:
    """Return the state of the agent at the release: a raw sample without its time, and in gusts their states, (13,) or (17,)."""
    x, y, z = scenario.release_position().tolist()
    given = scenario.release_velocity()
    velocity = _water_velocity((x, y, z), model) if given is None else given.tolist()
    eddies = [0.0] * (model.eddies.size // 2)
    return np.array([x, y, z, *scenario.release_quaternion(), *velocity, *scenario.release.rates, *eddies])


def _water_velocity(point: Vector, model: FlightModel) -> tuple[float, ...]:
    """Return the water's velocity (m/s, world frame) at the release."""
    if model.numbers[0]["is_steady"] == 0.0:
        mean = water_motion(point, 0.0, model.pipe, model.flow, AT_A_POINT, model.fittings)[0]
        return add(mean, gust_at(point, mean, model.pipe, model.flow, model.gusts, model.eddies, model.fittings)[0])
    # The same in uniform water, whose kernel need not be compiled then. Adding zero turns -0 into 0, as the kernel does.
    return tuple((model.numbers[0]["current"] + 0.0).tolist())


def has_left(state: FloatArray, model: FlightModel) -> bool:
    """Return whether the agent is past an outlet of the pipe, or more than a radius upstream of its inlet."""
    x, y, z = state[:3].tolist()
    return bool(has_left_pipe((x, y, z), model.pipe, model.fittings))


@compiled
def is_finite(values: FloatArray) -> bool:
    """Return True if all numbers (n,) are finite."""
    total = 0.0
    for value in values:
        total += value
    return math.isfinite(total)


@compiled
def position_of(row: FloatArray) -> Vector:
    """Return the position (m, world frame) of a raw sample."""
    return row[1], row[2], row[3]


@compiled
def velocity_of(row: FloatArray) -> Vector:
    """Return the velocity (m/s, world frame) of a raw sample."""
    return row[8], row[9], row[10]


@compiled
def rotation_of(row: FloatArray) -> Rotation:
    """Return the rotation, body to world, of a raw sample."""
    return rotation_from_quaternion(row[4], row[5], row[6], row[7])
