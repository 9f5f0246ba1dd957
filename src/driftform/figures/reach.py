"""Coverage of the pipe by a run: the closest approach of its flights to each cell, and the cells not crossed."""

from xml.etree import ElementTree as ET

import numpy as np

from driftform.figures import svg
from driftform.figures.layout import MARGIN, start_page, write
from driftform.figures.plot import (
    Window,
    draw_axes,
    draw_cross,
    draw_current,
    draw_ends,
    draw_water,
    label_points,
    pipe_ink,
    pipe_points,
)
from driftform.figures.projection import SIDE
from driftform.figures.style import GRID, INK, MUTED, RAMP, SCREEN, Page
from driftform.runs.coverage import BOUNDS, CoverageMap, PipeGrid
from driftform.types import FloatArray
from driftform.water import Pipe, Scenario, Segment
from driftform.water.parts.shapes import Straight

_LEFT, _RIGHT = 58.0, 22.0
_SWATCH, _SMALL_SWATCH = (34.0, 14.0), (23.0, 14.0)
_WIDE = 700.0
"""Width of a page on which the legend has room for one line, px."""


def reach_svg(reach: CoverageMap, scenario: Scenario, title: str, page: Page = SCREEN) -> str:
    """Return a coverage map as SVG: the pipe in section, each cell coloured by the closest flight.

    Args:
        reach: the map, drawn to scale: along the pipe to the right, and upward as in
            :class:`driftform.runs.coverage.PipeGrid`.
        scenario: current, release and targets. If its pipe lies along the world's x, the axes are those of the world.
        title: a line above the picture.

    Cells that no flight crosses are white and hatched.
    """
    cells = reach.cells
    is_plane = all(isinstance(placed.part, Straight) for placed in cells.layout.parts)
    is_world = is_plane and bool(np.allclose(cells.axes[:2], ((1, 0, 0), (0, 0, 1))))
    shift = cells.layout.inlet.centre[[0, 2]] if is_world else np.zeros(2)
    # The pipe in the coordinates of the map, in the plane y = 0.
    (length, radius), (x, z) = cells.size[:2] * cells.shape * (1, 0.5), shift
    pipe = Pipe(segments=(Segment(start=(x, 0.0, z), end=(x + length, 0.0, z), radius=float(radius)),))
    window = Window.around(SIDE, pipe_points(pipe), _LEFT, 92, page.width - _LEFT - _RIGHT, 460, 14)
    base = window.box.bottom + (62 if page.width > _WIDE else 80)
    subtitle = _describe(reach)
    description = f"The pipe in section, in cells coloured by the closest approach to the middle of each. {subtitle}."
    root = start_page(base + 46, title, subtitle, description, page)
    draw_axes(root, window, None if is_world else ("along the pipe", "up"))
    draw_water(root, window, pipe)
    draw_ends(root, window, pipe)
    _draw_cells(root, window, reach, shift)
    draw_current(root, window, (cells.axes @ scenario.current())[[0, 2, 1]])
    _draw_points(root, window, scenario, cells, shift, pipe)
    _draw_legend(root, base, page.width)
    return svg.render(root)


def _describe(reach: CoverageMap) -> str:
    reached = int(np.count_nonzero(reach.reached))
    width, height = 100 * reach.cells.size[:2]
    share = 100 * reached / reach.cells.cell_count
    return (
        f"{reach.flights} flights cross {reached} of {reach.cells.cell_count} cells of {width:.3g} cm x {height:.3g} cm "
        f"({share:.1f} %)" + (f"; {reach.unchecked} of the flights are unchecked" if reach.unchecked else "")
    )


def _draw_cells(root: ET.Element, window: Window, reach: CoverageMap, shift: FloatArray) -> None:
    columns, rows = reach.cells.shape
    classes = reach.classes.reshape(columns, rows)
    low = reach.cells.centres().reshape(columns, rows, 2) - reach.cells.size[:2] / 2 + shift
    width, height = reach.cells.size[:2]
    # Equal neighbours along the pipe are drawn as one rectangle.
    row, start = np.nonzero(np.diff(classes.T, prepend=-2))
    end = np.append(start[1:], 0)
    end[end == 0] = columns
    x, z = low[start, row].T
    right, top = x + (end - start) * width, z + height
    boxes = _to_page(window, np.stack([x, z, right, z, right, top, x, top], axis=1))
    numbers = classes[start, row]
    bands = [(n, svg.lines_data(boxes[numbers == n], closed=True)) for n in sorted(set(numbers.tolist()))]
    bare = low[classes < 0]
    slashes = _to_page(window, np.hstack([bare, bare + reach.cells.size[:2]]))
    svg.draw_template(root, __package__, "reach", bands=bands, hatching=svg.lines_data(slashes))


def _to_page(window: Window, lines: FloatArray) -> FloatArray:
    """Return the points on the page of lines, whose points in m are in one row each, (lines, points, 2)."""
    return window.to_page(lines.reshape(-1, 2)).reshape(len(lines), lines.shape[1] // 2, 2)


def _draw_points(
    root: ET.Element, window: Window, scenario: Scenario, cells: PipeGrid, shift: FloatArray, pipe: Pipe
) -> None:
    """Draw the release point, and the targets with their names."""
    release = cells.to_map(scenario.release_position()[None])[:, :2] + shift
    [(x, y)] = window.to_page(release)
    svg.add_circle(root, x, y, 4.5, "#ffffff", INK, 1.6)
    anchors = window.to_page(cells.to_map(scenario.target_array())[:, :2] + shift)
    for x, y in anchors:
        draw_cross(root, x, y, 5.5, INK, 2.4)
    names = [(name, INK, True) for name in scenario.target_names]
    label_points(root, window, anchors, names, [pipe_ink(window, pipe)], keep=8)


def _draw_legend(root: ET.Element, top: float, width: float) -> None:
    """Draw the colours with the distances between them, and the hatching of cells that no flight crosses."""
    swatch, over = (_SWATCH, 0) if width > _WIDE else (_SMALL_SWATCH, 18)
    svg.add_segment(root, MARGIN, top - 16 - over, width - MARGIN, top - 16 - over, GRID)
    write(root, MARGIN, top + 11 - over, "Closest approach to the middle of the cell (mm)", 12, MUTED)
    left = MARGIN if over else width - MARGIN - len(RAMP) * swatch[0] - 150
    bounds = [f"{1000 * bound:g}" for bound in BOUNDS]
    svg.draw_template(root, __package__, "reach-legend", left=left, top=top, size=swatch, bounds=bounds)
