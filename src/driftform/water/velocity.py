"""The water's velocity at a point of the pipe, with its derivatives: profiles of pipe flow, and gusts.

All profiles are axisymmetric about the axis of the bore. ``speed`` U
is the bulk velocity, R the bore's radius, y the distance from the wall, x the distance from the inlet along the pipe.
"""

import math

import numpy as np

from driftform.types import FloatArray
from driftform.util.compiled import allocating, compiled
from driftform.util.cubic import cubic_between, cubic_point, cubic_slope
from driftform.util.small_vectors import ZERO, Rotation, Vector, add, dot, scale, subtract
from driftform.water.fitting_flow import fitting_flow
from driftform.water.flow import (
    KARMAN,
    DevelopingFlow,
    Flow,
    GridFlow,
    LogLawFlow,
    PowerLawFlow,
    TurbulentFlow,
    UniformFlow,
    friction_velocity,
)
from driftform.water.grid_flow import grid_motion
from driftform.water.profiles import (
    AT_A_POINT,
    DEVELOPING,
    GRID,
    LOG_LAW,
    POWER_LAW,
    UNIFORM,
    Spread,
    spread_across,
    spread_profile,
)
from driftform.water.scenario import Scenario

KIND, SPEED, PARAMETER, GUST_STEP = 0, 1, 2, 3
"""Indices in the array of a flow; the parameter is 1/n (power law), u* / (kappa U) (log law) or nu / U (developing).

Of a grid it is the factor on the velocities of the file.
"""


def flow_array(scenario: Scenario) -> FloatArray:
    """Return a scenario's flow as :func:`water_motion` reads it: kind, speed, parameter, time step of gusts, (4,)."""
    flow, kind = scenario.flow, UNIFORM
    step = flow.smoothing if isinstance(flow, TurbulentFlow) else 0.0
    match flow:
        case UniformFlow():
            return np.array([UNIFORM, flow.speed, 0.0, scenario.flight.horizon])
        case GridFlow():
            return np.array([GRID, flow.speed, flow.speed / flow.reference, 0.0])
        case PowerLawFlow():
            kind = POWER_LAW
        case LogLawFlow() | TurbulentFlow():
            kind = LOG_LAW
        case DevelopingFlow():
            kind = DEVELOPING
    parameter = profile_parameter(
        flow, scenario.pipe.layout.inlet.radius, flow.speed, scenario.fluid.viscosity
    )
    return np.array([kind, flow.speed, parameter, step])


def profile_parameter(flow: Flow, radius: float, speed: float, viscosity: float) -> float:
    """Return the parameter of a profile in a bore of ``radius`` (m) at the mean ``speed`` (m/s): see :data:`PARAMETER`."""
    match flow:
        case PowerLawFlow():
            return 1 / flow.exponent
        case LogLawFlow() | TurbulentFlow():
            # The velocity of water at rest does not depend on its profile.
            speed = max(speed, 1e-12)
            return friction_velocity(flow, radius, speed, viscosity) / (KARMAN * speed)
        case DevelopingFlow():
            return viscosity / flow.speed
    return 0.0


def gust_array(scenario: Scenario, slip: float = 0.0, length: float = 0.0) -> FloatArray:
    """Return gusts at equal steps of time, (k, 12); (0, 12) for none.

    The columns are the velocity (m/s), its derivative, the change of the velocity along the body's axis (1/s), and its
    derivative, in the world frame.

    A uniform current with an acceleration gives two rows. In turbulent flow the seed decides the rows: each component
    is an Ornstein-Uhlenbeck process dv = -v dt / T + sqrt(2 s^2 / T) dW that is stationary from the start, sampled
    exactly every ``smoothing`` seconds and interpolated by a cubic spline: the process itself has no derivative, and
    eddies smaller than the agent do not move it.

    Two such processes, with the correlation exp(-distance / size), are the gusts at the Gauss points of a body of
    ``length``: what they have in common is the velocity, and their difference turns the body.

    Parameters
    ----------
    slip
        speed of the body through the water, m/s: see :func:`gust_memory`.
    length
        of the body, m; 0 for gusts that are uniform along it.
    """
    flow = scenario.flow
    if isinstance(flow, UniformFlow) and flow.acceleration:
        slope = flow.acceleration * scenario.direction()
        rows = np.zeros((2, 12))
        rows[:, 3:6], rows[1, :3] = slope, scenario.flight.horizon * slope
        return rows
    if not isinstance(flow, TurbulentFlow) or flow.intensity == 0:
        return np.empty((0, 12))
    deviation = flow.intensity * scenario.friction_velocity()
    times = flow.smoothing * np.arange(math.ceil(scenario.flight.horizon / flow.smoothing) + 3)
    kept = math.exp(-flow.smoothing / gust_memory(flow.memory, flow.crossing, slip, deviation))
    rng = np.random.default_rng(flow.seed)
    common, own = (_walk(rng.standard_normal((len(times), 3)), kept) for _ in range(2))
    apart = length / math.sqrt(3)
    correlation = math.exp(-apart * flow.crossing / (deviation * flow.memory))
    common *= deviation * math.sqrt((1 + correlation) / 2)
    own *= deviation * math.sqrt(2 * (1 - correlation)) / apart if apart > 0 else 0.0
    gusts = np.hstack([common, own])
    rates = find_spline_slopes(gusts, flow.smoothing)
    return np.hstack([common, rates[:, :3], own, rates[:, 3:]])


