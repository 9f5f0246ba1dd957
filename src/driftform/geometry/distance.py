"""Distance from a meridian polyline, and its radius."""

import numpy as np

from driftform.types import FloatArray


def distance_from(points: FloatArray, contour: FloatArray) -> FloatArray:
    """Return the distance (m) of each point (n, 2) from a polyline, (n,)."""
    start, edge = contour[:-1], np.diff(contour, axis=0)
    keep = (edge**2).sum(axis=1) > 0
    start, edge = start[keep], edge[keep]
    offset = points[:, None] - start
    along = np.clip((offset * edge).sum(axis=2) / (edge**2).sum(axis=1), 0, 1)
    return np.asarray(np.linalg.norm(offset - along[:, :, None] * edge, axis=2).min(axis=1), dtype=np.float64)


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
