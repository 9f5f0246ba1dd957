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
    low, high = contour[:-1], contour[1:]
    spans = (np.minimum(low[:, 0], high[:, 0]) <= x + 1e-9) & (np.maximum(low[:, 0], high[:, 0]) >= x - 1e-9)
    low, high = low[spans], high[spans]
    run = high[:, 0] - low[:, 0]
    steep = np.abs(run) < 1e-9
    s = np.clip(np.divide(x - low[:, 0], run, out=np.zeros_like(run), where=~steep), 0, 1)
    radii = np.where(steep, np.maximum(low[:, 1], high[:, 1]), low[:, 1] + s * (high[:, 1] - low[:, 1]))
    return float(radii.max(initial=0.0))
