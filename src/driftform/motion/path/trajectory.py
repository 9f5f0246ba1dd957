"""From the raw samples of an integrator to a trajectory: its end, its first contact, and its drift of energy."""

import math

import numpy as np

from driftform.motion.forces.buoyancy import buoyant_energy
from driftform.motion.forces.contact import deepest_depth
from driftform.motion.forces.model import FlightModel
from driftform.motion.forces.state import SAMPLE, is_finite, position_of, rotation_of, velocity_of
from driftform.motion.path.curve import evaluate_path, sample_path
from driftform.types import End, FloatArray, Trajectory
from driftform.util.compiled import compiled
from driftform.util.cubic import cubic_between, cubic_point, cubic_slope
from driftform.util.rotations import quaternion_rate
from driftform.util.rows import copy
from driftform.util.small_vectors import dot, scale, subtract, to_body
from driftform.water.outlets import distance_past_outlet, has_left_pipe


def finish_trajectory(
    samples: FloatArray,
    model: FlightModel,
    horizon: float,
    step_limit: int,
    error: float | None = None,
    accepted: float = np.inf,
    other: FloatArray | None = None,
) -> Trajectory:
    """Return the trajectory of samples (k, 14), times and states of ``compute_rate``: the finite ones, cut at the outlet.

    The first must be finite. A flight that stopped before the ``horizon`` (s) without another reason ends as non-finite,
    one with more than ``step_limit`` steps at the step limit, and one whose estimated ``error`` (m) exceeds ``accepted`` as
    not converged: it has the samples up to where the ``other`` integration, samples (n, 14), is ``accepted`` away.
    """
    samples, k = np.ascontiguousarray(samples), len(samples)
    filled = np.empty(k), np.empty((k, 3)), np.empty((k, 4)), np.empty((k, 6))
    count, broken, left, past, touched, time = _finish(samples, model, *filled, np.empty((2, SAMPLE)))
    t, position, quaternion, velocity = (field if count == k else field[:count].copy() for field in filled)
    for field in (t, position, quaternion, velocity):
        field.setflags(write=False)
    if broken:
        end = End.NON_FINITE
    elif left and model.fittings is not None and model.fittings[0] == 1.0:
        end = End.EDGE
    elif left:
        end = End.OUTLET if past else End.INLET
    elif t[-1] >= horizon * (1 - 1e-9):
        end = End.HORIZON
    else:
        end = End.STEP_LIMIT if k > step_limit else End.NON_FINITE
    if not end.failed and error is not None and not error <= accepted:
        end = End.NOT_CONVERGED
        if other is not None:
            count = _count_agreeing(samples[: len(t)], other, accepted)
            t, position, quaternion, velocity = t[:count], position[:count], quaternion[:count], velocity[:count]
    # What touches after the outlet does not count.
    contact = time if time < math.inf and time <= t[-1] else None
    n, drift = model.numbers[0], None
    # Energy is conserved without drag, in water that is uniform and steady and does not carry the body to or from its surface.
    rises = n["water_level"] < np.inf and n["current"][2] != 0.0
    if touched and n["is_steady"] != 0.0 and n["is_damped"] == 0.0 and len(model.strips) == 0 and not rises:
        drift = _energy_drift(samples, model, touched)
    return Trajectory(t, position, quaternion, velocity, end, contact=contact, energy_drift=drift, error=error)


def _count_agreeing(samples: FloatArray, other: FloatArray, accepted: float) -> int:
    """Return how many of the first raw samples are less than ``accepted`` (m) from another flight; at least one."""
    other = other[np.isfinite(other).all(axis=1)]
    if len(other) < 2:
        return 1
    there = evaluate_path(other[:, 0], other[:, 1:4], other[:, 8:11], samples[:, 0])
    near = np.linalg.norm(samples[:, 1:4] - there, axis=1) <= accepted
    agrees = np.logical_and.accumulate(near & (samples[:, 0] <= other[-1, 0]))
    return max(1, int(agrees.sum()))


