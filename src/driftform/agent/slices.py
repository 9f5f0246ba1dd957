"""A solid of revolution cut into slices across its axis."""

import numpy as np
import numpy.typing as npt

from driftform.types import FloatArray


def slice_solid(contour: npt.ArrayLike, count: int) -> FloatArray:
    """Cut a solid of revolution into ``count`` slices of equal width.

    Args:
        contour: x and r of the meridian, m, (n, 2), as in :func:`driftform.agent.solid_of_revolution`.

    Returns:
        numpy.ndarray: x of the slice's centroid (m), its volume (m3) and its width (m), (count, 3). Volumes and
            centroids are exact: combined, they are those of the solid.
    """
    points: FloatArray = np.asarray(contour, dtype=np.float64)
    x0, x1, r0, r1 = points[:-1, 0], points[1:, 0], points[:-1, 1], points[1:, 1]
    stations = np.linspace(points[:, 0].min(), points[:, 0].max(), count + 1)
    h = x1 - x0
    slope = np.divide(r1 - r0, h, out=np.zeros_like(h), where=h != 0)
    # The part of each edge's frustum aft of each station, (count + 1, edges).
    a = np.broadcast_to(np.minimum(x0, x1), (count + 1, len(h)))
    b = np.clip(stations[:, None], a, np.maximum(x0, x1))
    ra, rb = r0 + slope * (a - x0), r0 + slope * (b - x0)
    width = b - a
    volume = np.pi * width * (ra * ra + ra * rb + rb * rb) / 3
    first = a * volume + np.pi * width**2 * (ra * ra + 2 * ra * rb + 3 * rb * rb) / 12
    sign = np.sign(h)
    volumes = np.diff((volume * sign).sum(axis=1))
    firsts = np.diff((first * sign).sum(axis=1))
    middle = (stations[:-1] + stations[1:]) / 2
    centroids = np.divide(firsts, volumes, out=middle, where=volumes > 0)
    return np.column_stack([centroids, volumes, np.diff(stations)])
