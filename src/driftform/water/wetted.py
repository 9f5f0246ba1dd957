"""The part of a bore below a free surface: where a study may have one, and how fast the water flows there."""

import numpy as np

from driftform.water.flow import Flow, PipeFlow
from driftform.water.pipe import Pipe, Segment

LEVEL = 1e-6
"""Largest slope of a pipe that counts as level."""

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(40)


def find_surface_fault(pipe: Pipe, flow: Flow, level: float) -> str | None:
    """Return why the flow below a surface at ``level`` (m) is not known, without the key; ``None`` if it is.

    In a level straight pipe the water fills the same section everywhere; a surface that cuts parts of a pipe, or a pipe
    with a slope, has other sections, and rises and falls with the flow.
    """
    if pipe.is_open:
        return None
    low, high = _find_heights(pipe)
    if not low < level < high:
        return None
    reach = f"whose bore reaches from z {low:.4g} to {high:.4g} m"
    segment = pipe.straight
    if segment is None:
        return f"cuts a pipe with parts, {reach}: the flow with a surface in it is not known; fill the pipe"
    if isinstance(flow, PipeFlow) and abs(segment.end[2] - segment.start[2]) > LEVEL * _measure(segment):
        return f"cuts a pipe with a slope, {reach}: the flow below it is not known; make the pipe level, or fill it"
    return None


def _measure(segment: Segment) -> float:
    return float(np.linalg.norm(np.subtract(segment.end, segment.start)))


def _find_heights(pipe: Pipe) -> tuple[float, float]:
    """Return the lowest and the highest point of the bore, m."""
    low, high = np.inf, -np.inf
    for placed in pipe.layout.parts:
        for axis in placed.part.list_axes(0.1 * placed.part.radius):
            along = np.gradient(axis.points, axis=0)
            level = np.hypot(along[:, 0], along[:, 1]) / np.linalg.norm(along, axis=1)
            low = min(low, float((axis.points[:, 2] - axis.radii * level).min()))
            high = max(high, float((axis.points[:, 2] + axis.radii * level).max()))
    return low, high


def wetted_speed(pipe: Pipe, flow: PipeFlow, kind: float, parameter: float, level: float | None) -> float:
    """Return the mean speed (m/s) of the profile in the full bore whose mean below the surface is ``flow.speed``.

    The profile is that of the full bore: the surface neither drags nor bends it. The volume flow of a study is then that
    through the wetted section, speed times area.

    Args:
        pipe: straight and level, or full.
        kind, parameter: of the profile, see :func:`driftform.water.parts.profiles.velocity_profile`.
        level: height of the surface, m; ``None`` for a full pipe.
    """
    segment = pipe.straight
    if level is None or segment is None:
        return flow.speed
    # Imported here: it loads the compiler.
    from driftform.water.parts.profiles import velocity_profile

    radius, height = segment.radius, level - segment.start[2]
    if not -radius < height < radius:
        return flow.speed
    middle = 0.5 * _measure(segment)
    total, area = 0.0, 0.0
    # The share of a circle about the axis that lies below has a kink where circles begin to reach the surface; level with the axis they all do.
    for low, high in ((0.0, abs(height)), (abs(height), radius))[height == 0.0 :]:
        r = 0.5 * (low + high + (high - low) * _NODES)
        weights = 0.5 * (high - low) * _WEIGHTS * r * (1 - np.arccos(np.clip(height / r, -1, 1)) / np.pi)
        speeds = [velocity_profile(radius, middle, float(s), kind, flow.speed, parameter)[0] for s in r]
        total += float(weights @ speeds)
        area += float(weights.sum())
    return flow.speed * flow.speed * area / total