@compiled
def _finish(
    samples: FloatArray,
    model: FlightModel,
    t: FloatArray,
    position: FloatArray,
    quaternion: FloatArray,
    velocity: FloatArray,
    room: FloatArray,
) -> tuple[int, bool, bool, bool, int, float]:
    """Fill in the fields of a trajectory from its raw samples, and return what else follows from them.

    The fields are filled with the samples before the first that is not finite, in strictly ascending order, cut at the
    outlet. The result is how many samples these are; whether one is not finite, whether the flight has left the pipe,
    and whether by an outlet; then that of :func:`_find_contact`. ``room`` is (2, 14).
    """
    after, between = room[0], room[1]
    count, before, last, broken = 0, 0, 0, False
    for k in range(samples.shape[0]):
        if not is_finite(samples[k]):
            broken = True
            break
        if count == 0 or samples[k, 0] > samples[last, 0]:
            _fill_fields(samples[k], count, t, position, quaternion, velocity)
            count, before, last = count + 1, last, k
    end = position_of(samples[last])
    left = has_left_pipe(end, model.pipe, model.fittings)
    past = left and distance_past_outlet(end, model.pipe, model.fittings) >= 0.0
    touched, time = _find_contact(samples[: last + 1 if count > 0 else 0], model, between)
    if count > 1 and (model.pipe.shape[0] > 0 or model.fittings is not None):
        copy(samples[last], after)
        _cut_at_outlet(samples[before], after, model.pipe, model.fittings, between)
        _fill_fields(after, count - 1, t, position, quaternion, velocity)
    return count, broken, left, past, touched, time


@compiled
def _fill_fields(
    row: FloatArray, k: int, t: FloatArray, position: FloatArray, quaternion: FloatArray, velocity: FloatArray
) -> None:
    """Fill the ``k``-th sample of a trajectory from a raw one, (14,)."""
    t[k] = row[0]
    for j in range(3):
        position[k, j] = row[1 + j]
    for j in range(4):
        quaternion[k, j] = row[4 + j]
    velocity[k, 0], velocity[k, 1], velocity[k, 2] = to_body(rotation_of(row), velocity_of(row))
    for j in range(3):
        velocity[k, 3 + j] = row[11 + j]


@compiled
def _cut_at_outlet(
    before: FloatArray, after: FloatArray, pipe: FloatArray, fittings: FloatArray | None, room: FloatArray
) -> None:
    """Move the sample ``after`` back to the outlet's plane if it lies past that plane and ``before`` does not.

    Between the two, position and quaternion are cubics through the values and rates of both, and the velocities are
    their derivatives.
    """
    if (
        distance_past_outlet(position_of(after), pipe, fittings) < 0.0
        or distance_past_outlet(position_of(before), pipe, fittings) >= 0.0
    ):
        return
    h, path = after[0] - before[0], sample_path(before, after)
    low, u = 0.0, 1.0
    for _ in range(60):
        middle = 0.5 * (low + u)
        if distance_past_outlet(cubic_point(path, middle), pipe, fittings) < 0.0:
            low = middle
        else:
            u = middle
    start, end = _quaternion_rate(before), _quaternion_rate(after)
    square, sign = 0.0, 0.0
    for j in range(4, 8):
        sign += before[j] * after[j]
    sign = 1.0 if sign >= 0.0 else -1.0
    q, rate = room[:4], room[4:8]
    for j in range(4):
        p, v = (before[4 + j], 0.0, 0.0), (start[j], 0.0, 0.0)
        curve = cubic_between(p, v, (sign * after[4 + j], 0.0, 0.0), (sign * end[j], 0.0, 0.0), h)
        q[j], rate[j] = cubic_point(curve, u)[0], cubic_slope(curve, u)[0] / h
        square += q[j] * q[j]
    after[0] = before[0] + u * h
    after[1], after[2], after[3] = cubic_point(path, u)
    after[8], after[9], after[10] = scale(1.0 / h, cubic_slope(path, u))
    for j in range(4):
        after[4 + j] = q[j] / math.sqrt(square)
    # The angular velocity is the vector part of 2 q* q'.
    after[11] = 2.0 * (q[0] * rate[1] - q[1] * rate[0] + q[3] * rate[2] - q[2] * rate[3]) / square
    after[12] = 2.0 * (q[0] * rate[2] - q[2] * rate[0] + q[1] * rate[3] - q[3] * rate[1]) / square
    after[13] = 2.0 * (q[0] * rate[3] - q[3] * rate[0] + q[2] * rate[1] - q[1] * rate[2]) / square


