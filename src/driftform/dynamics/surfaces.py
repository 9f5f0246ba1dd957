"""Surfaces of a body that can touch a wall: rims, which are circles about its axis, and domes, which are spheres."""

import math
from itertools import pairwise

import numpy as np

from driftform.types import Body, FloatArray
from driftform.util.compiled import allocating

FEWEST_EDGES = 3
"""Edges in a row with their ends on one circle about a point of the axis that make a dome.

Two edges lie on such a circle by chance: of a cone with a bevelled end, for example.
"""

LONGEST_STEP = 0.3
"""Largest angle (rad) between neighbouring vertices of a dome; a coarser polygon has real rims."""

ROUNDNESS = 1e-5
"""Largest difference between the circles of a dome's edges, relative to their radius."""

SURFACE = 6
"""Numbers of a surface."""


def touching_vertices(body: Body) -> FloatArray:
    """Return the vertices (x, r) of the body's convex hull, from aft to fore, m, (k, 2).

    The bore of a pipe is convex, so a body is inside exactly if its convex hull is: nothing else can touch. Vertices
    on the axis are included.
    """
    x, r = body.outer.T
    return _upper_hull(body.outer[np.lexsort((r, x))])


def touching_rims(body: Body) -> FloatArray:
    """Return the vertices (x, r) of the body's convex hull that are off the axis, m, (k, 2)."""
    hull = touching_vertices(body)
    return hull[hull[:, 1] > 0.0]


def touching_surfaces(body: Body) -> FloatArray:
    """Return the surfaces of a body that can touch a wall, (k, 5).

    A rim has x and r (m) of its vertex, and zeros. A dome has x of its centre and 0 (m), its radius (m), and the range of
    its normals' components along the axis; beyond them it ends in a rim. Contours are polylines: a dome is where the
    ends of at least :data:`FEWEST_EDGES` edges lie on one circle about a point of the axis.
    """
    vertices = touching_vertices(body)
    ends = _find_arcs(vertices)
    points = vertices.tolist()
    rows: list[tuple[float, ...]] = []
    k, last = 0, len(points) - 1
    while k <= last:
        end = ends[k]
        if end - k >= FEWEST_EDGES:
            (x0, r0), (x1, r1) = points[k], points[end]
            x = 0.5 * (x0 + x1) + 0.5 * (r1 - r0) * (r0 + r1) / (x1 - x0)
            radius = math.hypot(x1 - x, r1)
            aft, fore = ((points[i][0] - x) / radius for i in (k, end))
            rows.append((x, 0.0, radius, max(-1.0, aft), min(1.0, fore)))
            k = end
            # The end of a dome is its own rim; what comes next may start with it.
            k += 0 if ends[k] - k >= FEWEST_EDGES else 1
        else:
            if points[k][1] > 0.0:
                rows.append((*points[k], 0.0, 0.0, 0.0))
            k += 1
    return np.array(rows).reshape(-1, 5)


def refined_surfaces(body: Body, spacing: float) -> FloatArray:
    """Return the surfaces of a body with more rims on its flanks and end faces, at most ``spacing`` (m) apart, (k, 5).

    A wall that bulges into the water may touch there: :mod:`driftform.dynamics.fitting_contact`. A rim of no radius is a
    point of the axis.
    """
    surfaces, vertices = touching_surfaces(body), touching_vertices(body)
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


def _find_arcs(vertices: FloatArray) -> list[int]:
    """Return for each vertex (x, r) the last one on the circle through it and the next; itself without such a circle."""
    (x, r), (dx, dr) = vertices[:-1].T, np.diff(vertices, axis=0).T
    # An edge across the axis has no such circle.
    with np.errstate(divide="ignore", invalid="ignore"):
        centres = x + 0.5 * dx + dr * (r + 0.5 * dr) / dx
        radii = np.hypot(x - centres, r)
        change = np.maximum(np.abs(np.diff(centres)), np.abs(np.diff(radii)))
    curved = (dx > 0.0) & (np.hypot(dx, dr) <= LONGEST_STEP * radii)
    continued = [*(curved[1:] & (change <= ROUNDNESS * radii[:-1])).tolist(), False]
    ends = list(range(len(vertices)))
    for k, is_curved in reversed(list(enumerate(curved.tolist()))):
        if is_curved:
            ends[k] = ends[k + 1] if continued[k] else k + 1
    return ends


@allocating
def _upper_hull(points: FloatArray) -> FloatArray:
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
