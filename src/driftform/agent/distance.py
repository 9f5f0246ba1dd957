"""Distance from a meridian polyline, and its radius."""

import numpy as np

from driftform.types import FloatArray


def distance_from(points: FloatArray, contour: FloatArray) -> FloatArray:
    """Return the distance (m) of each point (n, 2) from a polyline, (n,)."""
    start, edge = contour[:-1], contour[1:] - contour[:-1]
    square = edge[:, 0] ** 2 + edge[:, 1] ** 2
    if not square.all():
        keep = square > 0
        start, edge, square = start[keep], edge[keep], square[keep]
    # Coordinates apart: arrays whose last axis has length two take numpy several times as long.
    (x0, r0), (run, rise) = start.T, edge.T
    x, r = points[:, :1] - x0, points[:, 1:] - r0
    along = np.minimum(np.maximum((x * run + r * rise) / square, 0.0), 1.0)
    x -= along * run
    r -= along * rise
    distance: FloatArray = np.sqrt((x * x + r * r).min(axis=1))
    return distance


def radius_at(contour: FloatArray, x: float) -> float:
    """Return the radius (m) of the contour at ``x``, the greatest one where the contour has a step."""
    return float(radii_at(contour, np.array([x]))[0])


def radii_at(contour: FloatArray, x: FloatArray) -> FloatArray:
    """Return the radius (m) of the contour at each of ``x`` (n,), as :func:`radius_at` does; zero beyond the ends."""
    low, high = contour[:-1], contour[1:]
    at, run = x[:, None], high[:, 0] - low[:, 0]
    spans = (np.minimum(low[:, 0], high[:, 0]) <= at + 1e-9) & (np.maximum(low[:, 0], high[:, 0]) >= at - 1e-9)
    steep = np.abs(run) < 1e-9
    s = np.clip((at - low[:, 0]) / np.where(steep, 1.0, run), 0, 1)
    radii = np.where(steep, np.maximum(low[:, 1], high[:, 1]), low[:, 1] + s * (high[:, 1] - low[:, 1]))
    return np.asarray(np.where(spans, radii, 0.0).max(axis=1, initial=0.0))