@compiled
def _quaternion_rate(row: FloatArray) -> tuple[float, float, float, float]:
    return quaternion_rate(row[4], row[5], row[6], row[7], row[11], row[12], row[13])


@compiled
def _find_contact(rows: FloatArray, model: FlightModel, room: FloatArray) -> tuple[int, float]:
    """Return the first sample at which a surface touches, and the time (s) of the contact; the number of samples without one."""
    for k in range(rows.shape[0]):
        if _contact_depth(rows[k], model) > 0.0:
            return k, rows[0, 0] if k == 0 else _locate_contact(rows[k - 1], rows[k], model, room)
    return rows.shape[0], math.inf


@compiled
def _contact_depth(row: FloatArray, model: FlightModel) -> float:
    return deepest_depth(position_of(row), rotation_of(row), model)


@compiled
def has_touched(samples: FloatArray, model: FlightModel) -> bool:
    """Return True if a surface touches the wall at one of the raw samples, (k, 14)."""
    touched = False
    for k in range(samples.shape[0]):
        touched = touched or _contact_depth(samples[k], model) > 0.0
    return touched


@compiled
def _energy_drift(rows: FloatArray, model: FlightModel, count: int) -> float:
    """Return the range of the energy over the first ``count`` samples, relative to the largest kinetic energy."""
    n = model.numbers[0]
    lowest, highest, largest, far = math.inf, -math.inf, 0.0, 1.0
    _, origin = energies(rows[0], model)
    for k in range(count):
        kinetic, potential = energies(rows[k], model)
        lowest = min(lowest, kinetic + (potential - origin))
        highest = max(highest, kinetic + (potential - origin))
        largest = max(largest, kinetic)
        far = max(far, abs(rows[k, 3]))
    # The energy of a body that does not move in the water is rounding only: of m g z, and of speeds below 1e-12 m/s.
    masses = n.body_mass + n.displaced_mass
    rounding = masses * (1e-14 * n.gravity * far + 1e-24)
    return float((highest - lowest) / largest) if highest - lowest > rounding else 0.0


@compiled
def energies(row: FloatArray, model: FlightModel) -> tuple[float, float]:
    """Return the kinetic and the potential energy of body and water, J, in the frame that moves with the water."""
    n, R = model.numbers[0], rotation_of(row)
    stream = (n.current[0], n.current[1], n.current[2])
    v = to_body(R, subtract(velocity_of(row), stream))
    nu = (v[0], v[1], v[2], row[11], row[12], row[13])
    kinetic = 0.0
    for i in range(6):
        for j in range(6):
            kinetic += 0.5 * nu[i] * n.mass[i, j] * nu[j]
    height = row[3] - row[0] * stream[2]
    cog = height + dot(R[2], (n.cog[0], n.cog[1], n.cog[2]))
    centre = (n.cob[0], n.cob[1], n.cob[2])
    lift = -n.displaced_mass * n.gravity * (height + dot(R[2], centre))
    if n.water_level < np.inf:
        weight = n.density * n.gravity
        lift = buoyant_energy(row[3], R, centre, n.water_level, weight, model.slices)
    return kinetic, n.body_mass * n.gravity * cog + lift


@compiled
def _locate_contact(before: FloatArray, after: FloatArray, model: FlightModel, between: FloatArray) -> float:
    """Return the time (s) between two samples at which a surface first touches, by bisection on the path between them."""
    low, high, h, sign = 0.0, 1.0, after[0] - before[0], 1.0
    if before[4] * after[4] + before[5] * after[5] + before[6] * after[6] + before[7] * after[7] < 0.0:
        sign = -1.0
    path = sample_path(before, after)
    for _ in range(40):
        u = 0.5 * (low + high)
        between[1], between[2], between[3] = cubic_point(path, u)
        for i in range(4, 8):
            between[i] = (1 - u) * before[i] + u * sign * after[i]
        if _contact_depth(between, model) > 0.0:
            high = u
        else:
            low = u
    return float(before[0] + high * h)
