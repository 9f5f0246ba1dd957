"""Parts on the bed as a picture: shaded triangles in parallel projection, the farthest drawn first."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import TypeAlias
from xml.etree import ElementTree as ET

import numpy as np
import numpy.typing as npt
from manifold3d import Manifold

from driftform.figures import svg
from driftform.types import FloatArray
from driftform_frusta.colours import channels
from driftform_frusta.triangles import Mesh

_ELEVATION, _AZIMUTH = np.deg2rad(24.0), np.deg2rad(-62.0)
"""Of the eye, seen from the middle of the bed: from the front, somewhat from the right and from above."""

_EYE = np.array([np.cos(_ELEVATION) * np.cos(_AZIMUTH), np.cos(_ELEVATION) * np.sin(_AZIMUTH), np.sin(_ELEVATION)])
_RIGHT = np.array([-np.sin(_AZIMUTH), np.cos(_AZIMUTH), 0.0])
_PAGE = np.stack([_RIGHT, -np.cross(_EYE, _RIGHT)])
"""Rows: to the right and down on the page."""

_LIGHT = np.array([0.12, -0.78, 1.0]) / np.linalg.norm([0.12, -0.78, 1.0])
_SHADES = 64
"""Steps of brightness: triangles of one shade that follow each other are one path."""

_DETAIL = 0.05
"""px: details smaller than this are left out, which halves the time."""

_SEAM = 0.5
"""px, width of the line around a triangle."""

_MARGIN = 0.07
"""Least distance from the edge of the page, over its width or height."""

_PAPER, _BED, _LINE, _RULER, _EDGE = "#f7f9fa", "#e0e6ea", "#cdd5db", "#b0bbc4", "#8d969d"
_STEP = 10.0
"""mm between the lines of the bed; each fifth is darker."""


Shape: TypeAlias = tuple[Mesh, str]
"""A mesh in its place on the bed, mm, the middle of the bed at the origin; and its colour, ``#rrggbb``."""


def plate_svg(shapes: Sequence[Shape], bed: tuple[float, float], width: float = 200, height: float = 150) -> str:
    """Return a picture of shapes on a bed, SVG of ``width`` by ``height`` px; the bed has a line each 10 mm.

    The picture shows all shapes, and the part of the bed (width and depth, mm) around them. The shapes are upright parts; seen
    from above, their circumscribed circles do not overlap.
    """
    view = _View.of(shapes, width, height)
    shapes = [(_simplify(mesh, _DETAIL / view.scale), colour) for mesh, colour in shapes]
    root = svg.start_document(width, height, "Parts on the bed", "The parts as they are printed, in their colours.")
    page = np.array([(0, 0), (width, 0), (width, height), (0, height)], dtype=np.float64)
    svg.add(root, "path", d=svg.path_data(page, closed=True), fill=_PAPER)
    _add_bed(root, view, bed, page, [mesh for mesh, _ in shapes])
    # In parallel projection, a part hides only those behind its axis.
    for mesh, colour in sorted(shapes, key=lambda shape: _depth(shape[0].vertices.mean(axis=0))):
        _add_mesh(root, view, mesh, colour)
    return svg.render(root)


@dataclass(frozen=True, eq=False)
class _View:
    """From mm on the bed to px on the page: a scale and a shift, to the right and down."""

    scale: float
    shift: FloatArray

    @classmethod
    def of(cls, shapes: Sequence[Shape], width: float, height: float) -> "_View":
        boxes = [np.stack(np.meshgrid(*mesh.bounds.T), axis=-1).reshape(-1, 3) for mesh, _ in shapes]
        corners = np.concatenate(boxes)
        seen = corners @ _PAGE.T
        low, high = seen.min(axis=0), seen.max(axis=0)
        page = np.array([width, height])
        scale = float(((1 - 2 * _MARGIN) * page / np.maximum(high - low, 1e-9)).min())
        return cls(scale, page / 2 - scale * (low + high) / 2)

    def project(self, points: FloatArray) -> FloatArray:
        seen: FloatArray = self.scale * (points @ _PAGE.T) + self.shift
        return seen


