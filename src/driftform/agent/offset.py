"""A meridian contour moved along its own normals."""

import numpy as np

from driftform.types import FloatArray

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
