"""What surrounds a point of the world: the velocity of the water, and the distance from the wall."""

import numpy as np
import numpy.typing as npt

from driftform.types import FloatArray
from driftform.util.compiled import allocating
from driftform.util.latest import keep_latest
from driftform.util.small_vectors import add
from driftform.water.fittings import fitting_array, wall_array
from driftform.water.flow import UniformFlow
from driftform.water.gusts import STATES
from driftform.water.parts.profiles import AT_A_POINT
from driftform.water.parts.walls import wall_gaps
from driftform.water.scenario import Scenario
from driftform.water.velocity import flow_array, gust_array, gust_at, pipe_rows, water_motion


def water_velocity(points: npt.ArrayLike, t: npt.ArrayLike, scenario: Scenario, gusts: bool = False) -> FloatArray:
    """Return the water's velocity at points of the world, with bends, reducers, tees and grids.

    Args:
        points: world frame, m, (n, 3). A point in the wall has the velocity at or near the wall's surface; beyond the
            inlet and the outlets the bore continues.
        t: times since the release, from 0 to ``scenario.flight.horizon``, s, (n,) or one for all points.
        gusts: whether gusts are added, if flights have any: those of ``gusts.seed`` that a point meets which stays
            where it is. Without them the velocity is the mean. The acceleration of a uniform current is no gust.

    Returns:
        m/s, world frame, (n, 3).:

    Raises:
        InputError: if the flow in a tee is not stored, and ``driftform-tees``, which solves it, is not installed.
        ValueError: if the file of a grid cannot be read, or does not fit the pipe.
    """
    places = np.array(points, dtype=np.float64).reshape(-1, 3)
    times = np.array(np.broadcast_to(t, len(places)), dtype=np.float64)
    pipe, flow, walk, fittings = _pack_water(scenario)
    found = _list_velocities(places, times, pipe, flow, walk if gusts else walk[:0], fittings)
    return found + scenario.flow.added if isinstance(scenario.flow, UniformFlow) else found


def wall_distance(points: npt.ArrayLike, scenario: Scenario) -> FloatArray:
    """Return the distance of points of the world from the wall of the pipe, positive in the water and negative in the wall.

    It is exact in straights, bends, reducers and tees, with the rounded edges of tees. Beyond the inlet and the outlets
    the bore continues.

    Args:
        points: world frame, m, (n, 3).

    Returns:
        m, (n,); infinite in open water.:
    """
    places = np.array(points, dtype=np.float64).reshape(-1, 3)
    if scenario.pipe.is_open:
        return np.full(len(places), np.inf)
    return wall_gaps(places, wall_array(scenario.pipe))[0]


@keep_latest
def _pack_water(scenario: Scenario) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray | None]:
    flow = flow_array(scenario)
    return pipe_rows(scenario), flow, gust_array(scenario, flow), fitting_array(scenario)


@allocating
def _list_velocities(
    points: FloatArray,
    times: FloatArray,
    pipe: FloatArray,
    flow: FloatArray,
    gusts: FloatArray,
    fittings: FloatArray | None,
) -> FloatArray:
    found, eddies = np.empty((len(points), 3)), np.zeros((2, STATES))
    for i in range(len(points)):
        point = (points[i, 0], points[i, 1], points[i, 2])
        velocity, _, _ = water_motion(point, times[i], pipe, flow, AT_A_POINT, fittings)
        if gusts.shape[0] > 0:
            # A tracer meets gusts without a drift: the first call finds the rate of tau here.
            eddies[0, 0] = 0.0
            gust_at(point, velocity, pipe, flow, gusts, eddies, fittings)
            eddies[0, 0] = times[i] * eddies[1, 0]
            velocity = add(velocity, gust_at(point, velocity, pipe, flow, gusts, eddies, fittings)[0])
        for a in range(3):
            found[i, a] = velocity[a]
    return found
