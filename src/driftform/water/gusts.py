r"""Turbulence as a body meets it along its path: gusts that leave tracers evenly spread over the bore.

The gust at the place x of a body is::

    u' = S(x) (g(tau) + h)        S = s u* (1 - q^2 n n)        q = a r / ((R - a) y)
    tau' = 1 / T        h' = -h / T + div S        T = K / (s u*)^2

with the friction velocity u*, the bore's radius R, the distance r from its axis and y from its wall, the outward normal n,
and half of the body's greatest diameter a. g has three components of unit variance and unit memory, an Ornstein-Uhlenbeck
process that is drawn once; tau and h are states of the motion.

A body spreads with the eddy diffusivity K = kappa u* y (1 - y / R) of the logarithmic law by Reynolds' analogy,
u*^2 (r / R) / |dU/dr|, which is bounded in the core by its mean over the radius, kappa u* R / 6 (Elder, J. Fluid Mech. 5
(1959), 544). Near the wall T falls with y: eddies there are small and short-lived.

The component normal to the wall fades as the body comes near it, because eddies do not pass the wall, and is zero when it
touches. A process with constant strength would then gather bodies at the wall. div S keeps them evenly spread
(Thomson, J. Fluid Mech. 180 (1987), 529): with x uniform and g + h normal, the Fokker-Planck equation is satisfied exactly
for any S and T. A tracer has the least a, a thousandth of R, where the viscous layer of a main begins.
"""

import math
from collections.abc import Iterable
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from driftform.types import FloatArray
from driftform.util.compiled import compiled
from driftform.util.cubic import cubic_between, cubic_point, cubic_slope
from driftform.util.small_vectors import ZERO, Vector, add, dot, scale, subtract
from driftform.water.flow import KARMAN, Gusts
from driftform.water.parts.profiles import MIN_WALL_DISTANCE, Bore

MIN_KNOTS, MAX_KNOTS = 1024, 131_072
"""Values of a walk, at equal steps of tau. Beyond them it repeats."""

CORE = 1 / 6
"""Bound of y (1 - y / R) in the diffusivity, relative to R: its mean from the wall to the axis."""

STATES = 4
"""States of the motion in gusts: tau and the three components of h."""

STEP, STRENGTH, MEMORY, CROSSING, SIZE, REACH = 4, 5, 6, 7, 8, 9
"""Indices in the array of a flow (:func:`driftform.water.velocity.flow_array`).

They are the step of tau; s, of a body; T u*^2 / K; beta times the body's speed through the water over s, m/s; and a, m.
"""


def gust_numbers(gusts: Gusts, radius: float, slip: float = 0.0, length: float = 0.0) -> tuple[float, ...]:
    """Return the numbers from :data:`STEP` up to :data:`CROSSING`.

    A body that moves through the water leaves eddies before they decay: its memory is T / sqrt(1 + (beta w / s u*)^2)
    (Csanady, J. Atmos. Sci. 20 (1963), 201; across the drift, where he has 2 beta, up to twice as fast, which is left out).

    Args:
        radius: of the bore, m, which decides the size of the eddies.
        slip: w, speed of the body through the water, m/s.
        length: of the body, m: it has the mean of the gusts at its two Gauss points.
    """
    strength = gusts.strength * math.sqrt((1 + _correlate(gusts, radius, length)) / 2)
    return gusts.smoothing, strength, gusts.memory / gusts.strength**2, gusts.crossing * slip / gusts.strength


def _correlate(gusts: Gusts, radius: float, length: float) -> float:
    """Return the correlation exp(-distance / size) of the gusts at the two Gauss points of a body.

    The size of the eddies is that in which a gust carries the water within its memory in the core, over beta.
    """
    size = gusts.memory * KARMAN * CORE * radius / gusts.strength
    return math.exp(-length / math.sqrt(3) * gusts.crossing / size)


def draw_gusts(gusts: Gusts, count: float, radius: float, length: float = 0.0) -> FloatArray:
    """Return a walk of at least ``count`` steps of tau, if that is not more than possible, (k, 12): g, its derivative, a gust's change along the body, its derivative.

    The last six are relative to the strength of a gust, 1/m. Both walks are stationary and periodic, sampled exactly and
    joined by a cubic spline: the process itself has no derivative, and eddies smaller than the agent do not move it.
    For the other parameters see :func:`gust_numbers`.
    """
    knots = 1 << (math.ceil(min(max(count, MIN_KNOTS), MAX_KNOTS)) - 1).bit_length()
    apart, correlation = length / math.sqrt(3), _correlate(gusts, radius, length)
    spectrum, differences = _shape_waves(knots, gusts.smoothing)
    noise = np.random.default_rng(gusts.seed).standard_normal((knots, 6))
    waves = spectrum * np.fft.rfft(noise, axis=0)
    waves[:, 3:] *= 2 * math.sqrt((1 - correlation) / (1 + correlation)) / apart if apart > 0 else 0.0
    values, slopes = (np.fft.irfft(array, knots, axis=0) for array in (waves, waves * differences))
    return np.ascontiguousarray(np.hstack([values[:, :3], slopes[:, :3], values[:, 3:], slopes[:, 3:]]))


