"""The data of a page that shows agents in space: agents, flights, pipe, current and targets, read by ``viewer.js``."""

from collections.abc import Sequence
from importlib.resources import files
from typing import Any

import numpy as np

from driftform.figures.projection import simplify_polyline
from driftform.motion.path.interpolation import interpolate_positions
from driftform.types import Agent, FloatArray, Trajectory
from driftform.water import Pipe, Scenario
from driftform.water.flow import UniformFlow
from driftform.water.parts.layout import Layout
from driftform.water.parts.shapes import Straight, Tee, place_on_axis

__all__ = ["agent_data", "read_viewer", "scene_data", "simplify_polyline"]

MAX_SAMPLES = 240
"""Greatest number of samples of a flight on a page."""

CONTOUR_TOLERANCE = 5e-5
"""Tolerance to which the contours of a page are simplified, m."""

STREAMS = 40
"""Number of paths of the mean current through a pipe with parts."""

NEAREST = 0.97
"""Greatest distance of a path from the axis, in radii of the bore."""

PROFILE = 9
"""Number of radii at which a page has the speed of the current."""


def read_viewer() -> str:
    """Return the script that draws a scene on a canvas of a page."""
    return files("driftform.figures").joinpath("viewer.js").read_text(encoding="utf-8")


def scene_data(scenario: Scenario, paths: Sequence[FloatArray] = ()) -> dict[str, Any]:
    """Return the data of what surrounds agents: pipe, current, targets, free surface and extent.

    ``paths`` are the positions of flights, m, (n, 3) each, which give open water its extent.
    """
    rows = scenario.pipe.array()
    chords = _list_chords(scenario.pipe) if scenario.pipe.straight is None else []
    seen = np.vstack([rows[:, :3], rows[:, 3:6], *(np.array([start, end]) for start, end, _ in chords)])
    if not len(seen):
        seen = np.vstack([scenario.target_array(), scenario.release_position(), *paths])
    low, high = seen.min(axis=0), seen.max(axis=0)
    length = float(np.linalg.norm(high - low))
    radius = float(max([*rows[:, 6], *(r for _, _, r in chords)], default=length / 8))
    return {
        "pipe": [
            {
                "start": _round(r[:3]),
                "end": _round(r[3:6]),
                "radius": float(r[6]),
                "speeds": _round(_speed_profile(scenario, r)),
            }
            for r in rows
        ],
        "streams": [_round(path, 4) for path in list_streams(scenario)],
        "chords": [{"start": _round(a), "end": _round(b), "radius": r} for a, b, r in chords],
        "targets": [{"name": name, "position": list(point)} for name, point in scenario.target_points().items()],
        "water": scenario.fluid.water_level,
        "centre": _round((low + high) / 2),
        "extent": [_round(low[:2] - radius), _round(high[:2] + radius)],
        "length": length,
        "size": radius,
    }


def _list_chords(pipe: Pipe) -> list[tuple[FloatArray, FloatArray, float]]:
    """Return the bores of a pipe with parts as short straight pieces: start, end, and radius, m."""
    chords: list[tuple[FloatArray, FloatArray, float]] = []
    for placed in pipe.layout.parts:
        part = placed.part
        for axis in part.list_axes(part.length if isinstance(part, Straight) else 0.5 * part.end_radius):
            radii = 0.5 * (axis.radii[1:] + axis.radii[:-1])
            chords += list(zip(axis.points[:-1], axis.points[1:], radii.tolist(), strict=True))
    return chords


