"""Distances through the water: how close a flight comes to its targets in a pipe with parts.

In a straight pipe and in open water that is the straight distance. A pipe that bends or branches may bring two of its parts side by
side, and a flight in one does not come near a target in the other. There the distance is straight within a part, and to a part that shares
an opening with it; further away it leads straight to the centre of the next opening, along the axes, and straight to
the target from the last opening: :meth:`driftform.water.parts.layout.Layout.path_to_point`.
"""

from functools import lru_cache

import numpy as np

from driftform.motion.path.approach import Approach, closest_approach
from driftform.motion.path.interpolation import interpolate_positions
from driftform.types import End, Evaluation, FloatArray, Trajectory
from driftform.util.latest import keep_latest
from driftform.water import Pipe, Scenario
from driftform.water.pipe import Vector

WITHIN = 0.05
"""Share of the farthest distance within which a flight hits its target, if the study does not say it: the paper's 5 %."""

WITHIN_BORE = 0.5
"""Largest distance of this kind, relative to the radius of the bore."""

_BETWEEN = 4
"""Points of the path between two samples, the first one included, that are compared first."""

_ZOOMS, _ZOOM = 4, 16
"""How often the neighbourhood of the nearest of them is divided again, and into how many points on each side."""

_AROUND = 36
"""Points around the bore at which the farthest point of a pipe with parts is looked for: 0.1 % of the radius."""


def approach_targets(trajectory: Trajectory, scenario: Scenario) -> tuple[FloatArray, FloatArray]:
    """Return distance through the water (m) and time (s) of the closest approach to each target; two (targets,)."""
    points = scenario.target_array()
    if scenario.pipe.is_open or scenario.pipe.straight is not None:
        return closest_approach(trajectory, points)
    ways = [_ways_to(scenario.pipe, point) for point in scenario.target_points().values()]
    found = [_approach(trajectory, scenario.pipe, *way) for way in ways]
    return np.array([d for d, _ in found]), np.array([t for _, t in found])


def find_target_approaches(trajectory: Trajectory, scenario: Scenario) -> list[Approach]:
    """Return the closest approach to each target; its distance is that through the water."""
    distances, times = approach_targets(trajectory, scenario)
    positions = interpolate_positions(trajectory, times)
    return [Approach(float(d), float(t), p) for d, t, p in zip(distances, times, positions, strict=True)]


def find_offsets(evaluation: Evaluation, scenario: Scenario) -> FloatArray:
    """Return the vector from each target to the closest approach, m, (targets, 3); NaN if the flight failed.

    A flight that did not converge counts up to where it did: it has an offset from each target that it passed before.
    In a pipe with parts an offset is as long as the way through the water.
    """
    points, flight = scenario.target_array(), evaluation.trajectory
    if evaluation.offsets is not None:
        return evaluation.offsets
    counts = evaluation.failure is None or (flight is not None and flight.end is End.NOT_CONVERGED)
    if flight is None or not counts:
        return np.full(points.shape, np.nan)
    approaches = find_target_approaches(flight, scenario)
    offsets = np.array([approach.position for approach in approaches]).reshape(points.shape) - points
    if evaluation.failure is not None:
        offsets[[approach.t >= flight.t[-1] for approach in approaches]] = np.nan
    if scenario.pipe.is_open or scenario.pipe.straight is not None:
        return np.asarray(offsets)
    straight = np.maximum(np.linalg.norm(offsets, axis=1), np.finfo(float).tiny)
    through = np.array([approach.distance for approach in approaches])
    return np.asarray(offsets * (through / straight)[:, None])


@keep_latest
def farthest_distances(scenario: Scenario) -> FloatArray:
    """Return for each target the greatest distance through the water to a point of the pipe's volume, m, (targets,)."""
    return _farthest_distances(scenario.pipe, tuple(scenario.target_points().values()))


def find_within(scenario: Scenario) -> FloatArray:
    """Return how near a flight must pass each target to hit it, m, (targets,): that of the study, or :data:`WITHIN`.

    Without a distance of the study it is at most half the radius of the bore: in a narrow pipe any flight would hit.
    """
    within = scenario.robustness.within
    given = within if isinstance(within, dict) else dict.fromkeys(scenario.targets, within)
    usual = WITHIN * farthest_distances(scenario)
    if not scenario.pipe.is_open:
        usual = np.minimum(usual, WITHIN_BORE * _find_bores(scenario))
    return np.array([given.get(name) or d for name, d in zip(scenario.targets, usual.tolist(), strict=True)])


