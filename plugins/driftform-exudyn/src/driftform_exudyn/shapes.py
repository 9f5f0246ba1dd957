"""Shapes for Exudyn (``GraphicsData``): triangles, lines and texts from lengths in m and colours."""

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from driftform.types import FloatArray

Shape: TypeAlias = dict[str, Any]
"""One ``GraphicsData`` dictionary."""

FULL_TURN = np.linspace(0, 2 * np.pi, 37)
"""Angles of the corners of a whole circle, rad."""


POINT_KEYS = ("points", "data", "position")
"""Keys of a shape that hold points."""

GLOWING = 1001.0
"""Value of an opacity that selects the ray tracer's material 1, which the stage makes luminous."""


def rgba(colour: str, opacity: float = 1.0) -> list[float]:
    """Return a colour ``#rrggbb`` as red, green, blue and opacity.

    >>> rgba("#ff0000")
    [1.0, 0.0, 0.0, 1.0]
    """
    return [*(int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)), opacity]


def make_line(points: npt.ArrayLike, colour: str) -> Shape:
    """Return a line of constant width through points (n, 3), at least one."""
    corners = np.asarray(points, dtype=np.float64)
    # The last point twice: Exudyn cannot draw a line with a single point.
    return {"type": "Line", "color": rgba(colour), "data": np.vstack([corners, corners[-1:]]).ravel()}


def thin(points: FloatArray, gap: float) -> FloatArray:
    """Return points of a polyline (n, 3) about ``gap`` (m) apart, with the first and the last.

    The ray tracer drops segments shorter than a pixel.
    """
    gone = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    kept = np.diff(np.floor(gone / gap), prepend=-1.0) > 0
    kept[-1] = True
    return points[kept]


def make_text(point: FloatArray, words: str, colour: str, size: float) -> Shape:
    """Return text in letters of ``size`` px, to the right of a point (3,)."""
    return {
        "type": "Text",
        "position": point,
        "text": words,
        "color": rgba(colour),
        "fontSize": size,
        "offset": [0.0, 0.0],
    }


def make_ribbons(grid: FloatArray, normals: FloatArray, colours: Sequence[str], opacity: float = 1.0) -> Shape:
    """Return ribbons of triangles.

    Args:
        grid, normals: points of both edges of each ribbon, and their normals, (ribbons, 2, n, 3).
        colours: one for each ribbon.
        opacity: 1, or ``GLOWING``.
    """
    ribbons, _, n, _ = grid.shape
    corner = 2 * n * np.arange(ribbons)[:, None] + np.arange(n - 1)
    a, b, c, d = corner, corner + 1, corner + n, corner + n + 1
    return {
        "type": "TriangleList",
        "points": grid.ravel(),
        "normals": normals.ravel(),
        "colors": np.repeat([rgba(colour, opacity) for colour in colours], 2 * n, axis=0).ravel(),
        "triangles": np.stack([a, b, d, a, d, c], axis=-1).ravel(),
    }


def revolve(
    contour: FloatArray, axes: FloatArray, angles: FloatArray, colours: Sequence[str], opacity: float = 1.0
) -> Shape:
    """Return the surface of revolution of a meridian about an axis through the origin.

    Args:
        contour: positions along the axis, and radii, m, (n, 2); the surface faces to the left of the contour.
        axes: the axis, the direction of angle 0 and the direction of angle pi/2, as rows, (3, 3).
        angles: angles of the corners of the surface, rad, (k,).
        colours: one for each edge of the contour.
        opacity: 1, or ``GLOWING``.
    """
    along, rise = np.diff(contour, axis=0).T[..., None, None]
    out = np.cos(angles)[:, None] * axes[1] + np.sin(angles)[:, None] * axes[2]
    rims = contour[:, 0, None, None] * axes[0] + contour[:, 1, None, None] * out
    # The normals are constant along each edge, so that rims look sharp.
    normals = (along * out - rise * axes[0]) / np.hypot(along, rise)
    edges = np.stack([rims[:-1], rims[1:]], axis=1)
    return make_ribbons(edges, np.stack([normals, normals], axis=1), colours, opacity)


def place(shape: Shape, scale: float, offset: npt.ArrayLike) -> Shape:
    """Return the shape magnified about the origin, then moved by ``offset``."""
    found = [key for key in POINT_KEYS if key in shape]
    return {**shape, **{key: (scale * shape[key].reshape(-1, 3) + offset).ravel() for key in found}}


def turn(shape: Shape, rotation: FloatArray, position: FloatArray) -> Shape:
    """Return triangles of a body at its pose in the world, with their normals: ``rotation`` (3, 3) is body to world."""
    points, normals = (shape[key].reshape(-1, 3) @ rotation.T for key in ("points", "normals"))
    return {**shape, "points": (points + position).ravel(), "normals": normals.ravel()}


def make_ball(centre: npt.ArrayLike, radius: float, colour: str) -> Shape:
    """Return a sphere."""
    angles = np.linspace(np.pi, 0, 13)
    contour = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    return place(revolve(contour, np.eye(3), FULL_TURN[::2], [colour] * 12), 1.0, centre)
