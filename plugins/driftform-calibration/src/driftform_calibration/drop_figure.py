"""Drops in a tank, seen from the camera: where the agent is released, how it hangs, and where it should go."""

from dataclasses import dataclass, replace

import numpy as np

from driftform.figures import layout, plot, style, svg
from driftform.motion import path
from driftform.types import Body, FloatArray

WIDTH, TITLE, CAPTION = 300.0, 26.0, 20.0
"""Of a picture and of the lines above and below the tank, px."""


@dataclass(frozen=True, eq=False)
class DropPicture:
    """One release: its attitude (quaternion, body to world, (4,)), and the expected path of the core, m.

    ``path`` is to the right of the middle of the tank and above the surface, (k, 2).
    """

    title: str
    caption: str
    quaternion: FloatArray
    path: FloatArray


def drop_svg(drop: DropPicture, body: Body, length: float, depth: float) -> str:
    """Return a release as SVG, to scale, in a tank of that ``length`` and ``depth`` of water, m."""
    corners = np.array([[-length / 2, -depth], [length / 2, 0.0]])
    window = plot.Window.around((0, 1), corners, 0.0, TITLE, WIDTH, 420.0, 6.0)
    (left, bottom), (right, top) = window.to_page(corners)
    height = window.box.bottom + CAPTION + 6
    root = svg.start_document(WIDTH, height, drop.title, drop.caption)
    layout.write(root, 6, 16, drop.title, 13, style.INK, bold=True)
    svg.add(root, "rect", class_="water", x=left, y=top, width=right - left, height=bottom - top, fill=style.WATER)
    walls = [(left, top - 8), (left, bottom), (right, bottom), (right, top - 8)]
    svg.add_line(root, svg.path_data(walls), style.WALL, 2.5, "tank")
    svg.add_line(root, window.path_data(drop.path), style.BLUE, 1.8, "path", stroke_dasharray="4 3")
    start = np.array([drop.path[0, 0], 0.0, drop.path[0, 1]])
    colours = (style.tint(style.BLUE, 0.25), style.INK, style.ORANGE)
    pose = path.Pose(start, drop.quaternion)
    plot.draw_silhouette(root, replace(window, view=(0, 2)), body, pose, 1.0, colours)
    layout.draw_scale_bar(root, right - 4, bottom - 8, window.px_per_m, (right - left) / 3, style.MUTED)
    layout.write(root, 6, height - 8, drop.caption, 11, style.MUTED)
    return svg.render(root)


def ruler_svg(length_mm: int = 150) -> str:
    """Return a ruler as SVG whose natural size is its length: to print, and to hang where the agent falls."""
    width, height = length_mm + 20.0, 26.0
    px = svg.PX_PER_MM
    root = svg.start_document(width * px, height * px, "Ruler", f"A ruler of {length_mm} mm.", "mm")
    ticks = [
        ((10 + mm) * px, (10 if mm % 50 == 0 else 6 if mm % 10 == 0 else 3) * px, "" if mm % 50 else f"{mm}")
        for mm in range(0, length_mm + 1, 5)
    ]
    svg.draw_template(root, __package__, "ruler", ticks=ticks, top=4 * px, length=length_mm)
    return svg.render(root)
