"""The loop over the steps of a flight.

A body that is clear of the wall moves smoothly, and DOP853 takes the longest steps; near the wall, where forces have kinks,
DOPRI5 does. Where a body rests, slides or rolls on it, the wall is stiff, and a Rosenbrock method takes the steps. The
error of every step is controlled (:mod:`driftform.motion.solver.control`), and a step over a touch of the wall ends at
that touch (:mod:`driftform.motion.solver.events`).
"""

import math
from typing import NamedTuple

import numpy as np

from driftform.motion.forces.contact import is_near_wall
from driftform.motion.forces.model import FlightModel
from driftform.motion.forces.rates import count_numbers, fill_rate, first_bristle, roll, straighten_bristles
from driftform.motion.forces.state import SAMPLE, STATE, is_finite, position_of
from driftform.motion.solver.control import (
    LOG_MIN_ERROR,
    SHORTEST_STEP,
    StepControl,
    continue_after,
    grow_tolerance,
    shorten,
)
from driftform.motion.solver.events import find_touch
from driftform.motion.solver.explicit import take_step
from driftform.motion.solver.implicit import (
    WorkSpace,
    count_work_space,
    fill_jacobian,
    make_work_space,
    take_implicit_step,
)
from driftform.motion.solver.settling import can_settle, glide, has_settled
from driftform.motion.solver.tableaus import DOP853, DOPRI5, ROS34PW2
from driftform.types import FloatArray
from driftform.util.compiled import allocating, borrow, compiled
from driftform.util.rows import copy, copy_rows
from driftform.water.outlets import has_left_pipe

SMOOTH_SHARE = 1e-2
"""Factor of the tolerance during smooth motion without gusts, whose accuracy costs little: contact causes nearly all of
the error."""

FIRST_STEP = 1e-3
"""Length of the first step, s."""

MAX_RADIANS = 1.5
"""Longest explicit step of a body that touches, times the frequency of the contact; longer steps are implicit.

Up to there DOPRI5 is more accurate; from about 3 on it is unstable.
"""

JACOBIAN_STEPS = 8
"""Implicit steps with one Jacobian."""

EXPLICIT_STEPS = 10
"""Explicit steps after an implicit one that was rejected and became as short as they are."""

TOUCH_SHARE = 0.25
"""First step after a touch that was stepped over, as a share of the time for which the wall would be touched undisturbed."""

SHORTEST_TOUCH = 1e-9
"""Shortest step that ends at a touch, s."""

_ROWS = len(DOP853.b) + 3
"""Rows of an integration: the state of the last step, that of the next one, and the slopes of all stages."""


class Limits(NamedTuple):
    """What bounds an integration: its end (s), tolerance at the release, longest steps (s), also near a wall, and how many."""

    horizon: float
    tolerance: float
    max_step: float
    near_step: float
    step_limit: int


class _Rooms(NamedTuple):
    """State of the last step, that of the next, slopes of all stages, and the room of implicit steps."""

    y: FloatArray
    new: FloatArray
    slopes: FloatArray
    work: WorkSpace


class _Stiffness(NamedTuple):
    """What chooses between methods: explicit steps still to take, age of the Jacobian in steps, and its unknowns."""

    explicit: int
    age: int
    unknowns: int


class _Progress(NamedTuple):
    """How far an integration is: time (s), samples so far, whether it has settled, whether it has ended, and its control."""

    t: float
    taken: int
    settled: bool
    ended: bool
    control: StepControl
    stiffness: _Stiffness


@allocating
def take_all_steps(model: FlightModel, start: FloatArray, limits: Limits) -> FloatArray:
    """Return raw samples (k, 14) of the release and the end of every step, up to the first one past the outlet."""
    samples, size = np.empty((256, SAMPLE)), count_numbers(model)
    room = np.zeros(_ROWS * size + count_work_space(size))
    for i in range(first_bristle(model)):
        room[i] = start[i]
    control = StepControl(min(FIRST_STEP, limits.horizon), LOG_MIN_ERROR)
    progress = _Progress(0.0, 0, False, False, control, _Stiffness(0, JACOBIAN_STEPS, 0))
    while True:
        progress = _fill_samples(model, limits, room, progress, samples)
        if progress.ended:
            return samples[: progress.taken]
        longer = np.empty((2 * progress.taken, SAMPLE))
        copy_rows(samples, longer)
        samples = longer


