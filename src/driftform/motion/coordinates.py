"""Motion in coordinates, their rates and accelerations, for integrators that need this form, such as Exudyn's.

The coordinates are the position and the rotation vector, body to world; their rates are the velocity in the
world frame and the angular velocity in the body frame.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from driftform.motion.contact import is_far_from_wall
from driftform.motion.equations import accelerations
from driftform.motion.flight import has_left_pipe, is_finite
from driftform.motion.model import FlightModel, pack, unpack
from driftform.types import FloatArray
from driftform.util.compiled import compiled
from driftform.util.rotations import rotation_from_vector, rotation_vector_from_quaternion

GREATEST = 1e9
"""Acceleration (m/s2, rad/s2) to which those of trial steps are limited.

A long trial step ends deep in the wall, whose force throws the body so far that the later stages of the step overflow.
Exudyn rejects a step with a large error, but gives up after one that is not finite.
"""


@dataclass(frozen=True, eq=False)
class Motion:
    """A motion in coordinates: its initial values, and the compiled functions that define it.

    Attributes
    ----------
    coordinates, rates
        at the release, (6,): SI units and radians.
    values
        numbers of the model; pass them to all functions.
    inner, inner_rates
        places in ``values`` of the inner states of wall and water, all zero at the release, and of their rates, (k,) each.
        Write the states before ``accelerations`` is called; it writes their rates.
    bristles
        how many of them, the first, are those of friction. Where ``touches(coordinates, values)`` is False they are zero.
    accelerations
        ``accelerations(t, coordinates, rates, values)`` returns the derivatives of the rates, a tuple as long as they.
    fill_sample
        ``fill_sample(sample, t, coordinates, rates, values)`` fills ``sample``, a raw sample of
        :mod:`driftform.motion.flight`, (14,), and returns True while the flight continues: the sample is finite and
        inside the pipe.
    """

    coordinates: FloatArray
    rates: FloatArray
    values: FloatArray
    accelerations: Callable[[float, FloatArray, FloatArray, FloatArray], tuple[float, ...]]
    fill_sample: Callable[[FloatArray, float, FloatArray, FloatArray, FloatArray], bool]
    inner: npt.NDArray[np.int64]
    inner_rates: npt.NDArray[np.int64]
    bristles: int = 0
    touches: Callable[[FloatArray, FloatArray], bool] | None = None

    @classmethod
    def of(cls, model: FlightModel, start: FloatArray) -> "Motion":
        """Return the motion from the state ``start`` (13,)."""
        coordinates = np.concatenate([start[:3], rotation_vector_from_quaternion(start[3:7])])
        inner, fittings = _find_inner_states(model, model.bristles.size // 2), model.fittings
        if fittings is None:
            functions = _accelerations_in_space, _fill_sample_in_space, *inner, _can_touch
            return cls(coordinates, start[7:13], pack(model), *functions)

        def accelerate(
            t: float, coordinates: FloatArray, rates: FloatArray, values: FloatArray
        ) -> tuple[float, ...]:
            return _accelerations_in_space(t, coordinates, rates, values, fittings)

        def fill_sample(
            sample: FloatArray, t: float, coordinates: FloatArray, rates: FloatArray, values: FloatArray
        ) -> bool:
            return _fill_sample_in_space(sample, t, coordinates, rates, values, fittings)

        def can_touch(coordinates: FloatArray, values: FloatArray) -> bool:
            return _can_touch(coordinates, values, fittings)

        return cls(coordinates, start[7:13], pack(model), accelerate, fill_sample, *inner, can_touch)


def _find_inner_states(
    model: FlightModel, bristles: int
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], int]:
    """Return the places of the inner states and of their rates in a packed model, at whose end they are, and ``bristles``."""
    eddies = model.eddies.size // 2
    end = len(pack(model)) - 2 * eddies
    states = np.concatenate([np.arange(bristles) - 2 * bristles, np.arange(eddies)]) + end
    rates = np.concatenate([np.arange(bristles) - bristles, np.arange(eddies) + eddies]) + end
    return states, rates, bristles


@compiled
def _can_touch(coordinates: FloatArray, values: FloatArray, fittings: FloatArray | None = None) -> bool:
    """Return True if a surface may touch a wall."""
    model = unpack(values, fittings)
    position = (coordinates[0], coordinates[1], coordinates[2])
    return not is_far_from_wall(position, model.numbers[0].reach, model.pipe, model.fittings)


@compiled
def _accelerations_in_space(
    t: float,
    coordinates: FloatArray,
    rates: FloatArray,
    values: FloatArray,
    fittings: FloatArray | None = None,
) -> tuple[float, float, float, float, float, float]:
    R = rotation_from_vector(coordinates[3], coordinates[4], coordinates[5])
    a, alpha = accelerations(
        t,
        (coordinates[0], coordinates[1], coordinates[2]),
        R,
        (rates[0], rates[1], rates[2]),
        (rates[3], rates[4], rates[5]),
        unpack(values, fittings),
    )
    return _bound(a[0]), _bound(a[1]), _bound(a[2]), _bound(alpha[0]), _bound(alpha[1]), _bound(alpha[2])


@compiled
def _bound(acceleration: float) -> float:
    """Return the acceleration within +-GREATEST; NaN remains NaN."""
    if acceleration > GREATEST:
        return GREATEST
    return -GREATEST if acceleration < -GREATEST else acceleration


@compiled
def _fill_sample_in_space(
    sample: FloatArray,
    t: float,
    coordinates: FloatArray,
    rates: FloatArray,
    values: FloatArray,
    fittings: FloatArray | None = None,
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
    position = (coordinates[0], coordinates[1], coordinates[2])
    return is_finite(sample) and not has_left_pipe(position, unpack(values, None).pipe, fittings)
