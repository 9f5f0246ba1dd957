"""Parts on the bed as a picture: a small renderer of shaded triangles, parallel projection, with a depth buffer.

All in numpy, a whole shape at a time: every triangle gives the rows that it spans, every row its pixels between two
edges, and of those at the same pixel the nearest wins.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from driftform.types import FloatArray
from driftform_frusta.colours import channels

Pixels: TypeAlias = npt.NDArray[np.float32]
"""One row, or one number, for each sample of the picture."""

_ELEVATION, _AZIMUTH = np.deg2rad(24.0), np.deg2rad(-62.0)
"""Of the eye, seen from the middle of the bed: from the front, somewhat from the right and from above."""

_LIGHT = np.array([0.12, -0.78, 1.0]) / np.linalg.norm([0.12, -0.78, 1.0])
_SAMPLES = 2
"""Along each side of a pixel."""

_MARGIN = 0.07
_PAPER = np.array([247.0, 249.0, 250.0], dtype=np.float32)
_BED = np.array([224.0, 230.0, 234.0], dtype=np.float32)
_LINE = np.array([205.0, 213.0, 219.0], dtype=np.float32)
_RULER = np.array([176.0, 187.0, 196.0], dtype=np.float32)
_GRID = 10.0
"""mm between the lines of the bed; each fifth is darker."""


@dataclass(frozen=True, eq=False)
class Shape:
    """A mesh where it stands on the bed, mm, the middle of the bed at the origin; and its colour, ``#rrggbb``."""

    vertices: FloatArray
    triangles: npt.NDArray[np.int64]
    colour: str


def draw(
    shapes: Sequence[Shape], bed: tuple[float, float], width: int = 400, height: int = 300
) -> npt.NDArray[np.uint8]:
    """Return a picture of shapes on a bed, (height, width, 3); the grid of the bed has a line each 10 mm.

    The picture shows all of the shapes, and of the bed what lies around them.
    """
    view = _View.of(shapes, width * _SAMPLES, height * _SAMPLES)
    image, depth = _bed(view, bed)
    shade = np.zeros(len(depth), dtype=bool)
    for shape in shapes:
        shade[_covered(view, _shadow(shape.vertices), shape.triangles)[0]] = True
    image[shade & np.isfinite(depth)] *= 0.8
    for shape in shapes:
        _paint(image, depth, view, shape)
    fine = image.reshape(height, _SAMPLES, width, _SAMPLES, 3)
    small = np.add.reduce([fine[:, i, :, j] for i in range(_SAMPLES) for j in range(_SAMPLES)])
    return np.asarray(np.clip((small / _SAMPLES**2).round(), 0, 255), dtype=np.uint8)


@dataclass(frozen=True, eq=False)
class _View:
    """Rows of ``axes``: to the right, up and towards the eye; a point goes to ``scale`` times that, plus ``shift``."""

    axes: FloatArray
    scale: float
    shift: FloatArray
    width: int
    height: int

    @classmethod
    def of(cls, shapes: Sequence[Shape], width: int, height: int) -> "_View":
        c, s = np.cos(_AZIMUTH), np.sin(_AZIMUTH)
        eye = np.array([np.cos(_ELEVATION) * c, np.cos(_ELEVATION) * s, np.sin(_ELEVATION)])
        right = np.array([-s, c, 0.0])
        axes = np.stack([right, np.cross(eye, right), eye])
        corners = np.concatenate([_corners(shape.vertices) for shape in shapes]) @ axes.T
        low, high = corners[:, :2].min(axis=0), corners[:, :2].max(axis=0)
        room = (1 - 2 * _MARGIN) * np.array([width, height])
        scale = float((room / np.maximum(high - low, 1e-9)).min())
        shift = np.array([width, height]) / 2 - scale * (low + high) / 2
        return cls(axes, scale, shift, width, height)

    def project(self, points: FloatArray) -> FloatArray:
        """Pixels to the right and down, and nearness, (n, 3)."""
        seen: FloatArray = self.scale * (points @ self.axes.T)
        seen[:, :2] += self.shift
        seen[:, 1] = self.height - seen[:, 1]
        return seen


