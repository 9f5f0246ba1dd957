"""What water and wall do to a rigid body that another program integrates, in that program's coordinates.

The coordinates are the position of the body's origin and the rotation vector, body to world; their rates are the velocity in
the world frame and the angular velocity in the body frame. The other program knows the dry body, its weight and, without a
free surface, its buoyancy. Of the equations of motion (:mod:`driftform.motion.forces.equations`) there remain, with the body's
velocity v and the water's u and u', nu_r = (R^T (v - u), w) and its momentum (P, H) = M_A nu_r,::

    force    R [F + (M_A (R^T u' + w x R^T (v - u), 0))_1 + P x w]
    torque      T + (M_A (R^T u' + w x R^T (v - u), 0))_2 + H x w + P x R^T (v - u)

and the mass matrix diag(R, 1) M_A diag(R, 1)^T. F and T are the wrench of pressure gradient, damping, drag and the wall.
"""

import math
from dataclasses import dataclass

import numpy as np

from driftform.motion.forces.contact import is_near_wall
from driftform.motion.forces.equations import wrench_in_water
from driftform.motion.forces.fields import NUMBERS
from driftform.motion.forces.inertia import added_mass_at
from driftform.motion.forces.model import FlightModel, flight_model
from driftform.motion.forces.rates import count_inner, fill_rate, first_bristle, get_inner_rates, set_inner
from driftform.motion.forces.state import STATE, is_finite, release_state
from driftform.types import Agent, FloatArray
from driftform.util.compiled import borrow, borrow_as, borrowing, compiled
from driftform.util.rotations import rotation_from_vector, rotation_vector_from_quaternion
from driftform.util.small_vectors import ZERO, Vector, add, add_wrenches, cross, multiply, to_body, to_world
from driftform.water import Scenario
from driftform.water.gusts import STATES
from driftform.water.outlets import has_left_pipe

_borrow_numbers = borrow_as(NUMBERS)
_NUMBERS = NUMBERS.itemsize // 8
_ARRAYS = 9
"""Arrays of a model besides its numbers and fittings; a packed model begins with their lengths."""

GREATEST = 1e9
"""Acceleration (m/s2, rad/s2) of the dry body to which the forces of trial steps are limited.

A long trial step ends deep in the wall, whose force throws the body so far that the later stages of the step overflow.
Exudyn rejects a step with a large error, but gives up after one that is not finite.
"""


@dataclass(frozen=True, eq=False)
class WaterForces:
    """The forces of water and wall on a rigid body: see :mod:`driftform.motion.forces.water_forces`.

    Attributes:
        coordinates, rates: at the release, (6,): SI units and radians.
        lift: buoyancy (N, upward), if the other program must add it at the centre of buoyancy; 0 if it depends on the
            pose, and the forces contain it.
        model: of the flight.
        outer: the same without weight and dry mass, packed.
        inner_rates: room for the rates of the inner states of wall and water, (k,), which :meth:`force` fills; the
            states are all zero at the release.
        limits: greatest components of a force, (6,).
    """

    coordinates: FloatArray
    rates: FloatArray
    lift: float
    model: FlightModel
    outer: FloatArray
    inner_rates: FloatArray
    limits: FloatArray

    @classmethod
    def of(cls, agent: Agent, scenario: Scenario) -> "WaterForces":
        """Return the forces on an agent that is released in a scenario."""
        model = flight_model(agent, scenario)
        start = release_state(model, scenario)
        outer = model._replace(numbers=model.numbers.copy())
        n, is_full = outer.numbers[0], scenario.fluid.water_level is None
        inertia = np.diagonal(n["mass"]).copy()
        n["mass"], n["body_mass"] = added_mass_at(agent.coefficients, np.zeros(3)), 0.0
        # A body of no inertia, such as a massless sphere in roll, has no torque either.
        n["mass"] += np.diag(inertia == 0.0)
        lift = float(n["displaced_mass"] * n["gravity"]) if is_full else 0.0
        n["gravity"] *= not is_full
        turned = rotation_vector_from_quaternion(start[3:7])
        coordinates = np.concatenate([start[:3], turned])
        inner_rates = np.zeros(count_inner(model))
        return cls(coordinates, start[7:13], lift, model, _pack(outer), inner_rates, GREATEST * inertia)

    def force(self, t: float, coordinates: FloatArray, rates: FloatArray, inner: FloatArray) -> tuple[float, ...]:
        """Return the force (N, world frame) and the torque (N m, body frame) at a time (s), six numbers.

        ``inner`` are the inner states, (k,); the mass is that of :meth:`fill_mass`.
        """
        return _force(t, coordinates, rates, inner, self.outer, self.inner_rates, self.limits, self.model.fittings)

    def fill_mass(self, coordinates: FloatArray, mass: FloatArray) -> None:
        """Fill in the added mass for accelerations of these coordinates, (6, 6)."""
        _fill_mass(coordinates, self.outer, mass)

    def fill_sample(self, sample: FloatArray, t: float, coordinates: FloatArray, rates: FloatArray) -> bool:
        """Fill a raw sample of :mod:`driftform.motion.forces.state`, (14,), and return True while it is finite and in the pipe."""
        return _fill_sample(sample, t, coordinates, rates, self.model.pipe, self.model.fittings)

    def fill_numbers(
        self, t: float, sample: FloatArray, inner: FloatArray, numbers: FloatArray, rate: FloatArray
    ) -> None:
        """Fill the numbers of a flight and their rates, (k,) each, at a raw sample with these inner states.

        They are those of :mod:`driftform.motion.forces.rates`, in a frame that has the body's attitude and does not spin.
        """
        numbers[:STATE], numbers[STATE:-1], numbers[-1] = sample[1:], inner, 0.0
        fill_rate(t, numbers, self.model, rate)

    def straighten(self, coordinates: FloatArray, inner: FloatArray) -> None:
        """Set those inner states that are bristles of friction to zero where no surface can touch a wall."""
        bristles = first_bristle(self.model) - STATE
        if len(inner) > bristles and not is_near_wall(tuple(coordinates[:3].tolist()), self.model):
            inner[bristles:] = 0.0


