"""Shapes for Exudyn (``GraphicsData``): triangles, lines and texts from lengths in m and colours, and the hull of an agent."""

from collections.abc import Iterable, Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from driftform.figures import style
from driftform.types import Body, FloatArray

Shape: TypeAlias = dict[str, Any]
"""One ``GraphicsData`` dictionary."""

FULL_TURN = np.linspace(0, 2 * np.pi, 37)
"""Angles of the corners of a whole circle, rad."""


POINT_KEYS = ("points", "data", "position")
"""Keys of a shape that hold points."""

NOSE_SHARE = 0.1
"""Share of the length that has the colour of the fore end."""

GLOWING = 1001.0
"""Value of an opacity that selects the ray tracer's material 1, which the stage makes luminous."""


def rgba(colour: str, opacity: float = 1.0) -> list[float]:
    """Return a colour ``#rrggbb`` as red, green, blue and opacity.

    >>> rgba("#ff0000")
    [1.0, 0.0, 0.0, 1.0]
    """
    return [*(int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)), opacity]


def make_line(points: npt.ArrayLike, colour: str) -> Shape:
    """Return a line of constant width through points (n, 3), at least one.

    The ray tracer drops segments shorter than a pixel.
    """
    corners = np.asarray(points, dtype=np.float64)
    # The last point twice: Exudyn cannot draw a line with a single point.
    return {"type": "Line", "color": rgba(colour), "data": np.vstack([corners, corners[-1:]]).ravel()}


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
    """Return ribbons of triangles, each of one colour; the opacity is 1, or ``GLOWING``.

    ``grid`` and ``normals`` are the points of both edges of each ribbon, and their normals, (ribbons, 2, n, 3).
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
    """Return the surface of revolution of a meridian about an axis through the origin; the opacity is 1, or ``GLOWING``.

    The contour has positions along the axis, and radii, m, (n, 2), a colour for each edge, and the surface to its left. Rows of
    ``axes`` are the axis and the directions of angle 0 and pi/2, (3, 3); ``angles`` are those of the surface's corners, rad, (k,).
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


def make_hull(body: Body, scale: float = 1.0) -> Shape:
    """Return the outer surface in the body frame, magnified about the core.

    Modules have two shades, and the fore end another colour.
    """
    nose = float(body.outer[-1, 0]) - NOSE_SHARE * body.length
    contour = _split_contour(body.outer, [nose, *body.joints])
    middle = (contour[:-1, 0] + contour[1:, 0]) / 2
    shades = (style.ORANGE, style.tint(style.ORANGE, 0.6))
    module = np.searchsorted(body.joints, middle)
    colours = [style.BLUE if x > nose else shades[m % 2] for x, m in zip(middle, module, strict=True)]
    return revolve(scale * contour, np.eye(3), FULL_TURN, colours)


def _split_contour(contour: FloatArray, cuts: Iterable[float]) -> FloatArray:
    """Return the contour with a point wherever it crosses one of the ``cuts`` (x, m), without edges of zero length."""
    for x in cuts:
        (crossing,) = np.nonzero((contour[:-1, 0] - x) * (contour[1:, 0] - x) < 0)
        p, q = contour[crossing], contour[crossing + 1]
        between = p + ((x - p[:, 0]) / (q[:, 0] - p[:, 0]))[:, None] * (q - p)
        contour = np.insert(contour, crossing + 1, between, axis=0)
    lengths = np.linalg.norm(np.diff(contour, axis=0), axis=1)
    return np.asarray(contour[np.append(True, lengths > 1e-9)], dtype=np.float64)