def _corners(vertices: FloatArray) -> FloatArray:
    """The corners of the box about a shape, and of the shadow at its feet, (8, 3)."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    pick = np.array([[i & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)], dtype=bool)
    corners: FloatArray = np.where(pick, high, low)
    return corners


def _shadow(vertices: FloatArray) -> FloatArray:
    """Where light casts the vertices on the bed."""
    cast: FloatArray = vertices - vertices[:, 2:] * (_LIGHT / _LIGHT[2])
    return cast


def _bed(view: _View, bed: tuple[float, float]) -> tuple[Pixels, Pixels]:
    """The picture with the bed alone, and how near it is at each pixel; minus infinity beside it."""
    column = ((np.arange(view.width) + 0.5 - view.shift[0]) / view.scale).astype(np.float32)
    row = ((view.height - np.arange(view.height) - 0.5 - view.shift[1]) / view.scale).astype(np.float32)
    # Two equations in x and y for the point of the plane z = 0 that is seen at a pixel.
    (xx, xy), (yx, yy) = np.linalg.inv(view.axes[:2, :2]).astype(np.float32)
    x, y = xx * column + xy * row[:, None], yx * column + yy * row[:, None]
    within = np.flatnonzero((np.abs(x) <= bed[0] / 2) & (np.abs(y) <= bed[1] / 2))
    x, y = x.ravel()[within], y.ravel()[within]
    pixel = 1 / view.scale
    colours = np.full((len(within), 3), _BED)
    for step, colour, breadth in ((_GRID, _LINE, 0.8), (5 * _GRID, _RULER, 1.0)):
        off = np.minimum(np.abs(x - step * np.round(x / step)), np.abs(y - step * np.round(y / step)))
        colours[off < breadth * pixel] = colour
    edge = np.maximum(np.abs(x) - bed[0] / 2, np.abs(y) - bed[1] / 2) > -1.5 * pixel
    colours[edge] = 0.8 * _RULER
    image = np.full((view.height * view.width, 3), _PAPER)
    image[within] = colours
    depth = np.full(view.height * view.width, -np.inf, dtype=np.float32)
    depth[within] = view.scale * (view.axes[2, 0] * x + view.axes[2, 1] * y)
    return image, depth


def _paint(image: Pixels, depth: Pixels, view: _View, shape: Shape) -> None:
    """Draw a shape into the picture, where it is nearer than what is there."""
    pixels, nearness, owners = _covered(view, shape.vertices, shape.triangles)
    a, b, c = (shape.vertices[shape.triangles[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    lit = 0.42 + 0.5 * np.maximum(normals @ _LIGHT, 0) + 0.14 * np.maximum(normals @ view.axes[2], 0)
    colour = 255 * (0.25 + 0.75 * np.array(channels(shape.colour)))
    shades = np.minimum(lit[:, None] * colour, 255)
    nearer = nearness > depth[pixels]
    pixels, nearness, owners = pixels[nearer], nearness[nearer], owners[nearer]
    # Of several values for one pixel the last one stays: the nearest.
    order = np.argsort(nearness, kind="stable")
    depth[pixels[order]] = nearness[order]
    image[pixels[order]] = shades[owners[order]]


def _covered(
    view: _View, vertices: FloatArray, triangles: npt.NDArray[np.int64]
) -> tuple[npt.NDArray[np.int64], FloatArray, npt.NDArray[np.int64]]:
    """Pixels that triangles cover, how near they are there, and which they are; those that face away are left out."""
    seen = view.project(vertices)[triangles]
    # From here on pixels are counted, and a pixel is where its middle is.
    seen[:, :, :2] -= 0.5
    a, b, c = seen[:, 0], seen[:, 1], seen[:, 2]
    doubled = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (c[:, 0] - a[:, 0]) * (b[:, 1] - a[:, 1])
    top = np.maximum(np.ceil(seen[:, :, 1].min(axis=1)), 0)
    rows = np.minimum(np.floor(seen[:, :, 1].max(axis=1)), view.height - 1) - top + 1
    # Down is positive on the page, so what faces the eye turns clockwise there.
    facing = np.flatnonzero((doubled < 0) & (rows > 0))
    a, b, c = a[facing], b[facing], c[facing]
    weights = np.stack([_weight(b, c, a), _weight(c, a, b), _weight(a, b, c)])
    owner, row = _counted(rows[facing].astype(np.int64))
    row += top[facing][owner].astype(np.int64)

    # Along a row each weight is linear, and the pixels where none is negative lie between two of its zeros.
    slope = weights[:, owner, 1]
    at_zero = weights[:, owner, 0] + weights[:, owner, 2] * row
    with np.errstate(divide="ignore", invalid="ignore"):
        zero = -at_zero / slope
    first = np.where(slope > 0, zero, np.where((slope == 0) & (at_zero < 0), np.inf, -np.inf)).max(axis=0)
    last = np.where(slope < 0, zero, np.inf).min(axis=0)
    first = np.maximum(np.ceil(first), 0)
    count = np.maximum(np.minimum(np.floor(last), view.width - 1) - first + 1, 0)
    span, column = _counted(count.astype(np.int64))
    start = np.where(count > 0, first, 0).astype(np.int64)
    column += start[span]
    owner, row = owner[span], row[span]

    # So is the nearness, in both directions.
    plane = (weights * np.stack([a[:, 2], b[:, 2], c[:, 2]])[:, :, None]).sum(axis=0)[owner]
    nearness = plane[:, 0] + plane[:, 1] * column + plane[:, 2] * row
    return row * view.width + column, nearness, facing[owner]


def _weight(b: FloatArray, c: FloatArray, opposite: FloatArray) -> FloatArray:
    """Barycentric weight of the corner opposite the edge from b to c: at the origin, per pixel right and down."""
    x, y = c[:, 1] - b[:, 1], b[:, 0] - c[:, 0]
    free = -(x * b[:, 0] + y * b[:, 1])
    whole = free + x * opposite[:, 0] + y * opposite[:, 1]
    return np.stack([free / whole, x / whole, y / whole], axis=1)


def _counted(counts: npt.NDArray[np.int64]) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """For each of ``counts`` things: its owner, and its number among those of the owner, from 0."""
    owner = np.repeat(np.arange(len(counts)), counts)
    return owner, np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
