"""Bodies made from given contours, and geometry of meridian polylines, independent of any builder."""

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from driftform.agent import distance_from
from driftform.types import Body, BoolArray, Core, FloatArray


def make_body(outer: npt.ArrayLike, cavity: npt.ArrayLike = ()) -> Body:
    """Return a body of ABS with the given contours (m), around a core without mass."""
    contour: FloatArray = np.asarray(outer, dtype=np.float64)
    return Body(
        outer=contour,
        cavity=np.asarray(cavity, dtype=np.float64).reshape(-1, 2),
        joints=np.array([contour[:, 0].min(), contour[:, 0].max()]),
        core=Core(radius=1e-3, mass=0.0),
        wall=1.25e-3,
        hull_density=1050.0,
    )


def spheroid_body(a: float, b: float, edges: int = 64) -> Body:
    """Return a solid spheroid about the origin, with the half axis ``a`` along x and the radius ``b``, m."""
    angles = np.linspace(np.pi, 0, edges + 1)
    contour = np.column_stack([a * np.cos(angles), b * np.sin(angles)])
    contour[[0, -1], 1] = 0.0
    return make_body(contour)


def cylinder_body(length: float, radius: float) -> Body:
    """Return a solid cylinder about the origin, m."""
    h = length / 2
    return make_body([(-h, 0), (-h, radius), (h, radius), (h, 0)])


def dome_body(radius: float, edges: int = 32) -> Body:
    """Return a solid half sphere, round aft and flat at the fore end, m."""
    angles = np.linspace(np.pi, np.pi / 2, edges + 1)
    contour = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    contour[0, 1] = contour[-1, 0] = 0.0
    return make_body([*contour, (0.0, 0.0)])


def hollow_body() -> Body:
    """Return a capped tube, 60 mm long and 30 mm thick, wide enough for a core of 10 mm radius at the origin."""
    hull = [(-0.03, 0), (-0.03, 0.015), (0.02, 0.015), (0.03, 0.012), (0.03, 0)]
    cavity = [(-0.028, 0), (-0.028, 0.013), (0.02, 0.013), (0.028, 0.0105), (0.028, 0)]
    return replace(make_body(hull, cavity), core=Core(radius=0.01, mass=0.05))


def mirrored_contour(contour: FloatArray) -> FloatArray:
    """Return the contour with fore and aft exchanged, from the aft to the fore axis point, (n, 2)."""
    return np.asarray(contour[::-1] * (-1.0, 1.0), dtype=np.float64)


def mirrored_body(body: Body) -> Body:
    """Return the body with fore and aft exchanged."""
    return replace(
        body, outer=mirrored_contour(body.outer), cavity=mirrored_contour(body.cavity), joints=-body.joints[::-1]
    )


def scaled_body(body: Body, factor: float) -> Body:
    """Return a geometrically similar body."""
    return replace(
        body,
        outer=factor * body.outer,
        cavity=factor * body.cavity,
        joints=factor * body.joints,
        core=Core(factor * body.core.radius, body.core.mass),
        wall=factor * body.wall,
    )


def lies_inside(points: FloatArray, contour: FloatArray, slack: float) -> BoolArray:
    """Return True for the points (n, 2) that lie between a contour and the axis, or within ``slack`` (m) of the contour, (n,).

    A ray from the point away from the axis crosses the contour an odd number of times if the point is inside.
    """
    x0, r0 = contour[:-1, 0], contour[:-1, 1]
    x1, r1 = contour[1:, 0], contour[1:, 1]
    x, r = points[:, :1], points[:, 1:]
    spans = (x0 <= x) != (x1 <= x)
    share = (x - x0) / np.where(x1 == x0, 1.0, x1 - x0)
    crossings = (spans & (r0 + share * (r1 - r0) > r)).sum(axis=1)
    return np.asarray((crossings % 2 == 1) | (distance_from(points, contour) <= slack))


def crosses_itself(contour: FloatArray) -> bool:
    """Return True if two edges of a polyline that are not neighbours properly cross each other."""
    p, q = contour[:-1, None], contour[1:, None]
    a, b = contour[None, :-1], contour[None, 1:]

    def side(u: FloatArray, v: FloatArray, w: FloatArray) -> FloatArray:
        first, second = v - u, w - u
        return np.asarray(first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0])

    apart = side(p, q, a) * side(p, q, b) < 0
    across = side(a, b, p) * side(a, b, q) < 0
    return bool((apart & across).any())
