"""The time derivative of a state, in the vertical plane or in space.

In space a body of revolution is described in a frame that follows its axis and does not spin about it. A body that rolls
along a wall turns many times faster about its axis than its axis turns; in this frame only the angle of the spin
changes that fast, and nothing depends on it.
"""

import math

from driftform.motion.equations import accelerations
from driftform.motion.model import FlightModel
from driftform.motion.plane import fill_rate_in_plane
from driftform.types import FloatArray
from driftform.util.compiled import borrow, compiled
from driftform.util.rotations import quaternion_product, quaternion_rate, rotation_from_quaternion
from driftform.water.gusts import STATES

STATE = 13
"""Numbers in a state: position (3) and velocity (3) in the world, quaternion between them, body rates (3) at the end."""

PLANE_STATE = 7
"""Numbers in a state in the vertical plane."""


@compiled
def fill_rate(t: float, y: FloatArray, model: FlightModel, in_space: bool | None, out: FloatArray) -> None:
    """Fill ``out`` with the rate of a state in space, or in the plane if ``in_space`` is None.

    In the plane ``y`` holds seven numbers and one for each bristle; in space see :func:`fill_rate_in_space`.
    """
    # numba compiles no branch for an argument that is None. Motion in space takes most of the time to compile.
    if in_space is None:
        room = borrow(model.bristles, 0, (2 * (y.shape[0] - PLANE_STATE),))
        fill_rate_in_plane(y, model.numbers[0], model.surfaces, model.touches, room, out)
    else:
        fill_rate_in_space(t, y, model, out)


@compiled
def fill_rate_in_space(t: float, y: FloatArray, model: FlightModel, out: FloatArray) -> None:
    """Fill ``out`` with the time derivative of the state ``y``.

    After the 13 numbers of the state come the four of gusts if there are any, then three for each bristle; without them
    gusts and bristles are as the model has them. A last
    number is the angle (rad) by which the body has turned about its axis from the frame of the quaternion and of the
    rates: that frame then does not spin with a body of revolution.
    """
    p, q, r = y[10], y[11], y[12]
    R = rotation_from_quaternion(y[3], y[4], y[5], y[6])
    first = STATE + (STATES * (model.eddies.shape[0] // 2) if y.shape[0] > STATE else 0)
    bristles, angles = (y.shape[0] - first) // 3, (y.shape[0] - first) % 3
    for j in range(first - STATE):
        model.eddies[0, j] = y[STATE + j]
    for k in range(bristles):
        for j in range(3):
            model.bristles[k, j] = y[first + 3 * k + j]
    a, alpha = accelerations(t, (y[0], y[1], y[2]), R, (y[7], y[8], y[9]), (p, q, r), model)
    out[0], out[1], out[2] = y[7], y[8], y[9]
    out[7], out[8], out[9] = a
    out[10], out[11], out[12] = alpha
    for j in range(first - STATE):
        out[STATE + j] = model.eddies[1, j]
    for k in range(bristles):
        for j in range(3):
            out[first + 3 * k + j] = model.bristles[model.bristles.shape[0] // 2 + k, j]
    spin = p
    if angles > 0:
        # The rates are components of a vector: in a frame that turns less, they change more.
        spin = p * (1.0 - model.numbers[0].is_axisymmetric)
        out[11] -= r * (p - spin)
        out[12] += q * (p - spin)
        out[y.shape[0] - 1] = p - spin
    out[3], out[4], out[5], out[6] = quaternion_rate(y[3], y[4], y[5], y[6], spin, q, r)


@compiled
def roll(row: FloatArray, angle: float) -> None:
    """Turn the frame of a raw sample (14,), of its quaternion and its rates, by ``angle`` (rad) about the body's axis."""
    c, s = math.cos(0.5 * angle), math.sin(0.5 * angle)
    row[4], row[5], row[6], row[7] = quaternion_product(row[4], row[5], row[6], row[7], c, s, 0.0, 0.0)
    c, s = math.cos(angle), math.sin(angle)
    row[12], row[13] = c * row[12] + s * row[13], c * row[13] - s * row[12]
