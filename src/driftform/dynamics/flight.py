"""Raw samples of an integrator -> a trajectory that ends where it should, and says how far it can be trusted."""

import math

import numpy as np

from driftform.dynamics.buoyancy import buoyant_energy
from driftform.dynamics.compiled import compiled
from driftform.dynamics.contact import deepest_rim
from driftform.dynamics.flow import water
from driftform.dynamics.model import (
    BODY_MASS,
    COB,
    COG,
    CURRENT,
    DAMPED,
    DENSITY,
    DISPLACED_MASS,
    GRAVITY,
    MASS,
    REACH,
    STEADY,
    WATER_LEVEL,
    FlightModel,
    packed,
    unpacked,
)
from driftform.dynamics.path import at, cubic_between, hermite_coefficients
from driftform.dynamics.rotations import (
    matrix_from_quaternion,
    rotation_from_quaternion,
)
from driftform.dynamics.vectors import Vector, dot, minus, to_body
from driftform.scenario import Scenario
from driftform.types import End, FloatArray, Trajectory

SAMPLE = 14
"""Numbers in a raw sample: time, position, quaternion, velocity (world frame), angular velocity (body frame)."""


def release_state(model: FlightModel, scenario: Scenario) -> FloatArray:
    """Return the state of the agent as it is released: a raw sample without its time, (13,)."""
    x, y, z = scenario.release.position
    velocity: Vector | tuple[float, ...]
    match scenario.release.velocity:
        case "current":
            velocity = water((x, y, z), 0.0, model.pipe, model.flow, model.gusts)[0]
        case "rest":
            velocity = (0.0, 0.0, 0.0)
        case given:
            velocity = given
    return np.array([x, y, z, *scenario.release_quaternion(), *velocity, 0.0, 0.0, 0.0])


@compiled
def record(sample: FloatArray, t: float, pose: FloatArray, speed: FloatArray, model: FloatArray) -> bool:
    """Fill one raw sample (14,), and return whether the flight goes on: it is finite and inside the pipe.

    The arguments are those of :func:`driftform.dynamics.equations.fill_accelerations`.
    """
    x, y, z = pose[3], pose[4], pose[5]
    half = 0.5 * math.sqrt(x * x + y * y + z * z)
    scale = 0.5 * math.sin(half) / half if half > 1e-8 else 0.5
    sample[0] = t
    sample[4], sample[5], sample[6], sample[7] = math.cos(half), scale * x, scale * y, scale * z
    for i in range(3):
        sample[1 + i] = pose[i]
        sample[8 + i] = speed[i]
        sample[11 + i] = speed[3 + i]
    return is_finite(sample) and not has_left((pose[0], pose[1], pose[2]), unpacked(model).pipe)


@compiled
def is_finite(values: FloatArray) -> bool:
    """True where all of the numbers (n,) are finite."""
    total = 0.0
    for value in values:
        total += value
    return math.isfinite(total)


@compiled
def has_left(position: Vector, pipe: FloatArray) -> bool:
    """True where the body's origin is past the outlet, or more than a radius upstream of the inlet."""
    if pipe.shape[0] == 0:
        return False
    return past_outlet(position, pipe) >= 0.0 or _along(position, pipe[0]) < -pipe[0, 7]


@compiled
def past_outlet(position: Vector, pipe: FloatArray) -> float:
    """Return how far (m) the position is past the outlet, negative before it."""
    last = pipe[pipe.shape[0] - 1]
    return float(_along(position, last) - last[6])


@compiled
def _along(position: Vector, segment: FloatArray) -> float:
    off = minus(position, (segment[0], segment[1], segment[2]))
    return dot((segment[3], segment[4], segment[5]), off)


