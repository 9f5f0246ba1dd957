"""Tracers in the water of a straight pipe: fixed steps of the fourth order of the kernels' own functions, without inertia."""

import numpy as np

from driftform.util.compiled import allocating
from driftform.util.small_vectors import add
from driftform.water import Scenario
from driftform.water.gusts import STATES, draw_gusts
from driftform.water.parts.profiles import MIN_WALL_DISTANCE
from driftform.water.velocity import flow_array, gust_at, pipe_rows, set_gusts, water_motion

KNOTS = 65_536
"""Steps of a walk, which many tracers share."""


def straight_pipe(radius, speed, length=None, **tables):
    """Return a straight pipe, 100 radii long unless said otherwise, with gusts in the logarithmic law of water."""
    segment = {"start": [0, 0, 0], "end": [length or 100 * radius, 0, 0], "radius": radius}
    flow, fluid = {"kind": "turbulent", "speed": speed}, {"viscosity": 1.1e-6}
    return Scenario.model_validate({"pipe": {"segments": [segment]}, "flow": flow, "fluid": fluid, **tables})


def spread_evenly(count, radius):
    """Return points of a section, evenly over its area by a sunflower's spiral, (count, 3)."""
    k = np.arange(count) + 0.5
    # Not in the layer at the wall in which gusts do not move a tracer.
    r, angle = (1 - MIN_WALL_DISTANCE) * radius * np.sqrt(k / count), k * np.pi * (3 - np.sqrt(5))
    return np.column_stack([np.zeros(count), r * np.cos(angle), r * np.sin(angle)])


def carry(scenario, start, times, size=0.0, seed=0):
    """Return positions (k, n, 3) at ``times`` (s, (k,)) of tracers from ``start`` (n, 3), each in a part of its own of a walk.

    Bodies of half a diameter ``size`` (m) have the gusts of theirs.
    """
    flow = flow_array(scenario).copy()
    set_gusts(flow, scenario, size)
    rng = np.random.default_rng(seed)
    # Twenty tracers share a walk, and begin at places of it that are far apart.
    walks = [
        draw_gusts(
            scenario.gusts.model_copy(update={"seed": int(rng.integers(2**40))}),
            KNOTS,
            scenario.pipe.layout.inlet.radius,
        )
        for _ in range(-(-len(start) // 20))
    ]
    begin = rng.uniform(0, 20, len(start)) + (np.arange(len(start)) % 20) * KNOTS * scenario.gusts.smoothing / 20
    return _carry(np.ascontiguousarray(start), begin, times, pipe_rows(scenario), flow, np.concatenate(walks))


@allocating
def _carry(start, begin, times, pipe, flow, walks):
    out = np.empty((times.shape[0], start.shape[0], 3))
    eddies, y, new, slope = np.zeros((2, STATES)), np.zeros(7), np.zeros(7), np.zeros((4, 7))
    for i in range(start.shape[0]):
        walk = walks[(i // 20) * KNOTS : (i // 20 + 1) * KNOTS]
        for j in range(7):
            y[j] = start[i, j] if j < 3 else 0.0
        y[3] = begin[i]
        t = 0.0
        for k in range(times.shape[0]):
            while t < times[k]:
                _fill(y, pipe, flow, walk, eddies, slope[0])
                # A tenth of the memory here, half of a step of the walk.
                h = min(0.1 / slope[0, 3], times[k] - t)
                for stage in range(1, 4):
                    share = h if stage == 3 else 0.5 * h
                    for j in range(7):
                        new[j] = y[j] + share * slope[stage - 1, j]
                    _fill(new, pipe, flow, walk, eddies, slope[stage])
                for j in range(7):
                    y[j] += h / 6 * (slope[0, j] + 2 * slope[1, j] + 2 * slope[2, j] + slope[3, j])
                t = times[k] if t + h >= times[k] - 1e-12 else t + h
            for j in range(3):
                out[k, i, j] = y[j]
    return out


@allocating
def _fill(y, pipe, flow, walk, eddies, out):
    for j in range(4):
        eddies[0, j] = y[3 + j]
    point = (y[0], y[1], y[2])
    mean = water_motion(point, 0.0, pipe, flow)[0]
    velocity = add(mean, gust_at(point, mean, pipe, flow, walk, eddies)[0])
    for j in range(3):
        out[j] = velocity[j]
    for j in range(4):
        out[3 + j] = eddies[1, j]
