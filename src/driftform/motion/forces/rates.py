"""The time derivative of all numbers that change along a flight: a state, and its inner states.

After the 13 numbers of a state (:mod:`driftform.motion.forces.state`) come the inner states: the four of gusts if there
are any, then three for each bristle of friction. The last number is the angle (rad) by which the body has turned about
its axis from the frame of the quaternion and of the rates. That frame follows the axis of a body of revolution and does
not spin about it: a body that rolls along a wall turns many times faster about its axis than its axis turns, and then
only this angle changes that fast, on which nothing depends.
"""

import math

import numpy as np

from driftform.motion.forces.equations import accelerations
from driftform.motion.forces.model import FlightModel
from driftform.motion.forces.state import STATE
from driftform.types import FloatArray
from driftform.util.compiled import compiled
from driftform.util.rotations import quaternion_product, quaternion_rate, rotation_from_quaternion


@compiled
def count_numbers(model: FlightModel) -> int:
    """Return how many numbers change along a flight of a model."""
    return STATE + count_inner(model) + 1


@compiled
def count_inner(model: FlightModel) -> int:
    """Return how many inner states a model has: of gusts, and then of bristles."""
    return int(model.eddies.size // 2 + 3 * (model.bristles.shape[0] // 2))


@compiled
def first_bristle(model: FlightModel) -> int:
    """Return the place of the first bristle among the numbers of a flight: they decay with the frequency of the contact."""
    return STATE + model.eddies.size // 2


@compiled
def set_inner(y: FloatArray, first: int, count: int, model: FlightModel) -> None:
    """Set the first ``count`` inner states of the model to the numbers of ``y`` from the place ``first`` on."""
    gusts = model.eddies.shape[1] * (model.eddies.shape[0] // 2)
    for j in range(min(gusts, count)):
        model.eddies[0, j] = y[first + j]
    for k in range((count - gusts) // 3):
        for j in range(3):
            model.bristles[k, j] = y[first + gusts + 3 * k + j]


@compiled
def get_inner_rates(model: FlightModel, first: int, count: int, out: FloatArray) -> None:
    """Fill ``out`` from the place ``first`` on with the rates of the first ``count`` inner states of the model."""
    gusts, bristles = model.eddies.shape[1] * (model.eddies.shape[0] // 2), model.bristles.shape[0] // 2
    for j in range(min(gusts, count)):
        out[first + j] = model.eddies[1, j]
    for k in range((count - gusts) // 3):
        for j in range(3):
            out[first + gusts + 3 * k + j] = model.bristles[bristles + k, j]


@compiled
def fill_rate(t: float, y: FloatArray, model: FlightModel, out: FloatArray) -> None:
    """Fill ``out`` with the time derivative of the numbers ``y`` at the time ``t`` (s).

    ``y`` may lack the last number, the bristles, and the gusts: inner states that it lacks are as the model has them, and
    without the last number the frame spins with the body.
    """
    p, q, r = y[10], y[11], y[12]
    R = rotation_from_quaternion(y[3], y[4], y[5], y[6])
    gusts = model.eddies.size // 2
    angles = (y.shape[0] - STATE - gusts) % 3 if y.shape[0] > STATE else 0
    inner = y.shape[0] - STATE - angles
    set_inner(y, STATE, inner, model)
    a, alpha = accelerations(t, (y[0], y[1], y[2]), R, (y[7], y[8], y[9]), (p, q, r), model)
    out[0], out[1], out[2] = y[7], y[8], y[9]
    out[7], out[8], out[9] = a
    out[10], out[11], out[12] = alpha
    get_inner_rates(model, STATE, inner, out)
    spin = p
    if angles > 0:
        # The rates are components of a vector: in a frame that turns less, they change more.
        spin = frame_spin(p, model)
        out[11] -= r * (p - spin)
        out[12] += q * (p - spin)
        out[y.shape[0] - 1] = p - spin
    out[3], out[4], out[5], out[6] = quaternion_rate(y[3], y[4], y[5], y[6], spin, q, r)


@compiled
def frame_spin(p: float, model: FlightModel) -> float:
    """Return the rate (rad/s) at which the frame of a flight's numbers spins about the axis of a body that spins at ``p``."""
    return float(p * (1.0 - model.numbers[0].is_axisymmetric))


def compute_rate(t: float, state: FloatArray, model: FlightModel) -> FloatArray:
    """Return the time derivative of a state, (13,), or (17,) in gusts.

    Args:
        t: time since the release, s.
        state: position (m), quaternion, velocity (m/s) and angular velocity (rad/s, body axes), and in gusts their
            four numbers, as :func:`driftform.motion.forces.release_state` returns it; all but the angular velocity in
            the world frame.
        model: an agent in a scenario, from :func:`driftform.motion.forces.flight_model`.
    """
    out = np.empty(len(state))
    fill_rate(t, state, model, out)
    return out


@compiled
def straighten_bristles(y: FloatArray, rate: FloatArray, model: FlightModel) -> None:
    """Set the bristles among the numbers of a flight, and their rates, to zero: clear of the wall, they straighten."""
    for j in range(first_bristle(model), y.shape[0] - 1):
        y[j], rate[j] = 0.0, 0.0


@compiled
def fill_stiff_places(model: FlightModel, places: FloatArray) -> int:
    """Fill ``places`` with those of the numbers that a touched wall makes stiff; return how many, 0 if nothing touches.

    They are the six velocities, and the bristles of the surfaces that touched at the last evaluation of the model.
    """
    if model.touches[0, 9] < 0.0:
        return 0
    for i in range(6):
        places[i] = 7 + i
    count, bristled = 6, first_bristle(model)
    if model.bristles.shape[0] > 0:
        for k in range(model.touches.shape[0]):
            if model.touches[k, 9] < 0.0:
                break
            for j in range(3):
                places[count] = bristled + 3 * model.touches[k, 9] + j
                count += 1
    return count


@compiled
def roll(row: FloatArray, angle: float) -> None:
    """Turn the frame of a raw sample (14,), of its quaternion and its rates, by ``angle`` (rad) about the body's axis."""
    c, s = math.cos(0.5 * angle), math.sin(0.5 * angle)
    row[4], row[5], row[6], row[7] = quaternion_product(row[4], row[5], row[6], row[7], c, s, 0.0, 0.0)
    c, s = math.cos(angle), math.sin(angle)
    row[12], row[13] = c * row[12] + s * row[13], c * row[13] - s * row[12]
