"""Surfaces of a body that can touch a wall: rims, which are circles about its axis, and domes, which are spheres."""

import math
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from driftform.types import Body, FloatArray
from driftform.util.compiled import allocating, compiled

MIN_EDGES = 3
"""Edges in a row with their ends on one circle about a point of the axis that make a dome.

Two edges lie on such a circle by chance: of a cone with a bevelled end, for example.
"""

LONGEST_STEP, MEAN_STEP = 0.5, 0.3
"""Largest angle (rad) between neighbouring vertices of a dome, and the largest mean; a coarser polygon has real rims.

Vertices at equal distances along the axis are far apart near the pole.
"""

ROUNDNESS = 5e-5
"""Largest distance of a dome's vertices from their circle, relative to its radius: coordinates are written with few digits."""


def touching_surfaces(body: Body) -> FloatArray:
    """Return the surfaces of a body that can touch a wall, (k, 5).

    A rim has x and r (m) of its vertex, and zeros. A dome has x of its centre and 0 (m), its radius (m), and the range of
    its normals' components along the axis; beyond them it ends in a rim. Contours are polylines: a dome is where the
    ends of at least :data:`MIN_EDGES` edges lie on one circle about a point of the axis.
    """
    return _find_surfaces(_sort_along(body.outer))


def refined_surfaces(body: Body, spacing: float) -> FloatArray:
    """Return the surfaces of a body with more rims on its flanks and end faces, at most ``spacing`` (m) apart, (k, 5).

    A wall that bulges into the water may touch there: :mod:`driftform.motion.forces.fitting_contact`. A rim of no radius is a
    point of the axis.
    """
    surfaces, vertices = touching_surfaces(body), find_hull(body.outer)
    domes = surfaces[surfaces[:, 2] > 0.0]
    ends = np.vstack([[vertices[0, 0], 0.0], vertices, [vertices[-1, 0], 0.0]])
    rows = []
    for a, b in pairwise(ends):
        apart = [np.abs(np.hypot(x - domes[:, 0], r) - domes[:, 2]) for x, r in (a, b)]
        on_dome = np.logical_and(*(d <= 1e2 * ROUNDNESS * domes[:, 2] for d in apart))
        count = math.ceil(float(np.hypot(*(b - a))) / spacing)
        if count > 0 and not on_dome.any():
            shares = np.arange(1, count)[:, None] / count
            rows.extend((a + shares * (b - a)).tolist())
    rows += [
        end.tolist()
        for end in ends[[0, -1]]
        if not np.isclose(np.hypot(end[0] - domes[:, 0], end[1]), domes[:, 2]).any()
    ]
    added = np.zeros((len(rows), 5))
    added[:, :2] = np.array(rows).reshape(-1, 2)
    return np.vstack([surfaces, added])


def find_hull(contour: FloatArray) -> FloatArray:
    """Return the vertices (x, r) of the convex hull of a contour (n, 2), from aft to fore, m, (k, 2).

    The bore of a pipe is convex: nothing else of a body can touch it.
    """
    return _find_upper_hull(_sort_along(contour))


def _sort_along(points: FloatArray) -> FloatArray:
    """Return points (x, r) in ascending order of x, and of r where x is the same, (n, 2)."""
    x, r = points.T
    return points[np.lexsort((r, x))]


@allocating
def _find_surfaces(points: FloatArray) -> FloatArray:
    """Return what :func:`touching_surfaces` does from the vertices (n, 2) of a contour, sorted by x."""
    vertices = _find_upper_hull(points)
    ends, count = _find_arcs(vertices), vertices.shape[0]
    surfaces, row, k = np.zeros((count, 5)), 0, 0
    while k < count:
        (x, r), end = (vertices[k, 0], vertices[k, 1]), ends[k]
        if end - k >= MIN_EDGES:
            last, height = vertices[end, 0], vertices[end, 1]
            centre = _centre_circle(x, r, last, height)
            radius = math.hypot(last - centre, height)
            surfaces[row, 0], surfaces[row, 2] = centre, radius
            surfaces[row, 3], surfaces[row, 4] = (max(-1.0, (x - centre) / radius), min(1.0, (last - centre) / radius))
            row += 1
            # The end of a dome is its own rim; what comes next may start with it.
            k = end if ends[end] - end >= MIN_EDGES else end + 1
        else:
            if r > 0.0:
                surfaces[row, 0], surfaces[row, 1] = x, r
                row += 1
            k += 1
    return surfaces[:row]


@allocating
def _find_arcs(vertices: FloatArray) -> npt.NDArray[np.int64]:
    """Return for each vertex (x, r) the last one on the circle that starts there; itself without such a circle, (n,).

    On a circle about a point of the axis, x^2 + r^2 is linear in x, with twice the centre as its slope. The circle through the
    first vertex and another passes all between them within the tolerance if its centre lies in all of their ranges.
    """
    count = vertices.shape[0]
    ends = np.empty(count, np.int64)
    for k in range(count):
        x, r = vertices[k, 0], vertices[k, 1]
        least, most, length, ends[k] = -math.inf, math.inf, 0.0, k
        for j in range(k + 1, count):
            dx, dr = vertices[j, 0] - vertices[j - 1, 0], vertices[j, 1] - vertices[j - 1, 1]
            if not dx > 0.0:
                break
            centre = _centre_circle(x, r, vertices[j, 0], vertices[j, 1])
            radius, step = math.hypot(x - centre, r), math.hypot(dx, dr)
            if centre < least or centre > most or step > LONGEST_STEP * radius:
                break
            slack, length = ROUNDNESS * radius * radius / (vertices[j, 0] - x), length + step
            least, most = max(least, centre - slack), min(most, centre + slack)
            if length <= MEAN_STEP * radius * (j - k):
                ends[k] = j
    return ends


@compiled
def _centre_circle(x0: float, r0: float, x1: float, r1: float) -> float:
    """Return where on the axis (m) the centre of a circle through two points (x, r) is."""
    return 0.5 * (x0 + x1) + 0.5 * (r1 - r0) * (r0 + r1) / (x1 - x0)


@allocating
def _find_upper_hull(points: FloatArray) -> FloatArray:
    """Return the vertices of the upper convex hull of points (n, 2) that are sorted by x (Andrew 1979)."""
    hull = np.empty_like(points)
    count = 0
    for k in range(points.shape[0]):
        x, r = points[k, 0], points[k, 1]
        while count >= 2:
            x0, r0, x1, r1 = hull[count - 2, 0], hull[count - 2, 1], hull[count - 1, 0], hull[count - 1, 1]
            if (x1 - x0) * (r - r0) - (r1 - r0) * (x - x0) < 0.0:
                break
            count -= 1
        hull[count, 0], hull[count, 1] = x, r
        count += 1
    return hull[:count]
