"""A step of an explicit Runge-Kutta pair, and the error of a step."""

import math

from driftform.motion.forces.model import FlightModel
from driftform.motion.forces.rates import fill_rate
from driftform.motion.forces.state import STATE
from driftform.motion.solver.tableaus import RungeKuttaPair
from driftform.types import FloatArray
from driftform.util.compiled import compiled
from driftform.util.rows import copy


@compiled
def take_step(
    t: float,
    h: float,
    y: FloatArray,
    new: FloatArray,
    slopes: FloatArray,
    pair: RungeKuttaPair,
    model: FlightModel,
    tolerance: float,
) -> float:
    """Fill ``new`` with the state after ``h`` (s) and ``slopes`` with those of all stages; return error over tolerance."""
    stages = pair.b.shape[0]
    for s in range(1, stages + 1):
        last = s == stages
        copy(y, new)
        for k in range(s):
            share = h * (pair.b[k] if last else pair.a[s, k])
            for j in range(y.shape[0]):
                new[j] += share * slopes[k, j]
        fill_rate(t + (1.0 if last else pair.c[s]) * h, new, model, slopes[s])
    first = squared_error(pair.error, slopes, y, new, tolerance)
    second = squared_error(pair.second, slopes, y, new, tolerance) if pair.second.shape[0] > 0 else 0.0
    normalise(new)
    if second > 0.0:
        return float(h * first / math.sqrt(first + 0.01 * second))
    return float(h * math.sqrt(first))


@compiled
def normalise(y: FloatArray) -> None:
    """Give the quaternion of a state the length 1, which is not part of the motion."""
    square = 0.0
    for j in range(3, 7):
        square += y[j] * y[j]
    for j in range(3, 7):
        y[j] /= math.sqrt(square)


@compiled
def squared_error(weights: FloatArray, slopes: FloatArray, y: FloatArray, new: FloatArray, tolerance: float) -> float:
    """Return the mean over all coordinates of ((weighted sum of slopes) / (tolerance (1 + |value|)))^2."""
    total = 0.0
    for j in range(y.shape[0]):
        e = 0.0
        for k in range(weights.shape[0]):
            e += weights[k] * slopes[k, j]
        e /= tolerance * (1.0 + max(abs(y[j]), abs(new[j])))
        total += e * e
    # Divide by the numbers of the body alone: more bristles must not loosen the tolerance.
    return total / STATE
