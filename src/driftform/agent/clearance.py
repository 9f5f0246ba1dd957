"""Exact extents of a body of revolution at any attitude: across a line, and along a direction."""

import numpy as np

from driftform.types import FloatArray


def farthest_from_line(
    contour: FloatArray, position: FloatArray, axis: FloatArray, start: FloatArray, direction: FloatArray
) -> float:
    """Return the greatest distance (m) of a body's surface from a line.

    The distance from a line is a convex function, so that its maximum over the body lies on a circle of the contour.
    Seen along the line such a circle is an ellipse with the half axes r |cos a| and r, where a is the angle between the
    axes; its farthest point from the line is a trust-region problem in two dimensions, whose secular equation is solved
    by bisection (Conn, Gould and Toint 2000, Trust-Region Methods, section 7.3).

    Args:
        contour: outer contour, x and r, m, (n, 2).
        position: of the body's origin, world frame, m, (3,).
        axis: unit vector along the body's axis, world frame, (3,).
        start, direction: a point of the line, m, and the unit vector along it, world frame, (3,) each.
    """
    x, r = contour.T
    cosine = float(axis @ direction)
    sideways = axis - cosine * direction
    offset = position - start
    offset = offset - (offset @ direction) * direction
    sine = float(np.linalg.norm(sideways))
    if sine < 1e-12:
        return float(np.linalg.norm(offset) + r.max())
    across = sideways / sine
    # The centre of each circle, in the plane across the line: along the tilt, and square to it.
    centre = np.stack((offset @ across + x * sine, np.full_like(x, offset @ np.cross(direction, across))))
    half = np.stack((r * abs(cosine), r))
    # Maximise |centre + half w| over the unit circle: (largest - half^2) w = half centre, with |w| = 1.
    curve, push = half**2, np.abs(half * centre)
    low = curve.max(axis=0)
    high = low + np.linalg.norm(push, axis=0)
    tiny = np.finfo(float).tiny
    # Where a circle is all but symmetric, w overflows: it is then certainly outside.
    with np.errstate(over="ignore"):
        for _ in range(80):
            middle = 0.5 * (low + high)
            w = push / np.maximum(middle - curve, tiny)
            outside = (w**2).sum(axis=0) > 1.0
            low, high = np.where(outside, middle, low), np.where(outside, high, middle)
        w = push / np.maximum(high - curve, tiny)
    # Nothing pushes along the longer half axis if the centre lies on the other: the rest of |w| = 1 goes there.
    w[1] = np.sqrt(np.maximum(1.0 - np.minimum(w[0], 1.0) ** 2, 0.0))
    w[0] = np.minimum(w[0], 1.0)
    return float(np.linalg.norm(np.abs(centre) + half * w, axis=0).max())


def lowest_along(contour: FloatArray, position: FloatArray, axis: FloatArray, direction: FloatArray) -> float:
    """Return the smallest component (m) of the body's surface along a unit ``direction``, world frame, (3,)."""
    cosine = float(axis @ direction)
    sine = float(np.linalg.norm(axis - cosine * direction))
    return float(position @ direction + (contour[:, 0] * cosine - contour[:, 1] * sine).min())