def _find_bores(scenario: Scenario) -> FloatArray:
    """Return the radius of the bore at each target, m, (targets,): that at the nearest point of an axis."""
    axes = [axis for bound in scenario.pipe.layout.parts for axis in bound.part.list_axes(0.1 * bound.part.radius)]
    points, radii = np.vstack([axis.points for axis in axes]), np.concatenate([axis.radii for axis in axes])
    nearest = [np.linalg.norm(points - point, axis=1).argmin() for point in scenario.target_array()]
    return np.asarray(radii[nearest])


def name_outlet(trajectory: Trajectory, scenario: Scenario) -> str | None:
    """Return the name of the outlet by which a flight left the pipe; ``None`` if it did not."""
    if trajectory.end is not End.OUTLET or scenario.pipe.is_open:
        return None
    # The flight ends in the plane of its outlet: its bore holds the last position. Other openings in this plane do not.
    position, distances = trajectory.position[-1], {}
    for outlet in scenario.pipe.layout.outlets:
        off = outlet.opening.axes @ (position - outlet.opening.centre)
        beyond = max(0.0, float(np.hypot(off[1], off[2])) - outlet.opening.radius)
        distances[outlet.name] = float(np.hypot(off[0], beyond))
    return min(distances, key=lambda name: distances[name])


@lru_cache(maxsize=16)
def _farthest_distances(pipe: Pipe, targets: tuple[Vector, ...]) -> FloatArray:
    if pipe.is_open or pipe.straight is not None:
        return np.array([pipe.farthest_distance(np.array(target)) for target in targets])
    parts = [placed.part for placed in pipe.layout.parts]
    walls = [np.concatenate(part.list_rims(0.1 * part.radius, _AROUND)).reshape(-1, 3) for part in parts]
    farthest = []
    for target in targets:
        firsts, rests = _ways_to(pipe, target)
        ways = zip(walls, firsts, rests, strict=True)
        farthest.append(max(float(np.linalg.norm(wall - first, axis=1).max()) + rest for wall, first, rest in ways))
    return np.array(farthest)


@lru_cache(maxsize=64)
def _ways_to(pipe: Pipe, target: Vector) -> tuple[FloatArray, FloatArray]:
    """Return where the way from each part to a target leads first (m, (parts, 3)), and its rest (m, (parts,))."""
    layout, point = pipe.layout, np.array(target)
    there = int(layout.find_part(point[None])[0])
    ways = [layout.path_to_point(index, there, point) for index in range(len(layout.parts))]
    return np.array([first for first, _ in ways]), np.array([rest for _, rest in ways])


def _approach(trajectory: Trajectory, pipe: Pipe, firsts: FloatArray, rests: FloatArray) -> tuple[float, float]:
    samples = trajectory.t
    if len(samples) == 1:
        times = samples
    else:
        steps = np.arange(_BETWEEN) / _BETWEEN
        times = np.append((samples[:-1, None] + np.diff(samples)[:, None] * steps).ravel(), samples[-1])
    distances = _distances_at(trajectory, times, pipe, firsts, rests)
    best = int(distances.argmin())
    for _ in range(_ZOOMS if len(samples) > 1 else 0):
        low, high = times[max(best - 1, 0)], times[min(best + 1, len(times) - 1)]
        times = np.linspace(low, high, 2 * _ZOOM + 1)
        distances = _distances_at(trajectory, times, pipe, firsts, rests)
        best = int(distances.argmin())
    return float(distances[best]), float(times[best])


def _distances_at(
    trajectory: Trajectory, times: FloatArray, pipe: Pipe, firsts: FloatArray, rests: FloatArray
) -> FloatArray:
    """Return the distances through the water at some times, m, (n,)."""
    points = interpolate_positions(trajectory, times)
    part = pipe.layout.find_part(points)
    # A point that is in no part is upstream of the inlet: it counts for the first part.
    part = np.maximum(part, 0)
    return np.asarray(np.linalg.norm(points - firsts[part], axis=1) + rests[part])
