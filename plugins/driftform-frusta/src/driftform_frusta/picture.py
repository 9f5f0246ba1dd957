"""Parts on the bed as a picture: their outlines from the front, the farthest drawn first."""

from collections.abc import Sequence

import numpy as np

from driftform.figures import style, svg
from driftform_frusta.triangles import Mesh

_MARGIN, _BED = 0.07, 0.03
"""Least distance from the edge of the page, and thickness of the bed, over the height of the page."""


def plate_svg(shapes: Sequence[tuple[Mesh, str]], bed: float, width: float = 200, height: float = 150) -> str:
    """Return a picture of shapes on a bed of a width (mm), SVG of ``width`` by ``height`` px; it shows all shapes.

    These are meshes in their places, mm, the middle of the bed at the origin, and their colours, ``#rrggbb``.
    """
    ordered = sorted(shapes, key=lambda shape: -float(shape[0].bounds[:, 1].mean()))
    outlines = [mesh.to_manifold().rotate((-90.0, 0.0, 0.0)).project().to_polygons() for mesh, _ in ordered]
    points = np.concatenate([ring for outline in outlines for ring in outline])
    (left, _), (right, top) = points.min(axis=0), points.max(axis=0)
    scale = min((width - 2 * _MARGIN * height) / (right - left), (1 - 2 * _MARGIN - _BED) * height / top)
    level = height * (1 - _MARGIN - _BED)

    def place(ring: object) -> str:
        at = (np.asarray(ring) - ((left + right) / 2, 0.0)) * (scale, -scale) + (width / 2, level)
        return svg.path_data(at, closed=True)

    root = svg.start_document(width, height, "Parts on the bed", "The parts as they are printed, in their colours.")
    svg.add(root, "rect", width=width, height=height, fill="#ffffff")
    depth = _BED * height / scale
    ends = np.array([(-bed / 2, 0.0), (bed / 2, 0.0), (bed / 2, -depth), (-bed / 2, -depth)])
    svg.add(root, "path", d=place(ends), fill=style.tint(style.INK, 0.25))
    for (_, colour), outline in zip(ordered, outlines, strict=True):
        drawn = "".join(map(place, outline))
        svg.add(root, "path", d=drawn, fill=style.tint(colour, 0.6), stroke=colour, stroke_width=1.0)
    return svg.render(root)
