"""A gallery of evolved bodies, side by side at one scale."""

from collections.abc import Sequence
from dataclasses import dataclass
from xml.etree import ElementTree as ET

import numpy as np

from driftform.figures import svg
from driftform.figures.bodies import Placement, closed_outline, draw_rims, draw_shading
from driftform.figures.layout import MARGIN, draw_scale_bar, shorten, text_width, write
from driftform.figures.style import GRID, INK, MUTED, SCREEN, SERIES, Page, tint
from driftform.types import Agent, Body, Trajectory

_COLUMNS = 5
_TALLEST, _WITH_HEADING = 150.0, 500.0
GAP, NARROWEST = 24.0, 132.0


@dataclass(frozen=True, eq=False)
class GalleryEntry:
    """The best flight for a target: the target's ``name``, the ``agent``, its ``trajectory``, and its result, a ``value`` in ``unit``."""

    name: str
    agent: Agent
    trajectory: Trajectory
    value: float
    unit: str = "%"


def group_shared(flights: Sequence[GalleryEntry]) -> list[list[GalleryEntry]]:
    """Return the entries in groups of those that are of one flight, which is the best for several targets."""
    groups: dict[int, list[GalleryEntry]] = {}
    for flight in flights:
        groups.setdefault(id(flight.trajectory), []).append(flight)
    return list(groups.values())


@dataclass(frozen=True, eq=False)
class Row:
    """Bodies side by side: ``cells``, each with its entries, colour and width; height of the ``tallest`` and of the row (px)."""

    cells: list[tuple[list[GalleryEntry], str, float]]
    tallest: float
    height: float


def arrange_rows(flights: Sequence[GalleryEntry], page: Page = SCREEN) -> tuple[list[Row], float]:
    """Return the rows of the gallery, and their common scale (px per metre)."""
    if not flights:
        return [], 1.0
    bodies = [flight.agent.body for flight in flights]
    pairs = [(group, SERIES[i % len(SERIES)]) for i, group in enumerate(group_shared(flights))]
    inner = page.width - 2 * MARGIN
    columns = max(1, min(_COLUMNS, int(inner / NARROWEST)))
    split = [pairs[first : first + columns] for first in range(0, len(pairs), columns)]

    def cells(row: list[tuple[list[GalleryEntry], str]], px_per_m: float) -> list[float]:
        return [max(group[0].agent.body.length * px_per_m + GAP, NARROWEST) for group, _ in row]

    # Bisect for the largest scale at which every row fits: widths only grow with the scale.
    low, high = 0.0, _TALLEST / max(body.max_diameter for body in bodies)
    for _ in range(50):
        middle = (low + high) / 2
        fits = all(sum(cells(row, middle)) <= inner for row in split)
        low, high = (middle, high) if fits else (low, middle)
    rows = []
    for row in split:
        widths = cells(row, low)
        # A short last row is aligned to the left, in cells as wide as those above.
        spare = (inner - sum(widths)) / len(row) if len(row) == columns else 0.0
        tallest = max(group[0].agent.body.max_diameter for group, _ in row) * low
        rows.append(Row([(g, c, w + spare) for (g, c), w in zip(row, widths, strict=True)], tallest, tallest + 66))
    return rows, low


def draw_gallery(root: ET.Element, rows: list[Row], px_per_m: float, top: float, page: Page = SCREEN) -> None:
    """Draw the rows from ``top`` (px) down, below a line of text with a scale bar."""
    if not rows:
        return
    svg.add_segment(root, MARGIN, top - 38, page.width - MARGIN, top - 38, GRID)
    if page.width > _WITH_HEADING:
        write(root, MARGIN, top - 14, "The bodies, to one scale, fore end to the right", 12, MUTED)
    draw_scale_bar(root, page.width - MARGIN, top - 12, px_per_m, 110, MUTED)

    number = 0
    for row in rows:
        x = MARGIN
        for group, colour, cell in row.cells:
            x += cell / 2
            body = group[0].agent.body
            middle = float(body.outer[0, 0] + body.outer[-1, 0]) / 2
            _draw_body(root, body, colour, Placement(x - px_per_m * middle, top + 12 + row.tallest / 2, px_per_m))
            base = top + row.tallest + 36
            error = ", ".join(f"{flight.value:.2f}" for flight in group) + f" {group[0].unit}"
            error = shorten(error, 12, cell - 12)
            # A line in the flight's colour, the name and the error form one centred group; several errors have a line.
            line, names = 30.0 if page.is_paper else 12.0, ", ".join(flight.name for flight in group)
            room = cell - 28 - line - text_width(names, 13, bold=True)
            single = len(group) == 1 and (not page.is_paper or text_width(error, 12) < room)
            error_width = text_width(error, 12) if single else 0.0
            name = shorten(names, 13, cell - 28 - line - error_width, bold=True)
            parts = [line + 8, text_width(name, 13, bold=True) + 4, error_width]
            left = x - sum(parts) / 2
            ends, y, dashes = (left, left + line), base - 4.5, page.choose_dash(number)
            if dashes:
                svg.add_segment(root, ends[0], y, ends[1], y, colour, 2.2, stroke_dasharray=dashes)
            else:
                svg.add_segment(root, ends[0], y, ends[1], y, colour, 3.5, stroke_linecap="round")
            number += 1
            write(root, left + parts[0], base, name, 13, INK, bold=True)
            if single:
                write(root, left + parts[0] + parts[1], base, error, 12, MUTED)
            else:
                write(root, x, base + 16, error, 12, MUTED, "middle")
            x += cell / 2
        top += row.height


def _draw_body(root: ET.Element, body: Body, colour: str, place: Placement) -> None:
    draw_shading(root, body, place, colour, below=1, bands=6)
    draw_rims(root, body, place, tint(colour, 0.5), 0.5, below=1)
    outline = svg.path_data(place.to_page(closed_outline(body.outer)), closed=True)
    svg.add_line(root, outline, colour, 1.1, "outline", stroke_linejoin="round")
    if body.core.contour:
        core = place.to_page(closed_outline(np.array(body.core.contour)))
        svg.add(root, "path", d=svg.path_data(core, closed=True), fill=colour, class_="core")
    else:
        radius = max(1.5, body.core.radius * place.px_per_m)
        svg.add_circle(root, place.x, place.y, radius, colour, class_="core")