@compiled
def _place(coordinates: FloatArray) -> Vector:
    return coordinates[0], coordinates[1], coordinates[2]


@compiled
def _force(
    t: float,
    coordinates: FloatArray,
    rates: FloatArray,
    inner: FloatArray,
    outer: FloatArray,
    inner_rates: FloatArray,
    limits: FloatArray,
    fittings: FloatArray | None,
) -> tuple[float, float, float, float, float, float]:
    model = _unpack(outer, fittings)
    R = rotation_from_vector(coordinates[3], coordinates[4], coordinates[5])
    velocity, omega = (rates[0], rates[1], rates[2]), (rates[3], rates[4], rates[5])
    set_inner(inner, 0, inner.shape[0], model)
    wrench, moving, change = wrench_in_water(t, _place(coordinates), R, velocity, omega, model)
    get_inner_rates(model, 0, inner.shape[0], inner_rates)
    added = model.numbers[0].mass
    P, H = multiply(added, moving, omega)
    wrench = add_wrenches(wrench, multiply(added, add(to_body(R, change), cross(omega, moving)), ZERO))
    force = to_world(R, add(wrench[0], cross(P, omega)))
    torque = add(wrench[1], add(cross(H, omega), cross(P, moving)))
    return (
        _bound(force[0], limits[0]),
        _bound(force[1], limits[1]),
        _bound(force[2], limits[2]),
        _bound(torque[0], limits[3]),
        _bound(torque[1], limits[4]),
        _bound(torque[2], limits[5]),
    )


@compiled
def _bound(value: float, most: float) -> float:
    """Return the value within +-most; NaN remains NaN."""
    if value > most:
        return most
    return -most if value < -most else value


@compiled
def _fill_mass(coordinates: FloatArray, outer: FloatArray, out: FloatArray) -> None:
    added = _unpack(outer, None).numbers[0].mass
    R = rotation_from_vector(coordinates[3], coordinates[4], coordinates[5])
    for j in range(6):
        i = j % 3
        unit = (1.0 if i == 0 else 0.0, 1.0 if i == 1 else 0.0, 1.0 if i == 2 else 0.0)
        push, turn = multiply(added, to_body(R, unit), ZERO) if j < 3 else multiply(added, ZERO, unit)
        out[0, j], out[1, j], out[2, j] = to_world(R, push)
        out[3, j], out[4, j], out[5, j] = turn


@compiled
def _fill_sample(
    sample: FloatArray,
    t: float,
    coordinates: FloatArray,
    rates: FloatArray,
    pipe: FloatArray,
    fittings: FloatArray | None,
) -> bool:
    x, y, z = coordinates[3], coordinates[4], coordinates[5]
    half = 0.5 * math.sqrt(x * x + y * y + z * z)
    scale = 0.5 * math.sin(half) / half if half > 1e-8 else 0.5
    sample[0] = t
    sample[4], sample[5], sample[6], sample[7] = math.cos(half), scale * x, scale * y, scale * z
    for i in range(3):
        sample[1 + i] = coordinates[i]
        sample[8 + i] = rates[i]
        sample[11 + i] = rates[3 + i]
    return is_finite(sample) and not has_left_pipe(_place(coordinates), pipe, fittings)


def _pack(model: FlightModel) -> FloatArray:
    """Return all arrays of a model but its fittings as one, for :func:`_unpack`.

    To hand a model over takes 1.5 us, three times as long as to evaluate its forces, of which Exudyn asks thousands of
    times in a flight.
    """
    arrays = model[1:-1]
    lengths = np.array([float(len(array)) for array in arrays])
    return np.concatenate([lengths, model.numbers.view(np.float64), *(array.ravel() for array in arrays)])


@borrowing
def _unpack(values: FloatArray, fittings: FloatArray | None) -> FlightModel:
    """Return the model that :func:`_pack` put into one array, with its fittings; its arrays share that memory."""
    surfaces = _ARRAYS + _NUMBERS
    pipe = surfaces + 7 * int(values[0])
    flow = pipe + 8 * int(values[1])
    gusts = flow + int(values[2])
    slices = gusts + 12 * int(values[3])
    strips = slices + 4 * int(values[4])
    touches = strips + 4 * int(values[5])
    bristles = touches + 10 * int(values[6])
    eddies = bristles + 3 * int(values[7])
    return FlightModel(
        _borrow_numbers(values, _ARRAYS, (1,)),
        borrow(values, surfaces, (int(values[0]), 7)),
        borrow(values, pipe, (int(values[1]), 8)),
        borrow(values, flow, (int(values[2]),)),
        borrow(values, gusts, (int(values[3]), 12)),
        borrow(values, slices, (int(values[4]), 4)),
        borrow(values, strips, (int(values[5]), 4)),
        borrow(values, touches, (int(values[6]), 10)),
        borrow(values, bristles, (int(values[7]), 3)),
        borrow(values, eddies, (int(values[8]), STATES)),
        _borrow_fittings(fittings),
    )


@borrowing
def _borrow_fittings(fittings: FloatArray | None) -> FloatArray | None:
    # numba compiles no branch for an argument that is None.
    return borrow(fittings, 0, (fittings.shape[0],)) if fittings is not None else None
