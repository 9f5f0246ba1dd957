"""The loop over the steps of a flight, with a tolerance that grows along it.

A body that is clear of the wall moves smoothly, and DOP853 takes the longest steps; near the wall, where forces have kinks,
DOPRI5 does. Where a body rests, slides or rolls on it, the wall is stiff, and a Rosenbrock method takes the steps. The error
of every step is controlled. An early error has the rest of the flight to grow, from collision to collision, so the tolerance
of a step grows with time.

Half of all random bodies end on the wall, at rest or sliding evenly. Where water and wall are the same all along the pipe, the rest
of such a flight is a straight line, and the steps that remain follow it.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from driftform.motion.contact import is_far_from_wall
from driftform.motion.flight import SAMPLE, has_left_pipe, is_finite, position_of
from driftform.motion.model import FlightModel, unpack
from driftform.motion.plane import STATE_INDICES
from driftform.motion.rates import PLANE_STATE, STATE, fill_rate, roll
from driftform.motion.rosenbrock import count_work_space, fill_jacobian, make_work_space, take_implicit_step
from driftform.motion.runge_kutta import copy, take_step
from driftform.motion.tableaus import DOP853, DOPRI5, ROS34PW2
from driftform.types import FloatArray
from driftform.util.compiled import allocating, borrow, compiled
from driftform.water.parts.profiles import GRID
from driftform.water.velocity import ACCELERATION, KIND

TOLERANCE_GROWTH = 0.5
"""Rate (1/s) at which the tolerance grows along a flight: about the rate at which small differences grow.

The two integrations then take 1.6 times fewer steps than with a constant tolerance, and differ by as much.
"""

LOOSEST_RATIO = 100.0
"""Ratio of the tolerance at the end of a long flight to that at its release."""

SMOOTH_SHARE = 1e-2
"""Factor of the tolerance during smooth motion without gusts, whose accuracy costs little: contact causes nearly all of
the error."""

FIRST_STEP = 1e-3
"""Length of the first step, s."""

MOST_RADIANS = 1.5
"""Longest explicit step of a body that touches, times the frequency of the contact; longer steps are implicit.

Up to there DOPRI5 is more accurate; from about 3 on it is unstable.
"""

JACOBIAN_STEPS = 8
"""Implicit steps with one Jacobian."""

EXPLICIT_STEPS = 10
"""Explicit steps after an implicit one that was rejected and became as short as they are."""

_STATES = len(DOP853.b) + 3
"""States in the room of an integration: that of the last step, that of the next one, and the slopes of all stages."""

_ALL_PLACES, _PLACES_IN_PLANE = np.arange(STATE), np.array(STATE_INDICES)

LOG_MIN_ERROR = math.log(1e-4)
"""Lower bound of the logarithm of a step's error over tolerance, as used for the length of the next step."""


@compiled
def grow_tolerance(tolerance: float, t: float) -> float:
    """Return the tolerance of a step at the time ``t`` (s) after the release, where it is ``tolerance``."""
    return tolerance * min(LOOSEST_RATIO, math.exp(TOLERANCE_GROWTH * t))


class _Progress(NamedTuple):
    """How far an integration is: time (s), next step (s), what chooses the steps, samples, whether it has settled, and whether it has ended."""

    t: float
    h: float
    earlier: float
    taken: int
    explicit: int
    age: int
    touching: int
    settled: bool
    ended: bool


@allocating
def take_all_steps(
    values: FloatArray,
    fittings: FloatArray | None,
    in_space: bool | None,
    start: FloatArray,
    horizon: float,
    tolerance: float,
    max_step: float,
    step_limit: int,
) -> FloatArray:
    """Return raw samples (k, 14) of the release and the end of every step, up to the first one past the outlet."""
    model, samples = unpack(values, fittings), np.empty((256, SAMPLE))
    size = _count_numbers(model, in_space)
    room = np.zeros(_STATES * size + count_work_space(size, 3 if in_space is None else 6))
    progress = _Progress(0.0, min(FIRST_STEP, horizon), LOG_MIN_ERROR, 0, 0, JACOBIAN_STEPS, 0, False, False)
    while True:
        progress = _take_steps(
            model, in_space, start, horizon, tolerance, max_step, step_limit, room, progress, samples
        )
        if progress.ended:
            return samples[: progress.taken]
        longer = np.empty((2 * progress.taken, SAMPLE))
        _copy_rows(samples, longer)
        samples = longer


@compiled
def _count_numbers(model: FlightModel, in_space: bool | None) -> int:
    """Return how many numbers change along a flight of a model: see :mod:`driftform.motion.rates`."""
    bristles = len(model.bristles) // 2
    if in_space is None:
        return PLANE_STATE + bristles
    return STATE + model.eddies.size // 2 + 3 * bristles + 1


@compiled
def _copy_rows(source: FloatArray, target: FloatArray) -> None:
    for k in range(source.shape[0]):
        copy(source[k], target[k])