@compiled
def _fill_samples(
    model: FlightModel, limits: Limits, room: FloatArray, progress: _Progress, samples: FloatArray
) -> _Progress:
    """Fill ``samples`` until the flight ends or there is no room for another one; return how far it is then."""
    size = count_numbers(model)
    rooms = _Rooms(
        borrow(room, 0, (size,)),
        borrow(room, size, (size,)),
        borrow(room, 2 * size, (_ROWS - 2, size)),
        make_work_space(room, _ROWS * size, size),
    )
    settles = can_settle(model)
    if progress.taken == 0:
        fill_rate(0.0, rooms.y, model, rooms.slopes[0])
    while progress.taken < samples.shape[0]:
        row, count = samples[progress.taken], progress.taken + 1
        _record(progress.t, rooms.y, row)
        ends = not is_finite(rooms.y) or progress.t >= limits.horizon or count > limits.step_limit
        if ends or has_left_pipe(position_of(row), model.pipe, model.fittings):
            return _Progress(progress.t, count, progress.settled, True, progress.control, progress.stiffness)
        if progress.settled:
            h = min(limits.max_step, limits.horizon - progress.t)
            glide(h, rooms.y, rooms.slopes[0])
            t = limits.horizon if limits.horizon - progress.t <= h else progress.t + h
            progress = _Progress(t, count, True, False, progress.control, progress.stiffness)
        else:
            progress = _advance(model, limits, rooms, progress, settles)
    return progress


@compiled
def _record(t: float, y: FloatArray, row: FloatArray) -> None:
    """Fill a raw sample, (14,), in the frame that spins with the body."""
    row[0] = t
    for i in range(STATE):
        row[1 + i] = y[i]
    roll(row, y[y.shape[0] - 1])


@compiled
def _advance(model: FlightModel, limits: Limits, rooms: _Rooms, progress: _Progress, settles: bool) -> _Progress:
    """Take one accepted step, and return how far the flight is then."""
    y, new, slopes, work = rooms.y, rooms.new, rooms.slopes, rooms.work
    t, horizon, longest = progress.t, limits.horizon, MAX_RADIANS / model.numbers[0].law.frequency
    age, unknowns = progress.stiffness.age, progress.stiffness.unknowns
    pair, sharp = DOPRI5, grow_tolerance(limits.tolerance, t)
    near = is_near_wall((y[0], y[1], y[2]), model)
    if not near:
        pair = DOP853
        if model.gusts.shape[0] == 0:
            sharp *= SMOOTH_SHARE
        # What remains of the bristles would only limit the steps.
        straighten_bristles(y, slopes[0], model)
    h = min(progress.control.h, limits.near_step if near else limits.max_step)
    explicit, stay = progress.stiffness.explicit - 1, math.inf
    while True:
        h = min(h, horizon - t)
        implicit = near and h > longest and explicit < 0
        if implicit and age >= JACOBIAN_STEPS:
            age, unknowns = 0, fill_jacobian(t, y, work, model)
        implicit = implicit and unknowns > 0
        if implicit:
            error = take_implicit_step(t, h, y, new, slopes, unknowns, work, model, sharp)
        else:
            error = take_step(t, h, y, new, slopes, pair, model, sharp)
        power = ROS34PW2.power if implicit else pair.power
        if error <= 1.0:
            share, time = find_touch(h, y, slopes[0], new, slopes[1 if implicit else pair.b.shape[0]], model)
            if share >= 1.0 or stay < math.inf:
                break
            h, stay = max(share * h, SHORTEST_TOUCH), time
            continue
        h = shorten(h, error, power)
        if implicit and h < longest:
            explicit = EXPLICIT_STEPS
        if age > 0:
            age = JACOBIAN_STEPS
        if h < SHORTEST_STEP:
            new[0] = math.nan
            break
    age = age + 1 if implicit else JACOBIAN_STEPS
    t = horizon if horizon - t <= h * (1.0 + 1e-12) else t + h
    copy(new, y)
    copy(slopes[1 if implicit else pair.b.shape[0]], slopes[0])
    settled = implicit and settles and has_settled(y, slopes[0], (horizon - t) / limits.tolerance, model)
    control = continue_after(h, error, power, progress.control.earlier)
    if stay < math.inf:
        control = StepControl(min(control.h, longest, max(SHORTEST_STEP, TOUCH_SHARE * stay)), control.earlier)
    return _Progress(t, progress.taken + 1, settled, False, control, _Stiffness(explicit, age, unknowns))
