"""A linearly implicit step of a body that rests, slides or rolls on a wall.

The springs of the wall and the bristles of friction are much faster than the motion along the wall. An explicit method takes
steps as short as they are, however smooth the motion is. A Rosenbrock method solves linear equations in every stage, and
takes steps as long as the motion allows; a W-method keeps its order with an inexact Jacobian, here that of the wall's forces
alone (:mod:`driftform.motion.contact_jacobian`).

In its equations (1 / (gamma h) - J) u = b the pose is eliminated, because its rate is the velocity; what remains are
the velocities and the bristles of the surfaces that touch. The other bristles only decay.
"""

import math
from typing import NamedTuple

from driftform.motion.contact_jacobian import EQUATIONS, JACOBIAN_ROOM, ContactJacobian, make_jacobian
from driftform.motion.impact import FREQUENCY
from driftform.motion.model import FlightModel
from driftform.motion.rates import fill_rate
from driftform.motion.runge_kutta import copy, normalise, squared_error
from driftform.motion.tableaus import ROS34PW2
from driftform.types import FloatArray
from driftform.util.compiled import borrow, borrowing, compiled
from driftform.util.rotations import quaternion_product, quaternion_rate


class WorkSpace(NamedTuple):
    """Room for a step: its Jacobian, its stages, the matrix, unknowns and pose of its equations, the state of a stage."""

    jacobian: ContactJacobian
    stages: FloatArray
    matrix: FloatArray
    unknowns: FloatArray
    pose: FloatArray
    state: FloatArray


_UNKNOWNS = JACOBIAN_ROOM + EQUATIONS**2
_POSE = _UNKNOWNS + EQUATIONS
WORK_ROOM = _POSE + 6
"""Numbers of a work space, without the states."""

WORK_STATES = len(ROS34PW2.b) + 1
"""States in a work space."""


@borrowing
def make_work_space(room: FloatArray, size: int, velocities: int, directions: int) -> WorkSpace:
    """Return room for steps of states of this ``size``; see :class:`ContactJacobian` for the other numbers.

    It is in the first WORK_ROOM + WORK_STATES ``size`` numbers of ``room``, which must be zero.
    """
    jacobian = make_jacobian(room, velocities, directions)
    equations, stages = jacobian.fast.shape[0], WORK_STATES - 1
    return WorkSpace(
        jacobian,
        borrow(room, WORK_ROOM, (stages, size)),
        borrow(room, JACOBIAN_ROOM, (equations, equations)),
        borrow(room, _UNKNOWNS, (equations,)),
        borrow(room, _POSE, (velocities,)),
        borrow(room, WORK_ROOM + stages * size, (size,)),
    )


@compiled
def take_implicit_step(
    t: float,
    h: float,
    y: FloatArray,
    new: FloatArray,
    slopes: FloatArray,
    touching: int,
    work: WorkSpace,
    model: FlightModel,
    plane: FloatArray | None,
    in_space: bool | None,
    tolerance: float,
) -> float:
    """Fill ``new`` with the state after ``h`` (s), and the second of ``slopes`` with its rate; return error over tolerance.

    The first of ``slopes`` is the rate at ``y``. The Jacobian in ``work`` is that at ``y``, where so many surfaces are
    ``touching``.
    """
    method, stages, rate = ROS34PW2, work.stages, 1.0 / (ROS34PW2.gamma * h)
    _factorise(rate, touching, work)
    for k in range(stages.shape[0]):
        copy(y, work.state)
        for i in range(k):
            for j in range(y.shape[0]):
                work.state[j] += method.a[k, i] * stages[i, j]
        if k == 0:
            copy(slopes[0], stages[k])
        else:
            fill_rate(t + method.c[k] * h, work.state, model, plane, in_space, stages[k])
        for i in range(k):
            for j in range(y.shape[0]):
                stages[k, j] += method.solved[k, i] / h * stages[i, j]
        _solve(rate, y, stages[k], touching, model.law[FREQUENCY], work)
    copy(y, new)
    for k in range(stages.shape[0]):
        for j in range(y.shape[0]):
            new[j] += method.b[k] * stages[k, j]
    error = math.sqrt(squared_error(method.error, stages, y, new, tolerance))
    normalise(new, plane)
    fill_rate(t + h, new, model, plane, in_space, slopes[1])
    return error


