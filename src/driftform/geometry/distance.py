"""Distances from a meridian polyline."""

import numpy as np

from driftform.types import FloatArray


def distance_from(points: FloatArray, contour: FloatArray) -> FloatArray:
    """Distance (m) of each point (n, 2) from a polyline, (n,)."""
    start, edge = contour[:-1], np.diff(contour, axis=0)
    keep = (edge**2).sum(axis=1) > 0
    start, edge = start[keep], edge[keep]
    offset = points[:, None] - start
    along = np.clip((offset * edge).sum(axis=2) / (edge**2).sum(axis=1), 0, 1)
    return np.asarray(np.linalg.norm(offset - along[:, :, None] * edge, axis=2).min(axis=1), dtype=np.float64)
