"""Flights that have settled: all but the distance along the pipe and the angle of the spin stays as it is.

Half of all random bodies end on the wall, at rest or sliding evenly. Where water and wall are the same all along the
pipe, the rest of such a flight is a straight line.
"""

import math

from driftform.motion.forces.model import FlightModel
from driftform.types import FloatArray
from driftform.util.compiled import compiled
from driftform.water.parts.profiles import GRID
from driftform.water.velocity import ACCELERATION, KIND


@compiled
def can_settle(model: FlightModel) -> bool:
    """Return whether water and wall are the same all along the pipe, and at all times, and drag brings bodies to rest."""
    flow, level = model.flow, model.numbers[0].water_level
    steady = flow[KIND] != GRID and flow[ACCELERATION] == 0.0 and model.gusts.shape[0] == 0
    return bool(steady and model.pipe.shape[0] == 1 and model.strips.shape[0] > 0 and level == math.inf)


@compiled
def has_settled(y: FloatArray, rate: FloatArray, rest: float, model: FlightModel) -> bool:
    """Return whether all but the distance along the pipe and the angle of the spin is constant for the rest of a flight.

    ``rest`` is its duration (s) over the tolerance of its steps, within which each number must stay at its present rate.
    """
    along = 0.0
    for i in range(3):
        along += rate[i] * model.pipe[0, 3 + i]
    for i in range(y.shape[0] - 1):
        change = rate[i]
        if i < 3:
            change -= along * model.pipe[0, 3 + i]
        if not abs(change) * rest <= 1.0 + abs(y[i]):
            return False
    return True


@compiled
def glide(h: float, y: FloatArray, rate: FloatArray) -> None:
    """Move a settled state by ``h`` s along its straight line, and turn it about its axis."""
    last = y.shape[0] - 1
    for i in range(3):
        y[i] += h * rate[i]
    y[last] += h * rate[last]