@compiled
def _take_steps(
    model: FlightModel,
    in_space: bool | None,
    start: FloatArray,
    horizon: float,
    tolerance: float,
    max_step: float,
    step_limit: int,
    room: FloatArray,
    progress: _Progress,
    samples: FloatArray,
) -> _Progress:
    """Fill ``samples`` until the flight ends or there is no room for another one; return how far it is then.

    ``room`` begins with the state, which is zero at the release.
    """
    places, velocities, angles, eddies = _ALL_PLACES, 6, 1, model.eddies.size // 2
    if in_space is None:
        places, velocities, angles, eddies = _PLACES_IN_PLANE, 3, 0, 0
    size = _count_numbers(model, in_space)
    y, new = borrow(room, 0, (size,)), borrow(room, size, (size,))
    slopes = borrow(room, 2 * size, (_STATES - 2, size))
    work = make_work_space(room, _STATES * size, size, velocities)
    t, h, earlier, count = progress.t, progress.h, progress.earlier, progress.taken
    explicit, age, touching, ended = progress.explicit, progress.age, progress.touching, False
    settled, settles = progress.settled, _is_alike_along(model)
    longest = MOST_RADIANS / model.numbers[0].law.frequency
    if count == 0:
        for i in range(places.shape[0]):
            y[i] = start[places[i]]
        for j in range(eddies):
            y[STATE + j] = start[STATE + j]
        fill_rate(t, y, model, in_space, slopes[0])
    while count < samples.shape[0]:
        row = samples[count]
        row[0] = t
        for i in range(STATE):
            row[1 + i] = start[i]
        for i in range(places.shape[0]):
            row[1 + places[i]] = y[i]
        if angles > 0:
            roll(row, y[size - 1])
        position = position_of(row)
        count += 1
        if (
            not is_finite(y)
            or t >= horizon
            or count > step_limit
            or has_left_pipe(position, model.pipe, model.fittings)
        ):
            ended = True
            break
        if settled:
            h = min(max_step, horizon - t)
            for i in range(size):
                if i >= size - angles or (i < places.shape[0] and places[i] < 3):
                    y[i] += h * slopes[0, i]
            t = horizon if horizon - t <= h else t + h
            continue
        pair, sharp = DOPRI5, grow_tolerance(tolerance, t)
        near = not is_far_from_wall(position, model.numbers[0].reach, model.pipe, model.fittings)
        if not near:
            pair = DOP853
            if model.gusts.shape[0] == 0:
                sharp *= SMOOTH_SHARE
            # Bristles straighten in the water. What remains of them would only limit the steps.
            for j in range(places.shape[0] + eddies, size - angles):
                y[j], slopes[0, j] = 0.0, 0.0
        h, explicit = min(h, max_step), explicit - 1
        while True:
            h = min(h, horizon - t)
            implicit = near and h > longest and explicit < 0
            if implicit and age >= JACOBIAN_STEPS:
                age, touching = 0, fill_jacobian(t, y, work, model, in_space)
            implicit = implicit and touching > 0
            if implicit:
                error = take_implicit_step(t, h, y, new, slopes, touching, work, model, in_space, sharp)
            else:
                error = take_step(t, h, y, new, slopes, pair, model, in_space, sharp)
            power = ROS34PW2.power if implicit else pair.power
            if error <= 1.0:
                break
            h *= max(0.2, 0.9 * error ** (-1.0 / power)) if math.isfinite(error) else 0.2
            if implicit and h < longest:
                explicit = EXPLICIT_STEPS
            if age > 0:
                age = JACOBIAN_STEPS
            if h < 1e-12:
                new[0] = math.nan
                break
        age = age + 1 if implicit else JACOBIAN_STEPS
        t = horizon if horizon - t <= h * (1.0 + 1e-12) else t + h
        copy(new, y)
        copy(slopes[1 if implicit else pair.b.shape[0]], slopes[0])
        settled = implicit and settles and _is_settled(y, slopes[0], (horizon - t) / tolerance, places, angles, model)
        # Gustafsson's controller uses the step before as well, and so rejects few steps.
        now = math.log(max(error, 1e-8))
        h *= min(5.0, max(0.2, 0.9 * math.exp((0.4 * earlier - 0.7 * now) / power)))
        earlier = max(now, LOG_MIN_ERROR)
    return _Progress(t, h, earlier, count, explicit, age, touching, settled, ended)


@compiled
def _is_alike_along(model: FlightModel) -> bool:
    """Return whether water and wall are the same all along the pipe, and at all times, and drag brings bodies to rest."""
    flow, level = model.flow, model.numbers[0].water_level
    steady = flow[KIND] != GRID and flow[ACCELERATION] == 0.0 and model.gusts.shape[0] == 0
    return bool(steady and model.pipe.shape[0] == 1 and model.strips.shape[0] > 0 and level == math.inf)


@compiled
def _is_settled(
    y: FloatArray, rate: FloatArray, rest: float, places: npt.NDArray[np.int64], angles: int, model: FlightModel
) -> bool:
    """Return whether all but the way along the pipe and the angle of the spin is constant for the rest of a flight.

    ``rest`` is its duration (s) over the tolerance of its steps, within which each number must stay at its present rate.
    """
    along = 0.0
    for i in range(places.shape[0]):
        if places[i] < 3:
            along += rate[i] * model.pipe[0, 3 + places[i]]
    for i in range(y.shape[0] - angles):
        change = rate[i]
        if i < places.shape[0] and places[i] < 3:
            change -= along * model.pipe[0, 3 + places[i]]
        if not abs(change) * rest <= 1.0 + abs(y[i]):
            return False
    return True