@compiled
def _factorise(rate: float, touching: int, work: WorkSpace) -> None:
    """Fill ``matrix`` with the LU factors of the equations, 1/(gamma h) = ``rate`` (1/s), without pivots.

    The matrix is one plus the product of the inverse mass with matrices that have no negative eigenvalue. The inverse of
    each pivot takes its place.
    """
    fast, stiff, matrix = work.jacobian.fast, work.jacobian.stiff, work.matrix
    v, step = stiff.shape[0], 1.0 / rate
    n = v + touching * (work.jacobian.pushes.shape[1] - 1)
    for i in range(n):
        for j in range(n):
            matrix[i, j] = -fast[i, j]
    for i in range(v):
        for j in range(v):
            matrix[i, j] -= step * stiff[i, j]
    for k in range(n):
        matrix[k, k] += rate
    for k in range(n):
        matrix[k, k] = 1.0 / matrix[k, k]
        for i in range(k + 1, n):
            factor = matrix[i, k] * matrix[k, k]
            matrix[i, k] = factor
            for j in range(k + 1, n):
                matrix[i, j] -= factor * matrix[k, j]


@compiled
def _solve(rate: float, y: FloatArray, u: FloatArray, touching: int, omega: float, work: WorkSpace) -> None:
    """Replace the right-hand side ``u`` of the equations of a stage by their solution."""
    stiff, z, pose, step = work.jacobian.stiff, work.unknowns, work.pose, 1.0 / rate
    v, d = stiff.shape[0], work.jacobian.pushes.shape[1] - 1
    first, bristles = (4, 7) if v == 3 else (7, 13)
    pose[0], pose[1] = step * u[0], step * u[1]
    if v == 3:
        pose[2] = 2.0 * step * (y[2] * u[3] - y[3] * u[2])
    else:
        pose[2] = step * u[2]
        # The rate of a turn is twice the product of the conjugate quaternion with the quaternion's rate.
        _, a, b, c = quaternion_product(y[3], -y[4], -y[5], -y[6], u[3], u[4], u[5], u[6])
        pose[3], pose[4], pose[5] = 2.0 * step * a, 2.0 * step * b, 2.0 * step * c
    for i in range(v):
        total = u[first + i]
        for j in range(v):
            total += stiff[i, j] * pose[j]
        z[i] = total
    for i in range(touching):
        bent = bristles + d * int(work.jacobian.touching[i])
        for j in range(d):
            z[v + i * d + j] = u[bent + j]
    _substitute(work.matrix, z, v + touching * d)
    decay = 1.0 / (rate + omega)
    for j in range(bristles, y.shape[0]):
        u[j] *= decay
    for i in range(touching):
        bent = bristles + d * int(work.jacobian.touching[i])
        for j in range(d):
            u[bent + j] = z[v + i * d + j]
    for i in range(v):
        u[first + i] = z[i]
    u[0], u[1] = step * (u[0] + z[0]), step * (u[1] + z[1])
    if v == 3:
        u[2], u[3] = step * (u[2] - 0.5 * y[3] * z[2]), step * (u[3] + 0.5 * y[2] * z[2])
    else:
        w, a, b, c = quaternion_rate(y[3], y[4], y[5], y[6], 0.0, z[4], z[5])
        u[2], u[3], u[4] = step * (u[2] + z[2]), step * (u[3] + w), step * (u[4] + a)
        u[5], u[6] = step * (u[5] + b), step * (u[6] + c)
        # The angle of the spin is the last number; nothing depends on it.
        u[y.shape[0] - 1] *= step / decay


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