def list_streams(scenario: Scenario) -> list[FloatArray]:
    """Return paths of the mean current of a pipe with parts: time (s) and position (m) at each point, (n, 4) each.

    They lead along the axes from the inlet to the outlets, as many to each as its share of the water, at the mean speed of
    each bore.
    """
    layout, streams = scenario.pipe.layout, list[FloatArray]()
    if scenario.pipe.is_open or scenario.pipe.straight is not None or scenario.flow.speed <= 0:
        return []
    for outlet in layout.outlets:
        feet, axes, radii, flows = map(np.concatenate, zip(*_list_bores(layout, outlet.part), strict=True))
        slowness = radii**2 / (flows * scenario.flow.speed * layout.inlet.radius**2)
        lengths = np.linalg.norm(np.diff(feet, axis=0), axis=1)
        t = np.append(0.0, np.cumsum(lengths * (slowness[1:] + slowness[:-1]) / 2))
        for k in range(round(STREAMS * flows[-1])):
            # The middle of parts of the section of equal area, on the spiral of sunflowers.
            away, angle = np.sqrt((k + 0.5) / (STREAMS * flows[-1])), np.pi * (3 - np.sqrt(5)) * k
            aside = np.cos(angle) * axes[:, 1] + np.sin(angle) * axes[:, 2]
            streams.append(np.column_stack([t, feet + NEAREST * away * radii[:, None] * aside]))
    return streams


def _list_bores(layout: Layout, last: int) -> list[tuple[FloatArray, ...]]:
    """Return the bores from the inlet to the end of a part: points of the axis, axes, radii, and shares of the water there."""
    bores: list[tuple[FloatArray, ...]] = []
    index: int | None = last
    by_branch, flow = False, layout.parts[last].flow
    while index is not None:
        placed, part = layout.parts[index], layout.parts[index].part
        spans: list[tuple[float, float, float | None, float]] = [(0.0, part.length, None, flow)]
        if by_branch and isinstance(part, Tee):
            middle, end = part.legs[0], part.legs[0] + part.legs[2]
            spans = [(middle, end, part.branch_radius, flow), (0.0, middle, None, placed.flow)]
        for begin, end, radius, share in spans:
            count = 2 if isinstance(part, Straight) else 2 + round((end - begin) / (0.3 * part.narrowest))
            # The first point is the last one of the bore before.
            along = np.linspace(begin, end, count)[1 if begin or placed.upstream is not None else 0 :]
            radii = part.bore_radii(along) if radius is None else np.full(len(along), radius)
            bores.insert(0, (*place_on_axis(part, along, radius is not None), radii, np.full(len(along), share)))
        index, by_branch, flow = placed.upstream, placed.by_branch, placed.flow
    return bores


def _speed_profile(scenario: Scenario, row: FloatArray) -> FloatArray:
    """Return the mean speed half-way down a segment of the pipe, m/s: :data:`PROFILE` values from the axis to the wall."""
    if isinstance(scenario.flow, UniformFlow):
        return np.full(PROFILE, scenario.flow.speed)
    from driftform.water.field import water_velocity

    start, along, radius = row[:3], row[3:6] - row[:3], row[6]
    axis = along / np.linalg.norm(along)
    aside = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    points = start + along / 2 + np.linspace(0, radius, PROFILE)[:, None] * aside / np.linalg.norm(aside)
    return np.asarray(water_velocity(points, 0.0, scenario) @ axis)


def agent_data(agent: Agent, flight: Trajectory, closest: Sequence[float], colour: str) -> dict[str, Any]:
    """Return the data of an agent and its flight, which passes its targets at the times ``closest``, s."""
    body = agent.body
    # Evenly in time, and at the closest approaches.
    t = np.array(sorted({*np.linspace(flight.t[0], flight.t[-1], MAX_SAMPLES - 1).tolist(), *closest}))
    nearest = np.clip(np.searchsorted(flight.t, t), 0, len(flight.t) - 1)
    return {
        "colour": colour,
        "outer": _round(simplify_polyline(body.outer, CONTOUR_TOLERANCE), 6),
        "cavity": _round(simplify_polyline(body.cavity, CONTOUR_TOLERANCE), 6) if len(body.cavity) else [],
        "joints": _round(body.joints, 6),
        "core": _round(np.array(body.core.contour)) if body.core.contour else body.core.radius,
        "closest": round(closest[0], 4),
        "flight": {
            "t": _round(t, 4),
            "position": _round(interpolate_positions(flight, t), 4),
            "quaternion": _round(flight.quaternion[nearest], 4),
        },
    }


def _round(values: FloatArray, digits: int = 6) -> Any:
    return np.round(values, digits).tolist()
