"""Projections of flights and bodies onto a plane: geometry, in metres."""

from itertools import pairwise
from typing import TypeAlias

import numpy as np

from driftform.types import Body, FloatArray, Trajectory
from driftform.util.rotations import matrix_from_quaternion

View: TypeAlias = tuple[int, int]
"""Indices of the world coordinates that run to the right and upward on the page."""

SIDE: View = (0, 2)
PLAN: View = (0, 1)


def drawing_times(trajectory: Trajectory, start: float = 0.0, stop: float = np.inf) -> FloatArray:
    """Return times from ``start`` to ``stop`` (s), dense enough to draw the path with straight lines, (n,)."""
    t = trajectory.t
    start, stop = min(max(start, t[0]), t[-1]), max(min(stop, t[-1]), t[0])
    # Three stations between samples are enough for the interpolating cubic to look smooth.
    fine = np.interp(np.arange(0, len(t) - 0.75, 0.25), np.arange(len(t)), t)
    return np.concatenate([[start], fine[(fine > start) & (fine < stop)], [stop]])


def across_in_view(along: FloatArray, view: View) -> FloatArray:
    """Return a unit vector in the plane of a view that is perpendicular to a direction, (3,)."""
    across = np.zeros(3)
    across[view[0]], across[view[1]] = -along[view[1]], along[view[0]]
    if np.linalg.norm(across) < 1e-9:
        across[view[0]] = 1.0
    return np.asarray(across / np.linalg.norm(across))


def silhouette(body: Body, quaternion: FloatArray, view: View, tolerance: float) -> list[FloatArray]:
    """Return convex polygons whose union is the silhouette of ``body`` in ``view``, in m from the core's centre.

    The contour is simplified to within ``tolerance`` (m). A frustum is convex, so its silhouette is the convex hull
    of those of its two rims. All polygons turn the same way: in one path with the nonzero rule, they merge.
    """
    axis = matrix_from_quaternion(quaternion)[:, 0]
    across = across_in_view(axis, view)
    # Angles 0 and pi are the silhouette's edges, so the width is exact with any number of points.
    angles = np.linspace(0, 2 * np.pi, 20, endpoint=False)
    circle = np.cos(angles)[:, None] * across + np.sin(angles)[:, None] * np.cross(axis, across)
    outer = simplify_polyline(body.outer, tolerance)
    rims = (outer[:, :1, None] * axis + outer[:, 1:, None] * circle)[:, :, list(view)]
    hulls = (convex_hull(np.vstack(pair)) for pair in pairwise(rims))
    return [hull for hull in hulls if len(hull) > 2]


def convex_hull(points: FloatArray) -> FloatArray:
    """Return the corners of the convex hull of ``points``, (n, 2) in m, anticlockwise, to 0.1 um (Andrew, 1979).

    In integers the turns are exact: a rim that is seen edge-on is so thin that rounding would lose its corners.
    """
    ordered = sorted({(int(x), int(y)) for x, y in np.rint(points * 1e7)})
    chains: list[tuple[int, int]] = []
    for run in (ordered, ordered[::-1]):
        chain: list[tuple[int, int]] = []
        for p in run:
            while len(chain) > 1:
                (ox, oy), (ax, ay) = chain[-2:]
                if (ax - ox) * (p[1] - oy) - (ay - oy) * (p[0] - ox) > 0:
                    break
                chain.pop()
            chain.append(p)
        chains += chain[:-1]
    return np.array(chains, dtype=np.float64).reshape(-1, 2) / 1e7


def simplify_polyline(points: FloatArray, tolerance: float) -> FloatArray:
    """Return the corners, (n, 2), that a polyline needs to stay within ``tolerance`` of the original.

    A flight has thousands of samples; its picture needs dozens. The algorithm is that of Ramer, Douglas and Peucker.
    """
    # Column by column, because a picture spends most of its time here.
    x, y = np.ascontiguousarray(points.T)
    keep = np.zeros(len(points), dtype=bool)
    keep[:1] = keep[-1:] = True
    stack = [(0, len(points) - 1)]
    while stack:
        first, last = stack.pop()
        if last - first < 2:
            continue
        along, up = float(x[last] - x[first]), float(y[last] - y[first])
        dx, dy = x[first + 1 : last] - x[first], y[first + 1 : last] - y[first]
        s = (dx * along + dy * up) / max(along * along + up * up, 1e-30)
        np.maximum(s, 0.0, out=s)
        np.minimum(s, 1.0, out=s)
        dx -= s * along
        dy -= s * up
        square = dx * dx + dy * dy
        middle = int(square.argmax())
        if square[middle] > tolerance * tolerance:
            split = first + 1 + middle
            keep[split] = True
            stack += [(first, split), (split, last)]
    return points[keep]