def _simplify(mesh: Mesh, tolerance: float) -> Mesh:
    """Return a mesh without its sealed hollows, and without details smaller than ``tolerance`` (mm)."""
    # The closed surface around a hollow faces inward: its volume is negative.
    outside = Manifold.compose([shell for shell in mesh.to_manifold().decompose() if shell.volume() > 0])
    fewer = outside.simplify(tolerance)
    found = (outside if fewer.is_empty() else fewer).to_mesh64()
    return Mesh(np.asarray(found.vert_properties)[:, :3], np.asarray(found.tri_verts, dtype=np.int64))


def _depth(points: FloatArray) -> FloatArray:
    """Return how near points are to the eye along the bed, mm.

    The height is left out: a point hides only those that are both lower and farther along the bed, and bands of a
    solid of revolution span much height but little depth.
    """
    depth: FloatArray = points[..., :2] @ _EYE[:2]
    return depth


def _add_bed(root: ET.Element, view: _View, bed: tuple[float, float], page: FloatArray, meshes: Sequence[Mesh]) -> None:
    half = np.array([bed[0], bed[1], 0.0]) / 2
    corners = view.project(half * np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]))
    svg.add(root, "path", d=svg.path_data(corners, closed=True), fill=_BED)
    for colour, wanted in ((_LINE, False), (_RULER, True)):
        lines = []
        for across, along in ((0, 1), (1, 0)):
            last = int(half[across] // _STEP)
            for number in range(-last, last + 1):
                if (number % 5 == 0) == wanted:
                    ends = np.zeros((2, 3))
                    ends[:, across] = number * _STEP
                    ends[:, along] = -half[along], half[along]
                    lines.append(svg.path_data(view.project(ends)))
        svg.add(root, "path", d="".join(lines), stroke=colour, stroke_width=0.5, fill="none")
    shadows = []
    for mesh in meshes:
        cast = mesh.vertices - mesh.vertices[:, 2:] * (_LIGHT / _LIGHT[2])
        shadows.append(_triangles(view.project(cast)[_facing(mesh, _LIGHT)[0]]))
    svg.add(root, "path", d="".join(shadows), fill="#000000", fill_opacity=0.2)
    # Shadows off the bed are covered again.
    around = svg.path_data(page, closed=True) + svg.path_data(corners, closed=True)
    svg.add(root, "path", d=around, fill=_PAPER, fill_rule="evenodd")
    svg.add(root, "path", d=svg.path_data(corners, closed=True), stroke=_EDGE, stroke_width=0.5, fill="none")


def _facing(mesh: Mesh, direction: FloatArray) -> tuple[npt.NDArray[np.int64], FloatArray]:
    normals = mesh.area_vectors
    chosen = normals @ direction > 0
    normals = normals[chosen]
    return mesh.triangles[chosen], normals / np.linalg.norm(normals, axis=1, keepdims=True)


def _add_mesh(root: ET.Element, view: _View, mesh: Mesh, colour: str) -> None:
    """Draw the triangles that face the eye, the farthest first, and of those equally far the lowest."""
    triangles, normals = _facing(mesh, _EYE)
    middles = mesh.vertices[triangles].mean(axis=1)
    order = np.lexsort((middles[:, 2], _depth(middles).round(3)))
    light = 0.42 + 0.5 * np.maximum(normals @ _LIGHT, 0) + 0.14 * np.maximum(normals @ _EYE, 0)
    places = view.project(mesh.vertices)[triangles[order]]
    shades = (_SHADES * light[order]).round().astype(int).tolist()
    start = 0
    for shade, run in groupby(shades):
        end = start + len(list(run))
        shown = _shade(colour, shade / _SHADES)
        # A line as wide as its neighbours' blurred edges leaves no seam between them.
        svg.add(root, "path", d=_triangles(places[start:end]), fill=shown, stroke=shown, stroke_width=_SEAM)
        start = end


def _shade(colour: str, light: float) -> str:
    return "#" + "".join(f"{round(255 * min(light * (0.25 + 0.75 * c), 1)):02x}" for c in channels(colour))


def _triangles(places: FloatArray) -> str:
    """Return path data of triangles, (m, 3, 2) in px."""
    return "M%.2f %.2fL%.2f %.2fL%.2f %.2fZ" * len(places) % tuple(places.ravel().tolist())
