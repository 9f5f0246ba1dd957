"""Distance from a meridian polyline, its radius, and the polyline moved along its normals."""

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


MAX_MITRE = 4.0
"""Largest distance of a corner from its old place, over that of the edges beside it: a needle does not grow without bound."""


def offset_contour(contour: FloatArray, distance: float) -> FloatArray:
    """Return a contour (n, 2) of x and r from aft to fore, with each edge moved outward by ``distance`` (m).

    Corners are mitred, and ends stay on the axis. The distance is far below the length of an edge; so a contour does not cross itself.
    """
    edges = np.diff(contour, axis=0)
    lengths = np.hypot(edges[:, 0], edges[:, 1])
    if not distance or not lengths.any():
        return contour
    kept = np.concatenate([[True], lengths > 0])
    points, edges = contour[kept], edges[lengths > 0] / lengths[lengths > 0, None]
    normals = np.column_stack([-edges[:, 1], edges[:, 0]])
    # Beyond the axis the contour is its own mirror image.
    before, after = np.vstack([normals[:1] * (1, -1), normals]), np.vstack([normals, normals[-1:] * (1, -1)])
    mitres = (before + after) / np.maximum(1 + (before * after).sum(axis=1), 2 / MAX_MITRE**2)[:, None]
    moved = points + distance * mitres
    moved[:, 1] = np.maximum(moved[:, 1], 0.0)
    moved[[0, -1], 1] = points[[0, -1], 1]
    return np.asarray(moved)