def finished_flight(
    samples: FloatArray,
    model: FlightModel,
    horizon: float,
    step_limit: int,
    error: float | None = None,
    accepted: float = np.inf,
) -> Trajectory:
    """Return the trajectory of raw samples (k, 14): all that is finite of it, cut exactly at the outlet.

    A flight that stopped before the horizon for no other reason ends as non-finite, and one whose estimated
    ``error`` (m) is more than ``accepted`` as not converged.
    """
    finite = np.isfinite(samples).all(axis=1)
    sound = len(samples) if finite.all() else int(np.argmin(finite))
    later = np.concatenate([[True], np.diff(samples[:sound, 0]) > 0])
    rows = np.ascontiguousarray(samples[:sound][later])
    end = _ending(rows, sound < len(samples), len(samples) > step_limit, model, horizon)
    if not end.failed and error is not None and not error <= accepted:
        end = End.NOT_CONVERGED
    values = packed(model)
    touched = _first_touch(rows, values)
    contact, drift = _contact_time(rows, values, touched), _energy_drift(rows, values, touched)
    if len(rows) > 1 and has_left((rows[-1, 1], rows[-1, 2], rows[-1, 3]), model.pipe):
        rows = _cut_at_outlet(rows, model.pipe)
        contact = None if contact is not None and contact > rows[-1, 0] else contact
    quaternion = rows[:, 4:8]
    R = matrix_from_quaternion(quaternion)
    velocity = np.concatenate([np.einsum("kji,kj->ki", R, rows[:, 8:11]), rows[:, 11:]], axis=1)
    return Trajectory(
        rows[:, 0],
        rows[:, 1:4],
        quaternion,
        velocity,
        end,
        contact=contact,
        energy_drift=None if np.isnan(drift) else float(drift),
        error=error,
    )


def _ending(rows: FloatArray, broken: bool, too_long: bool, model: FlightModel, horizon: float) -> End:
    position = (rows[-1, 1], rows[-1, 2], rows[-1, 3])
    if broken:
        return End.NON_FINITE
    if has_left(position, model.pipe):
        return End.OUTLET if past_outlet(position, model.pipe) >= 0 else End.INLET
    if rows[-1, 0] >= horizon * (1 - 1e-9):
        return End.HORIZON
    return End.STEP_LIMIT if too_long else End.NON_FINITE


def _cut_at_outlet(rows: FloatArray, pipe: FloatArray) -> FloatArray:
    """Replace the last sample by one on the outlet's plane, where it lies past that.

    Between the last two samples position and quaternion are cubics through values and rates at both, and the
    velocities their derivatives.
    """
    before, after = rows[-2], rows[-1]
    if past_outlet((after[1], after[2], after[3]), pipe) < 0:
        return rows
    pose = rows[-2:, 1:8].copy()
    pose[1, 3:] *= np.sign(pose[0, 3:] @ pose[1, 3:] or 1.0)
    rates = np.column_stack([rows[-2:, 8:11], _quaternion_rate(pose[:, 3:], rows[-2:, 11:])])
    curve = hermite_coefficients(rows[-2:, 0], pose, rates)[0]
    along = curve[:, :3] @ pipe[-1, 3:6]
    along[0] -= pipe[-1, :3] @ pipe[-1, 3:6] + pipe[-1, 6]
    roots = np.roots(along[::-1])
    inside = roots[(np.abs(roots.imag) < 1e-9) & (roots.real > 0) & (roots.real <= 1 + 1e-9)].real
    u, h = float(inside.min()) if inside.size else 1.0, after[0] - before[0]
    there = u ** np.arange(4) @ curve
    moving = np.array([0.0, 1.0, 2 * u, 3 * u * u]) @ curve / h
    quaternion = there[3:] / np.linalg.norm(there[3:])
    w, x, y, z = quaternion
    # 2 q* q' has the angular velocity in its vector part.
    back = np.array([[-x, w, z, -y], [-y, -z, w, x], [-z, y, -x, w]])
    spin = 2 * back @ moving[3:] / np.linalg.norm(there[3:])
    last = np.concatenate([[before[0] + u * h], there[:3], quaternion, moving[:3], spin])
    return np.vstack([rows[:-1], last])


def _quaternion_rate(quaternion: FloatArray, omega: FloatArray) -> FloatArray:
    """Return q' = q (0, omega) / 2 for quaternions (k, 4) and angular velocities in the body frame (k, 3)."""
    w, x, y, z = quaternion.T
    p, q, r = omega.T
    return 0.5 * np.column_stack(
        [-x * p - y * q - z * r, w * p + y * r - z * q, w * q + z * p - x * r, w * r + x * q - y * p]
    )


def _contact_time(rows: FloatArray, values: FloatArray, touched: int) -> float | None:
    """When (s) a wall is first touched, before the sample ``touched``; ``None`` where no sample touches."""
    if touched == len(rows):
        return None
    return float(rows[0, 0]) if touched == 0 else _touching(rows[touched - 1], rows[touched], values)


