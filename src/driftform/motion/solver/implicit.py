"""A linearly implicit step of a body that rests, slides or rolls on a wall.

The springs of the wall and the bristles of friction are much faster than the motion along the wall. An explicit method takes
steps as short as they are, however smooth the motion is. A Rosenbrock method solves linear equations in every stage, and
takes steps as long as the motion allows; a W-method keeps its order with an inexact Jacobian J, here one of differences
that serves for several steps.

In its equations (1 / (gamma h) - J) u = b the pose is eliminated, because its rate is the velocity; what remains are
the velocities and the bristles of the surfaces that touch. The other bristles only decay.
"""

import math
from typing import NamedTuple

from driftform.motion.forces.model import FlightModel
from driftform.motion.forces.rates import fill_rate, fill_stiff_places, first_bristle
from driftform.motion.forces.state import STATE
from driftform.motion.solver.explicit import normalise, squared_error
from driftform.motion.solver.tableaus import ROS34PW2
from driftform.types import FloatArray
from driftform.util.compiled import borrow, borrowing, compiled
from driftform.util.rotations import quaternion_product, quaternion_rate
from driftform.util.rows import copy

POSE_STEP = 1e-7
"""Difference of a position (m) or an angle (rad) from which the Jacobian follows: a wall gives way by some 1e-5 m."""

SPEED_STEP = 1e-4
"""Difference of a velocity (m/s, rad/s), or of a bristle."""


class WorkSpace(NamedTuple):
    """Room for steps of states of s numbers, of which u are unknowns: v velocities, and the bristles.

    Attributes:
        places: of the unknowns in a state, (u,).
        slopes: derivatives of the unknowns' rates with respect to motions of the pose by unit velocities, and to the
            unknowns, (u, v + u).
        matrix, unknowns, pose: of the equations of a stage: (u, u), (u,), (v,).
        stages, state, rate, changed: (stages, s), (s,), (s,), (s,).
    """

    places: FloatArray
    slopes: FloatArray
    matrix: FloatArray
    unknowns: FloatArray
    pose: FloatArray
    stages: FloatArray
    state: FloatArray
    rate: FloatArray
    changed: FloatArray


VELOCITIES = 6
"""Velocities among the unknowns."""

_STAGES = len(ROS34PW2.b)


@compiled
def count_work_space(size: int) -> int:
    """Return how many numbers a work space takes: see :func:`make_work_space`."""
    unknowns = size - VELOCITIES - 1
    return unknowns * (2 + 2 * unknowns + VELOCITIES) + VELOCITIES + (_STAGES + 3) * size


@borrowing
def make_work_space(room: FloatArray, first: int, size: int) -> WorkSpace:
    """Return room for steps of states of ``size`` numbers, which lies in ``room`` from the index ``first`` on."""
    u, v = size - VELOCITIES - 1, VELOCITIES
    slopes = first + u
    matrix = slopes + u * (v + u)
    unknowns = matrix + u * u
    pose = unknowns + u
    stages = pose + v
    state = stages + _STAGES * size
    return WorkSpace(
        borrow(room, first, (u,)),
        borrow(room, slopes, (u, v + u)),
        borrow(room, matrix, (u, u)),
        borrow(room, unknowns, (u,)),
        borrow(room, pose, (v,)),
        borrow(room, stages, (_STAGES, size)),
        borrow(room, state, (size,)),
        borrow(room, state + size, (size,)),
        borrow(room, state + 2 * size, (size,)),
    )


@compiled
def fill_jacobian(t: float, y: FloatArray, work: WorkSpace, model: FlightModel) -> int:
    """Fill the Jacobian at the state ``y``; return the number of unknowns, 0 if no surface touches."""
    fill_rate(t, y, model, work.rate)
    v, places, count = VELOCITIES, work.places, fill_stiff_places(model, work.places)
    for i in range(v + count if count > 0 else 0):
        step = POSE_STEP if i < v else SPEED_STEP
        copy(y, work.state)
        if i < v:
            for k in range(v):
                work.pose[k] = step if k == i else 0.0
            _move(y, work.pose, work.state)
        else:
            work.state[int(places[i - v])] += step
        fill_rate(t, work.state, model, work.changed)
        for k in range(count):
            row = int(places[k])
            work.slopes[k, i] = (work.changed[row] - work.rate[row]) / step
    return count


@compiled
def _move(y: FloatArray, by: FloatArray, pose: FloatArray) -> None:
    """Add to the first numbers of ``pose`` the motion ``by`` (m, rad) of the state ``y``; a turn about its axis moves no wall."""
    pose[0] += by[0]
    pose[1] += by[1]
    pose[2] += by[2]
    w, a, b, c = quaternion_rate(y[3], y[4], y[5], y[6], 0.0, by[4], by[5])
    pose[3] += w
    pose[4] += a
    pose[5] += b
    pose[6] += c


