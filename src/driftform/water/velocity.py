"""The water's velocity at a point of the pipe, with its derivatives: profiles of pipe flow, and what surrounds a gust.

All profiles are axisymmetric about the axis of the bore. ``speed`` U
is the bulk velocity, R the bore's radius, y the distance from the wall, x the distance from the inlet along the pipe.
"""

import math

import numpy as np

from driftform.types import FloatArray
from driftform.util.compiled import compiled
from driftform.util.small_vectors import ZERO, Rotation, Vector, add, dot, scale, subtract
from driftform.water.flow import GridFlow, UniformFlow, friction_velocity
from driftform.water.gusts import REACH, SIZE, draw_gusts, gust_motion, gust_numbers, shortest_memory
from driftform.water.parts.grid_flow import grid_motion
from driftform.water.parts.profiles import AT_A_POINT, GRID, UNIFORM, Bore, Spread, spread_across, spread_profile
from driftform.water.parts.stream import bore_at, fitting_flow
from driftform.water.regime import list_bores, profile_kind, profile_parameter
from driftform.water.scenario import Scenario
from driftform.water.wetted import wetted_speed

KIND, SPEED, PARAMETER, ACCELERATION, FRICTION = 0, 1, 2, 3, 10
"""Indices in the array of a flow; the parameter is that of :func:`driftform.water.regime.profile_parameter`.

Of a grid it is the factor on the velocities of the file. Those between belong to gusts: :data:`driftform.water.gusts.STEP`.
"""


def flow_array(scenario: Scenario) -> FloatArray:
    """Return a scenario's flow as the kernels read it, with the gusts that a tracer meets, (10,)."""
    flow, radius = scenario.flow, scenario.pipe.layout.inlet.radius if not scenario.pipe.is_open else math.inf
    numbers = np.zeros(FRICTION + 1)
    if isinstance(flow, UniformFlow):
        numbers[KIND : ACCELERATION + 1] = UNIFORM, flow.speed, 0.0, flow.acceleration
    elif isinstance(flow, GridFlow):
        numbers[KIND : PARAMETER + 1] = GRID, flow.speed, flow.speed / flow.reference
    else:
        kind = profile_kind(flow, radius, flow.speed, scenario.fluid.viscosity)
        parameter = profile_parameter(flow, radius, flow.speed, scenario.fluid.viscosity)
        speed = wetted_speed(scenario.pipe, flow, kind, parameter, scenario.fluid.water_level)
        numbers[KIND : PARAMETER + 1] = kind, speed, parameter
    if scenario.has_gusts:
        numbers[FRICTION] = scenario.friction_velocity()
        set_gusts(numbers, scenario)
    return numbers


def set_gusts(flow: FloatArray, scenario: Scenario, size: float = 0.0, slip: float = 0.0, length: float = 0.0) -> None:
    """Write to the array of a flow the gusts that a body meets.

    Args:
        size: half of the body's diameter, m.
        slip, length: see :func:`driftform.water.gusts.gust_numbers`.
    """
    radius = scenario.pipe.layout.inlet.radius
    flow[ACCELERATION + 1 : SIZE] = gust_numbers(scenario.gusts, radius, slip, length)
    flow[SIZE], flow[REACH] = size, max(size, 0.5 * length)


def gust_array(scenario: Scenario, flow: FloatArray, length: float = 0.0) -> FloatArray:
    """Return the walk of the gusts that a body of ``length`` (m) meets, (k, 12), (0, 12) for none; ``flow`` is its array.

    See :func:`driftform.water.gusts.draw_gusts`.
    """
    if not scenario.has_gusts:
        return np.empty((0, 12))
    viscosity = scenario.fluid.viscosity
    bores = [(R, friction_velocity(scenario.flow, R, speed, viscosity)) for _, R, speed in list_bores(scenario)]
    steps = scenario.flight.horizon / (shortest_memory(flow, bores) * scenario.gusts.smoothing)
    return draw_gusts(scenario.gusts, steps, scenario.pipe.layout.inlet.radius, length)


