"""Maps of a network as SVG: what is seen of each link, arrival times, and where bodies end."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from xml.etree import ElementTree as ET

import numpy as np

from driftform.errors import InputError
from driftform.figures import layout, plot, style, svg
from driftform.types import FloatArray
from driftform_networks.fleets import Fleet
from driftform_networks.network import Network
from driftform_networks.passage import Ending, Passage

UNREACHED = "#d3d9de"
RAMP = ("#b5de2b", "#6ece58", "#35b779", "#1f9e89", "#26828e", "#31688e", "#482878", "#440154")
"""Viridis without its pale end, reversed: more of a link is seen where it is darker, for any colour vision."""

BOUNDS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.7)
"""Shares at which colour and width change: most links of a town are seen by a few of a hundred bodies."""

_TOP, _TALLEST, _LEGEND = 78.0, 720.0, 78.0
_THIN, _THICK = 1.4, 6.0
_MOST_TIMES = 14
"""Arrival times that are written on a map."""


@dataclass(frozen=True, eq=False)
class Mark:
    """A place on a map: a node, its name or another text, and whether it matters more than others."""

    node: int
    text: str
    colour: str = style.INK

    @property
    def is_bold(self) -> bool:
        """Whether it matters more than others."""
        return self.colour != style.INK


def passage_svg(passage: Passage, title: str) -> str:
    """Return the map of a passage: probability as colour and width of a link, arrival times, stuck places.

    Raises
    ------
    InputError
        if the network has no coordinates.
    """
    shares = np.where(passage.reachable, passage.seen, np.nan)
    network, stuck = passage.network, passage.stuck
    kilometres = network.length[passage.reachable].sum() / 1000
    subtitle = f"{100 * passage.coverage:.1f} % of the {kilometres:.1f} km reachable is seen"
    if (lost := sum(end.probability for end in stuck)) > 5e-4:
        subtitle += f"; {100 * lost:.1f} % stuck"
    marks = [Mark(passage.release, network.nodes[passage.release], style.VERMILLION), *_choose_times(passage)]
    return network_svg(network, shares, marks, title, subtitle, stuck)


def fleet_svg(fleet: Fleet, title: str) -> str:
    """Return the map of a fleet: the probability that any member sees a link, and where members are stuck.

    Raises
    ------
    InputError
        if the network has no coordinates.
    """
    network, size = fleet.network, len(fleet.members)
    shares = np.where(fleet.reachable, fleet.seen, np.nan)
    kilometres = network.length[fleet.reachable].sum() / 1000
    subtitle = f"{size} bodies see {100 * fleet.coverage:.1f} % of the {kilometres:.1f} km reachable"
    stuck = [replace(end, probability=end.probability / size) for end in fleet.stuck]
    if (lost := sum(end.probability for end in stuck)) > 5e-4:
        subtitle += f"; {100 * lost:.1f} % of them end in the pipes"
    nodes = dict.fromkeys(member.passage.release for member in fleet.members)
    marks = [Mark(node, network.nodes[node], style.VERMILLION) for node in nodes]
    legend = "probability that the fleet sees the link"
    return network_svg(network, shares, marks, title, subtitle, stuck, legend)


def network_svg(
    network: Network,
    shares: FloatArray,
    marks: Sequence[Mark],
    title: str,
    subtitle: str,
    stuck: Sequence[Ending] = (),
    legend: str = "share of the link that is seen, on average",
) -> str:
    """Return a map of a network.

    Parameters
    ----------
    shares
        value of each link from 0 to 1, NaN for one that is out of reach, (links,).
    marks
        texts at nodes; the first is the release, if it is in colour.
    stuck
        places that are marked with a cross.
    legend
        what the values are.

    Raises
    ------
    InputError
        if the network has no coordinates.
    """
    page = _fit(network)
    root = layout.start_page(
        page.box.bottom + _LEGEND, title, subtitle, f"A map of the water network {network.name}. {subtitle}."
    )
    lines = [page.to_page(network.polyline(link)) for link in range(len(network.links))]
    _draw_links(root, lines, shares)
    for kind, (x, y) in zip(network.node_kinds, page.to_page(network.places).tolist(), strict=True):
        if kind != "junction":
            _draw_source(root, kind, x, y, class_=kind)
    for mark in marks:
        x, y = page.to_page(network.places[[mark.node]])[0]
        svg.add_circle(root, x, y, 5 if mark.is_bold else 2.6, mark.colour, class_="mark")
    crosses = _draw_stuck(root, page, network, stuck)
    ink = np.vstack([layout.resample_polyline(line, 3) for line in lines if len(line) > 1])
    _write_marks(root, page, network, [*marks, *crosses], ink)
    _draw_legend(root, page, network, legend, bool(np.isfinite(shares).any()))
    return svg.render(root)


def _fit(network: Network) -> plot.Window:
    """Return the window of the page that shows a network; a unit of its map is a metre there."""
    points = np.vstack([network.places, *network.vertices])
    if not np.isfinite(points).all() or np.ptp(points, axis=0).max() <= 0:
        raise InputError(f"{network.name}: the file gives its nodes no coordinates: leave out --map")
    width = layout.WIDTH - 2 * layout.MARGIN
    return plot.Window.around((0, 1), points, layout.MARGIN, _TOP, width, _TALLEST, 20)


def choose_line(share: float) -> tuple[str, float]:
    """Return colour and width (px) of a link by the share of it that is seen."""
    step = int(np.searchsorted(BOUNDS, share, side="right"))
    return RAMP[step], _THIN + (_THICK - _THIN) * step / len(BOUNDS)


def _draw_links(root: ET.Element, lines: Sequence[FloatArray], shares: FloatArray) -> None:
    order = np.argsort(np.nan_to_num(shares, nan=-1.0), kind="stable")
    for link in order.tolist():
        colour, width = choose_line(shares[link]) if np.isfinite(shares[link]) else (UNREACHED, 1.0)
        svg.add_line(root, svg.path_data(lines[link]), colour, width, "link", stroke_linecap="round")


def _draw_source(root: ET.Element, kind: str, x: float, y: float, **named: str | float) -> None:
    """Draw a tank as a square, or a reservoir as a triangle, around a point."""
    shape: dict[str, str | float]
    if kind == "tank":
        tag, shape = "rect", {"x": x - 5, "y": y - 5, "width": 10, "height": 10}
    else:
        corners = [(x - 6, y - 5), (x + 6, y - 5), (x, y + 6)]
        tag, shape = "path", {"d": svg.path_data(corners, closed=True)}
    svg.add(root, tag, "", **named, **shape, fill="#ffffff", stroke=style.BLUE, stroke_width=2)


def _draw_stuck(root: ET.Element, page: plot.Window, network: Network, stuck: Sequence[Ending]) -> list[Mark]:
    """Draw a cross where bodies are stuck, larger for more; return texts for the most probable places."""
    marks = []
    nodes = {name: node for node, name in enumerate(network.nodes)}
    links = {name: link for link, name in enumerate(network.links)}
    for number, end in enumerate(stuck):
        if end.place in nodes and end.kind == "stuck":
            x, y = page.to_page(network.places[[nodes[end.place]]])[0]
        elif end.place in links:
            line = layout.resample_polyline(page.to_page(network.polyline(links[end.place])), 3)
            x, y = line[len(line) // 2]
        else:
            continue
        arm = 3 + 6 * np.sqrt(end.probability)
        strokes = np.array([x, y]) + arm * np.array([[(-1, -1), (1, 1)], [(-1, 1), (1, -1)]])
        look = {"stroke": style.VERMILLION, "stroke_width": "2.2", "stroke_linecap": "round"}
        svg.add(root, "path", class_="stuck", d=svg.lines_data(strokes), **look)
        if number < 4 and end.place in nodes:
            marks.append(Mark(nodes[end.place], f"{100 * end.probability:.0f} % stuck", style.VERMILLION))
    return marks


def _choose_times(passage: Passage) -> list[Mark]:
    """Return arrival times at probable nodes that are far from each other."""
    network = passage.network
    extent = np.ptp(network.places, axis=0).max()
    chosen = [passage.release]
    likely = (passage.probability >= 0.02) & np.isfinite(passage.age)
    for node in np.argsort(-passage.probability, kind="stable").tolist():
        if not likely[node] or len(chosen) > _MOST_TIMES:
            break
        near = np.linalg.norm(network.places[chosen] - network.places[node], axis=1).min()
        if near > 0.11 * extent:
            chosen.append(node)
    return [Mark(node, format_time(passage.age[node])) for node in chosen[1:]]


def format_time(seconds: float) -> str:
    """Return a duration in the unit that people would use.

    >>> format_time(42.0), format_time(600.0), format_time(9000.0), format_time(2e6)
    ('42 s', '10 min', '2.5 h', '23 d')
    """
    if not np.isfinite(seconds):
        return "-"
    for limit, unit, size in ((90, "s", 1.0), (5400, "min", 60.0), (172_800, "h", 3600.0)):
        if seconds < limit:
            return f"{seconds / size:.1f} {unit}" if unit == "h" else f"{seconds / size:.0f} {unit}"
    return f"{seconds / 86_400:.0f} d"


def _write_marks(
    root: ET.Element, page: plot.Window, network: Network, marks: Sequence[Mark], ink: FloatArray
) -> None:
    if not marks:
        return
    anchors = page.to_page(network.places[[mark.node for mark in marks]])
    texts = [layout.shorten(mark.text, 12, 140, bold=True) for mark in marks]
    widths = [layout.text_width(text, 12, bold=mark.is_bold) for text, mark in zip(texts, marks, strict=True)]
    boxes = layout.place_labels(anchors, widths, 14, ink, page.box)
    for text, mark, box in zip(texts, marks, boxes, strict=True):
        middle, base, bold = (box.left + box.right) / 2, box.bottom - 3, mark.is_bold
        layout.write(root, middle, base, text, 12, mark.colour, "middle", bold=bold, halo=True)


def _draw_legend(root: ET.Element, page: plot.Window, network: Network, text: str, has_shares: bool) -> None:
    base = page.box.bottom + 34
    x = layout.MARGIN
    if has_shares:
        layout.write(root, x, base - 8, text, 11, style.MUTED)
        step = 34.0
        for number, least in enumerate((0.0, *BOUNDS)):
            colour, width = choose_line(least)
            y, left = base + 10, x + number * step
            svg.add_line(root, svg.path_data([(left + 3, y), (left + step - 3, y)]), colour, width)
            if number:
                layout.write(root, left, base + 28, f"{100 * least:g}", 11, style.MUTED, "middle")
        layout.write(root, x + len(RAMP) * step, base + 28, "100 %", 11, style.MUTED, "middle")
        x += step * len(RAMP) + 30
        svg.add_line(root, svg.path_data([(x, base + 10), (x + 24, base + 10)]), UNREACHED, 1.0)
        layout.write(root, x + 30, base + 14, "out of reach", 11, style.MUTED)
        x += 120
    _draw_source(root, "tank", x + 5, base + 10)
    layout.write(root, x + 16, base + 14, "tank", 11, style.MUTED)
    _draw_source(root, "reservoir", x + 66, base + 10)
    layout.write(root, x + 78, base + 14, "reservoir", 11, style.MUTED)
    metres = network.scale
    right = layout.WIDTH - layout.MARGIN
    if metres is None:
        layout.write(root, right, base + 14, "not drawn to scale", 11, style.MUTED, "end")
        return
    bar = layout.floor_to_nice_number(150 * metres / page.px_per_m)
    left = right - bar / metres * page.px_per_m
    ends = [(left, base + 6), (left, base + 10), (right, base + 10), (right, base + 6)]
    svg.add_line(root, svg.path_data(ends), style.INK, 1.2)
    text = f"{bar / 1000:g} km" if bar >= 1000 else f"{bar:g} m"
    layout.write(root, (left + right) / 2, base + 2, text, 11, style.INK, "middle")