@compiled
def take_implicit_step(
    t: float,
    h: float,
    y: FloatArray,
    new: FloatArray,
    slopes: FloatArray,
    count: int,
    work: WorkSpace,
    model: FlightModel,
    tolerance: float,
) -> float:
    """Fill ``new`` with the state after ``h`` (s), and the second of ``slopes`` with its rate; return error over tolerance.

    The first of ``slopes`` is the rate at ``y``. The Jacobian in ``work`` has ``count`` unknowns.
    """
    method, stages, rate = ROS34PW2, work.stages, 1.0 / (ROS34PW2.gamma * h)
    _factorise(rate, count, work)
    for k in range(stages.shape[0]):
        copy(y, work.state)
        for i in range(k):
            for j in range(y.shape[0]):
                work.state[j] += method.a[k, i] * stages[i, j]
        if k == 0:
            copy(slopes[0], stages[k])
        else:
            fill_rate(t + method.c[k] * h, work.state, model, stages[k])
        for i in range(k):
            for j in range(y.shape[0]):
                stages[k, j] += method.solved[k, i] / h * stages[i, j]
        _solve(rate, y, stages[k], count, model.numbers[0].law.frequency, first_bristle(model), work)
    copy(y, new)
    for k in range(stages.shape[0]):
        for j in range(y.shape[0]):
            new[j] += method.b[k] * stages[k, j]
    error = math.sqrt(squared_error(method.error, stages, y, new, tolerance))
    normalise(new)
    fill_rate(t + h, new, model, slopes[1])
    return error


@compiled
def _factorise(rate: float, count: int, work: WorkSpace) -> None:
    """Fill ``matrix`` with the LU factors of the equations, 1/(gamma h) = ``rate`` (1/s), without pivots.

    The inverse of each pivot takes its place.
    """
    slopes, matrix, v = work.slopes, work.matrix, work.pose.shape[0]
    for i in range(count):
        for j in range(count):
            matrix[i, j] = -slopes[i, v + j]
        for j in range(v):
            matrix[i, j] -= slopes[i, j] / rate
        matrix[i, i] += rate
    for k in range(count):
        matrix[k, k] = 1.0 / matrix[k, k]
        for i in range(k + 1, count):
            factor = matrix[i, k] * matrix[k, k]
            matrix[i, k] = factor
            for j in range(k + 1, count):
                matrix[i, j] -= factor * matrix[k, j]


@compiled
def _solve(rate: float, y: FloatArray, u: FloatArray, count: int, omega: float, bristled: int, work: WorkSpace) -> None:
    """Replace the right-hand side ``u`` of the equations of a stage by their solution; bristles begin at the place ``bristled``."""
    z, pose, places, step = work.unknowns, work.pose, work.places, 1.0 / rate
    v = pose.shape[0]
    pose[0], pose[1], pose[2] = step * u[0], step * u[1], step * u[2]
    # The rate of a turn is twice the product of the conjugate quaternion with the quaternion's rate.
    _, a, b, c = quaternion_product(y[3], -y[4], -y[5], -y[6], u[3], u[4], u[5], u[6])
    pose[3], pose[4], pose[5] = 2.0 * step * a, 2.0 * step * b, 2.0 * step * c
    for i in range(count):
        total = u[int(places[i])]
        for j in range(v):
            total += work.slopes[i, j] * pose[j]
        z[i] = total
    _substitute(work.matrix, z, count)
    spin, decay = u[y.shape[0] - 1], 1.0 / (rate + omega)
    for j in range(STATE, y.shape[0]):
        # Gusts are slow: no part of the Jacobian.
        u[j] *= decay if j >= bristled else step
    for i in range(count):
        u[int(places[i])] = z[i]
    _move(y, z[:v], u)
    for j in range(7):
        u[j] *= step
    # The angle of the spin is the last number; nothing depends on it.
    u[y.shape[0] - 1] = step * spin


@compiled
def _substitute(factors: FloatArray, z: FloatArray, n: int) -> None:
    """Replace the right-hand side ``z`` (n,) by the solution of the equations with these LU factors."""
    for i in range(n):
        total = z[i]
        for j in range(i):
            total -= factors[i, j] * z[j]
        z[i] = total
    for k in range(n):
        i = n - 1 - k
        total = z[i]
        for j in range(i + 1, n):
            total -= factors[i, j] * z[j]
        z[i] = total * factors[i, i]