@compiled
def water_motion(
    point: Vector,
    t: float,
    pipe: FloatArray,
    flow: FloatArray,
    spread: Spread = AT_A_POINT,
    fittings: FloatArray | None = None,
) -> tuple[Vector, Rotation, Vector]:
    """Return the velocity of the mean flow (m/s), its gradient du_i/dx_j (rows i, 1/s) and its rate in place (m/s2).

    The flow is taken at the root mean square distance of ``spread`` from the axis: for a parabolic profile, that
    is its mean over the body.

    ``fittings`` is the array of a pipe with parts (:mod:`driftform.water.fittings`), in place of ``pipe``, and of a grid.

    In the boundary layer of developing flow the radial velocity is that of continuity; its own change downstream
    is of second order in the layer's slope and left out of the gradient.
    """
    velocity, gradient, rate = (flow[SPEED], 0.0, 0.0), (ZERO, ZERO, ZERO), ZERO
    if fittings is not None:
        if flow[KIND] == GRID:
            velocity, gradient = grid_motion(point, fittings, spread)
            factor = flow[PARAMETER]
            velocity = scale(factor, velocity)
            gradient = (scale(factor, gradient[0]), scale(factor, gradient[1]), scale(factor, gradient[2]))
        else:
            velocity, gradient = fitting_flow(point, fittings, spread)
    elif pipe.shape[0] > 0:
        velocity, gradient = _mean_velocity(point, pipe, flow, spread)
    if flow[ACCELERATION] != 0.0:
        axis = (1.0, 0.0, 0.0)
        if pipe.shape[0] > 0:
            axis = (pipe[0, 3], pipe[0, 4], pipe[0, 5])
        rate = scale(flow[ACCELERATION], axis)
        velocity = add(velocity, scale(t, rate))
    return velocity, gradient, rate


@compiled
def gust_at(
    point: Vector,
    mean: Vector,
    pipe: FloatArray,
    flow: FloatArray,
    gusts: FloatArray,
    eddies: FloatArray,
    fittings: FloatArray | None = None,
) -> tuple[Vector, Vector, Vector]:
    """Return what :func:`driftform.water.gusts.gust_motion` does at a point; zeros without gusts."""
    if gusts.shape[0] == 0:
        return ZERO, ZERO, ZERO
    return gust_motion(_bore_around(point, pipe, flow, fittings), mean, flow, gusts, eddies)


@compiled
def _bore_around(point: Vector, pipe: FloatArray, flow: FloatArray, fittings: FloatArray | None) -> Bore:
    if fittings is not None:
        return bore_at(point, fittings)
    _, outward, radius, _, r = locate_in_bore(point, pipe)
    return outward, radius, r, flow[FRICTION]


@compiled
def _mean_velocity(point: Vector, pipe: FloatArray, flow: FloatArray, spread: Spread) -> tuple[Vector, Rotation]:
    """Return the velocity of the profile, and its gradient."""
    axis, outward, radius, x, r = locate_in_bore(point, pipe)
    along, shear, stretch, radial = spread_profile(
        radius, x, r, spread_across(spread, axis), flow[KIND], flow[SPEED], flow[PARAMETER]
    )
    # On the axis, a radial velocity proportional to r has the same gradient in all transverse directions.
    ring = radial / r if r > 0.0 else -0.5 * stretch
    # The gradient is a (x) v + n (x) w + ring 1, with the axis a and the outward normal n.
    v = add(scale(shear, outward), scale(stretch - ring, axis))
    w = scale(-stretch - 2.0 * ring, outward)
    gradient = (
        add(add(scale(axis[0], v), scale(outward[0], w)), (ring, 0.0, 0.0)),
        add(add(scale(axis[1], v), scale(outward[1], w)), (0.0, ring, 0.0)),
        add(add(scale(axis[2], v), scale(outward[2], w)), (0.0, 0.0, ring)),
    )
    return add(scale(along, axis), scale(radial, outward)), gradient


@compiled
def locate_in_bore(point: Vector, pipe: FloatArray) -> tuple[Vector, Vector, float, float, float]:
    """Return unit vectors along the bore and away from its axis, its radius, x from the inlet, and r (m)."""
    axis = (pipe[0, 3], pipe[0, 4], pipe[0, 5])
    off = subtract(point, (pipe[0, 0], pipe[0, 1], pipe[0, 2]))
    x = dot(axis, off)
    off = subtract(off, scale(x, axis))
    r = math.sqrt(dot(off, off))
    return axis, scale(1.0 / r, off) if r > 0.0 else ZERO, pipe[0, 7], x, r


def pipe_rows(scenario: Scenario) -> FloatArray:
    """Return the straight pipe, (1, 8): start, axis, length and radius; no rows for another one and in open water."""
    rows = scenario.pipe.array()
    axis = rows[:, 3:6] - rows[:, :3]
    length = np.linalg.norm(axis, axis=1, keepdims=True)
    return np.column_stack([rows[:, :3], axis / length, length, rows[:, 6]])