@lru_cache(maxsize=16)
def _shape_waves(knots: int, smoothing: float) -> tuple[FloatArray, npt.NDArray[np.complex128]]:
    """Return the factors that turn waves of white noise into a walk, and those into its slopes, (knots // 2 + 1, 1)."""
    angles = 2 * np.pi * np.arange(knots // 2 + 1)[:, None] / knots
    kept = math.exp(-smoothing)
    spectrum = np.sqrt(1 - kept**2) / np.abs(1 - kept * np.exp(1j * angles))
    # Slopes of a periodic cubic spline: s[k-1] + 4 s[k] + s[k+1] = 3 (v[k+1] - v[k-1]) / step.
    differences = 6j * np.sin(angles) / (4 + 2 * np.cos(angles)) / smoothing
    for array in (spectrum, differences):
        array.setflags(write=False)
    return spectrum, differences


def shortest_memory(flow: FloatArray, bores: Iterable[tuple[float, float]]) -> float:
    """Return the shortest memory (s) that a body has in bores of (radius (m), friction velocity (m/s)): that at the wall."""
    rates = []
    for radius, friction in bores:
        y = max(limit_size(flow[SIZE], radius), flow[REACH])
        rates.append(friction * math.hypot(1.0, flow[CROSSING] / friction) / eddy_diffusivity(y, radius))
    return float(flow[MEMORY] / max(rates))


@compiled
def limit_size(size: float, radius: float) -> float:
    """Return the half diameter (m) of a body in a bore that the gusts know."""
    return min(max(size, MIN_WALL_DISTANCE * radius), 0.9 * radius)


@compiled
def eddy_diffusivity(y: float, radius: float) -> float:
    """Return the eddy diffusivity at ``y`` (m) from the wall of a bore, relative to the friction velocity, m."""
    y = min(y, 0.5 * radius)
    return KARMAN * min(y * (1.0 - y / radius), CORE * radius)


@compiled
def gust_motion(
    bore: Bore, mean: Vector, flow: FloatArray, walk: FloatArray, eddies: FloatArray
) -> tuple[Vector, Vector, Vector]:
    """Return a gust (m/s), its rate along the path of the water (m/s2), and its change along the body (1/s), world frame.

    Args:
        mean: velocity of the mean flow, m/s.
        flow: see :data:`STEP`.
        walk: from :func:`draw_gusts`.
        eddies: states tau and h in the first row; the second is filled with their rates, 1/s; (2, 4).
    """
    normal, R, r, friction = bore
    states, rates = eddies[0], eddies[1]
    if not friction > 0.0:
        for j in range(STATES):
            rates[j] = 0.0
        return ZERO, ZERO, ZERO
    y = max(R - r, MIN_WALL_DISTANCE * R)
    crossing = flow[CROSSING] / friction
    forget = friction / (flow[MEMORY] * eddy_diffusivity(max(y, flow[REACH]), R)) * math.sqrt(1.0 + crossing * crossing)
    sigma = flow[STRENGTH] * friction
    # q^2, its derivative outward, and q^2 / r.
    size = limit_size(flow[SIZE], R)
    near = size / ((R - size) * y)
    q = near * r
    fade, slope, bend = q * q, 2.0 * q * near * R / y, q * near
    if q >= 1.0:
        fade, slope, bend = 1.0, 0.0, 1.0 / r
    g, g1, along = _interpolate(states[0] / flow[STEP], walk, flow[STEP])
    gust, drift = add(g, (states[1], states[2], states[3])), -sigma * (slope + bend)
    rates[0] = forget
    for j in range(3):
        rates[1 + j] = drift * normal[j] - forget * states[1 + j]
    change = add(scale(forget, g1), (rates[1], rates[2], rates[3]))
    outward = dot(normal, gust)
    velocity = scale(sigma, subtract(gust, scale(fade * outward, normal)))
    # The normal turns with the part of the velocity that is across the pipe and along the wall.
    speed = math.sqrt(dot(mean, mean))
    axis = scale(1.0 / speed, mean) if speed > 0.0 else ZERO
    out = dot(normal, velocity)
    turning = subtract(velocity, add(scale(out, normal), scale(dot(axis, velocity), axis)))
    faded = fade * dot(normal, change) + slope * out * outward + bend * dot(turning, gust)
    change = subtract(change, add(scale(faded, normal), scale(bend * outward, turning)))
    return velocity, scale(sigma, change), scale(sigma, along)


@compiled
def _interpolate(place: float, walk: FloatArray, step: float) -> tuple[Vector, Vector, Vector]:
    """Return a walk at ``place`` steps, its derivative, and the second walk."""
    whole = math.floor(place)
    k, u = int(whole) % walk.shape[0], place - whole
    a, b = walk[k], walk[(k + 1) % walk.shape[0]]
    curve = cubic_between((a[0], a[1], a[2]), (a[3], a[4], a[5]), (b[0], b[1], b[2]), (b[3], b[4], b[5]), step)
    other = cubic_between((a[6], a[7], a[8]), (a[9], a[10], a[11]), (b[6], b[7], b[8]), (b[9], b[10], b[11]), step)
    return cubic_point(curve, u), scale(1.0 / step, cubic_slope(curve, u)), cubic_point(other, u)