@compiled
def _first_touch(rows: FloatArray, values: FloatArray) -> int:
    """Return the first sample at which a rim touches, the number of samples where none does."""
    model = unpacked(values)
    for k in range(rows.shape[0]):
        if _depth(rows[k], model) > 0.0:
            return k
    return int(rows.shape[0])


@compiled
def _depth(row: FloatArray, model: FlightModel) -> float:
    return deepest_rim(position_of(row), _attitude(row), model.rims, model.table[REACH], model.pipe)


@compiled
def _energy_drift(rows: FloatArray, values: FloatArray, count: int) -> float:
    """Return the range of the energy over the first ``count`` samples, relative to the largest kinetic energy.

    NaN where it is not conserved: with drag, in water that has more than one velocity, and where the water carries
    the body up or down to its surface.
    """
    model = unpacked(values)
    table = model.table
    if count == 0 or table[STEADY] == 0.0 or table[DAMPED] != 0.0 or model.strips.shape[0] > 0:
        return math.nan
    if table[WATER_LEVEL] < np.inf and table[CURRENT, 2] != 0.0:
        return math.nan
    lowest, highest, largest, far = math.inf, -math.inf, 0.0, 1.0
    _, origin = energy(rows[0], model)
    for k in range(count):
        kinetic, potential = energy(rows[k], model)
        lowest = min(lowest, kinetic + (potential - origin))
        highest = max(highest, kinetic + (potential - origin))
        largest = max(largest, kinetic)
        far = max(far, abs(rows[k, 3]))
    # All the energy of a body that does not move in the water is rounding: of m g z, and of speeds below 1e-12 m/s.
    masses = table[BODY_MASS] + table[DISPLACED_MASS]
    rounding = masses * (1e-14 * table[GRAVITY] * far + 1e-24)
    return float((highest - lowest) / largest) if highest - lowest > rounding else 0.0


@compiled
def energy(row: FloatArray, model: FlightModel) -> tuple[float, float]:
    """Return kinetic and potential energy of body and water, J, in the frame that moves with the water."""
    table, R = model.table, _attitude(row)
    stream = (table[CURRENT, 0], table[CURRENT, 1], table[CURRENT, 2])
    v = to_body(R, minus(velocity_of(row), stream))
    nu = (v[0], v[1], v[2], row[11], row[12], row[13])
    kinetic = 0.0
    for i in range(6):
        for j in range(6):
            kinetic += 0.5 * nu[i] * table[MASS + i, j] * nu[j]
    height = row[3] - row[0] * stream[2]
    cog = height + dot(R[2], (table[COG, 0], table[COG, 1], table[COG, 2]))
    centre = (table[COB, 0], table[COB, 1], table[COB, 2])
    lift = -table[DISPLACED_MASS] * table[GRAVITY] * (height + dot(R[2], centre))
    if table[WATER_LEVEL] < np.inf:
        weight = table[DENSITY] * table[GRAVITY]
        lift = buoyant_energy(row[3], R, centre, table[WATER_LEVEL], weight, model.slices)
    return kinetic, table[BODY_MASS] * table[GRAVITY] * cog + lift


@compiled
def position_of(row: FloatArray) -> Vector:
    """Return the position (m, world frame) of a raw sample."""
    return row[1], row[2], row[3]


@compiled
def velocity_of(row: FloatArray) -> Vector:
    """Return the velocity (m/s, world frame) of a raw sample."""
    return row[8], row[9], row[10]


@compiled
def _attitude(row: FloatArray) -> tuple[Vector, Vector, Vector]:
    return rotation_from_quaternion(row[4], row[5], row[6], row[7])


@compiled
def _touching(before: FloatArray, after: FloatArray, values: FloatArray) -> float:
    """Return when a rim comes to touch between two samples, by bisection on the path between them."""
    model = unpacked(values)
    low, high, h = 0.0, 1.0, after[0] - before[0]
    between, sign = np.empty(SAMPLE), 1.0
    if before[4] * after[4] + before[5] * after[5] + before[6] * after[6] + before[7] * after[7] < 0.0:
        sign = -1.0
    path = cubic_between(position_of(before), velocity_of(before), position_of(after), velocity_of(after), h)
    for _ in range(40):
        u = 0.5 * (low + high)
        between[1], between[2], between[3] = at(path, u)
        for i in range(4, 8):
            between[i] = (1 - u) * before[i] + u * sign * after[i]
        if _depth(between, model) > 0.0:
            high = u
        else:
            low = u
    return float(before[0] + high * h)