def find_spline_slopes(values: FloatArray, step: float) -> FloatArray:
    """Return the slopes at its knots of the cubic spline through values (k, n) at equal steps, (k, n), k >= 4.

    The second derivative is continuous at every knot; the third too at the second and the last but one ("not a knot": de Boor,
    A Practical Guide to Splines, chapter IV). ``scipy.interpolate.CubicSpline`` gives the same, but takes .3 s to import.
    """
    from scipy.linalg import solve_banded

    diagonals = np.ones((3, len(values)))
    diagonals[1, 1:-1] = 4.0
    diagonals[0, 1] = diagonals[2, -2] = 2.0
    right = np.empty_like(values)
    right[1:-1] = 3.0 * (values[2:] - values[:-2])
    right[0] = -2.5 * values[0] + 2.0 * values[1] + 0.5 * values[2]
    right[-1] = 2.5 * values[-1] - 2.0 * values[-2] - 0.5 * values[-3]
    return np.asarray(solve_banded((1, 1), diagonals, right / step))


def gust_memory(memory: float, crossing: float, slip: float, deviation: float) -> float:
    """Return the integral time (s) of the gusts that a body meets: T / sqrt(1 + (beta w / u')^2).

    Csanady, J. Atmos. Sci. 20 (1963), 201: a body that moves through the water leaves eddies before they decay. This is his
    time along the drift; across it, where he has 2 beta, gusts are forgotten up to twice as fast, which is left out.

    Parameters
    ----------
    memory
        T, of the water itself, s.
    crossing
        beta = u' T over the integral length of the gusts.
    slip
        w, speed of the body relative to the water, m/s.
    deviation
        u', standard deviation of a gust's component, m/s.

    >>> gust_memory(3.0, 0.5, 0.0, 0.03), round(gust_memory(3.0, 0.5, 3.0, 0.03), 3)
    (3.0, 0.06)
    """
    return memory / math.hypot(1.0, crossing * slip / deviation)


@allocating
def _walk(noise: FloatArray, kept: float) -> FloatArray:
    """Return the stationary process of which each step keeps the share ``kept``, from normal numbers (n, 3)."""
    walk, added = np.empty_like(noise), math.sqrt(1.0 - kept * kept)
    for j in range(noise.shape[1]):
        walk[0, j] = noise[0, j]
        for k in range(1, noise.shape[0]):
            walk[k, j] = kept * walk[k - 1, j] + added * noise[k, j]
    return walk


@compiled
def water_motion(
    point: Vector,
    t: float,
    pipe: FloatArray,
    flow: FloatArray,
    gusts: FloatArray,
    spread: Spread = AT_A_POINT,
    fittings: FloatArray | None = None,
) -> tuple[Vector, Rotation, Vector]:
    """Return the water's velocity (m/s), its gradient du_i/dx_j (rows i, 1/s) and its rate du/dt in place (m/s2).

    The mean flow is taken at the root mean square distance of ``spread`` from the axis: for a parabolic profile, that
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
            velocity, gradient = fitting_flow(point, fittings, flow[KIND], spread)
    elif pipe.shape[0] > 0:
        velocity, gradient = _mean_velocity(point, pipe, flow, spread)
    if gusts.shape[0] > 1:
        gust, rate = _interpolate_gust(t, gusts, flow[GUST_STEP], 0)
        velocity = add(velocity, gust)
    return velocity, gradient, rate


@compiled
def velocity_of_path(
    speed: Vector, t: float, flow: FloatArray, gusts: FloatArray, fittings: FloatArray | None
) -> Vector:
    """Return the velocity (m/s) along which the mean flow's gradient accelerates the water, whose velocity is ``speed``.

    A gust is given along the path already, so its rate is all of its acceleration: the mean shear on top would drag a body along
    the wall. In a fitting the mean flow itself accelerates.
    """
    if gusts.shape[0] == 0:
        return speed
    if fittings is not None:
        return subtract(speed, _interpolate_gust(t, gusts, flow[GUST_STEP], 0)[0])
    return ZERO


@compiled
def gust_shear(t: float, flow: FloatArray, gusts: FloatArray) -> Vector:
    """Return the change of a gust along the body's axis, world frame, 1/s; see :func:`gust_array`."""
    if gusts.shape[0] < 2:
        return ZERO
    return _interpolate_gust(t, gusts, flow[GUST_STEP], 6)[0]


@compiled
def _mean_velocity(
    point: Vector, pipe: FloatArray, flow: FloatArray, spread: Spread
) -> tuple[Vector, Rotation]:
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


@compiled
def _interpolate_gust(t: float, gusts: FloatArray, step: float, column: int) -> tuple[Vector, Vector]:
    """Return the three numbers from ``column`` on of the gusts at the time ``t`` (s), and their derivatives."""
    place = t / step
    k = min(max(int(place), 0), gusts.shape[0] - 2)
    u = min(max(place - k, 0.0), 1.0)
    a, b, c = gusts[k], gusts[k + 1], column
    p, v = (a[c], a[c + 1], a[c + 2]), (a[c + 3], a[c + 4], a[c + 5])
    q, w = (b[c], b[c + 1], b[c + 2]), (b[c + 3], b[c + 4], b[c + 5])
    curve = cubic_between(p, v, q, w, step)
    return cubic_point(curve, u), scale(1.0 / step, cubic_slope(curve, u))


def pipe_rows(scenario: Scenario) -> FloatArray:
    """Return the straight pipe, (1, 8): start, axis, length and radius; no rows for another one and in open water."""
    rows = scenario.pipe.array()
    axis = rows[:, 3:6] - rows[:, :3]
    length = np.linalg.norm(axis, axis=1, keepdims=True)
    return np.column_stack([rows[:, :3], axis / length, length, rows[:, 6]])
