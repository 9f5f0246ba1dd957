"""Maps of a network as SVG: what is seen of each link, arrival times, and where bodies end."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from driftform.errors import InputError
from driftform.figures import layout, plot, style, svg
from driftform.types import FloatArray
from driftform_networks.hydraulics.network import Network
from driftform_networks.passages.passage import Ending, Passage
from driftform_networks.planning.fleets import Fleet
from driftform_networks.planning.plans import Plan

UNREACHED = "#d3d9de"
RAMP = ("#b5de2b", "#6ece58", "#35b779", "#1f9e89", "#26828e", "#31688e", "#482878", "#440154")
"""Viridis without its pale end, reversed: more of a link is seen where it is darker, for any colour vision."""

BOUNDS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.7)
"""Shares at which colour and width change: most links of a town are seen by a few of a hundred bodies."""

_TOP, _MAX_HEIGHT, _LEGEND, _LINE = 78.0, 720.0, 78.0, 34.0
_WIDE = 700.0
"""Width of a page on which the legend has room for one line, px."""

_THIN, _THICK = 1.4, 6.0
_MAX_TIMES = 14
"""Arrival times that are written on a map."""

_STEP = 34.0
"""Width of a step of the legend, px."""


@dataclass(frozen=True, eq=False)
class Mark:
    """A place on a map: a node, its name or another text, and its colour, which is that of ink unless it matters more than others."""

    node: int
    text: str
    colour: str = style.INK


def passage_svg(passage: Passage, title: str, subtitle: str, page: style.Page = style.SCREEN) -> str:
    """Return the map of a passage: probability as colour and width of a link, arrival times, stuck places."""
    shares, marks = np.where(passage.reachable, passage.seen, np.nan), _choose_times(passage)
    return network_svg(passage.network, shares, [passage.release], marks, title, subtitle, passage.stuck, page=page)


def fleet_svg(fleet: Fleet, title: str, subtitle: str, page: style.Page = style.SCREEN) -> str:
    """Return the map of a fleet: the probability that any member sees a link, and where members are stuck."""
    shares, releases = np.where(fleet.reachable, fleet.seen, np.nan), [one.passage.release for one in fleet.members]
    stuck = [replace(end, probability=end.probability / len(releases)) for end in fleet.stuck]
    legend = "probability that the fleet sees the link"
    return network_svg(fleet.network, shares, releases, [], title, subtitle, stuck, legend, page)


def plan_svg(plan: Plan, title: str, subtitle: str, page: style.Page = style.SCREEN) -> str:
    """Return the map of a plan: what bodies see until nets catch them, the releases, and the nets."""
    shares, find = np.where(plan.reachable, plan.seen, np.nan), plan.network.find_node
    nets = [
        Mark(find(name), f"net {name}: {100 * share:.0f} %", style.ORANGE)
        for name, share in zip(plan.nets, plan.catches, strict=True)
    ]
    releases, legend = [find(name) for _, name, _ in plan.members], "probability that any body sees the link"
    return network_svg(plan.network, shares, releases, nets, title, subtitle, (), legend, page)


def network_svg(
    network: Network,
    shares: FloatArray,
    releases: Sequence[int],
    marks: Sequence[Mark],
    title: str,
    subtitle: str,
    stuck: Sequence[Ending] = (),
    legend: str = "share of the link that is seen, on average",
    page: style.Page = style.SCREEN,
) -> str:
    """Return a map of a network: values of links, from 0 to 1, NaN out of reach, names of releases, texts at nodes, and crosses.

    Raises InputError if the network has no coordinates.
    """
    taken = {mark.node for mark in marks}
    named = (Mark(node, network.nodes[node], style.VERMILLION) for node in dict.fromkeys(releases) if node not in taken)
    marks = [*named, *marks]
    points = np.vstack([network.places, *network.vertices])
    if not np.isfinite(points).all() or np.ptp(points, axis=0).max() <= 0:
        raise InputError(f"{network.name}: the file gives its nodes no coordinates: leave out --map")
    # A unit of the map is a metre of the window.
    window = plot.Window.around((0, 1), points, layout.MARGIN, _TOP, page.width - 2 * layout.MARGIN, _MAX_HEIGHT, 20)
    lines = [window.to_page(network.polyline(link)) for link in range(len(network.links))]
    crosses, more = _place_crosses(network, lines, window.to_page(network.places), stuck)
    ink = np.vstack([layout.resample_polyline(line, 3) for line in lines])
    labels = _place_marks(window, network, [*marks, *more], ink)
    metres = network.scale or 0.0
    bar = layout.floor_to_nice_number(150 * metres / window.px_per_m) if metres else 0.0
    order = np.argsort(np.nan_to_num(shares, nan=-1.0), kind="stable")
    links, is_wide = [], page.width > _WIDE
    for link in order.tolist():
        known = bool(np.isfinite(shares[link]))
        colour, width = choose_line(shares[link]) if known else (UNREACHED, 1.0)
        value = f": {100 * shares[link]:.1f} %" if known else ""
        shown = {"d": svg.path_data(lines[link]), "colour": colour, "width": width}
        links.append(shown | {"name": network.links[link], "value": value})
    spots = window.to_page(network.places)
    steps = [(*choose_line(least), f"{100 * least:g}") for least in (0.0, *BOUNDS)]
    return svg.fill_template(
        "driftform_networks.output",
        "map.svg",
        width=page.width,
        height=window.box.bottom + (_LEGEND if is_wide else _LEGEND + 2 * _LINE),
        base=window.box.bottom + _LEGEND - 44,
        line=0 if is_wide else _LINE,
        top=_TOP - 14 if page.is_paper else 0,
        width_mm=page.width_mm,
        fonts=svg.PAPER_FONTS if page.is_paper else svg.FONTS,
        margin=layout.MARGIN,
        title=layout.shorten(title, 20, page.width - 2 * layout.MARGIN, bold=True),
        subtitle=subtitle,
        network=network.name,
        links=links,
        sources=[(network.node_kinds[node], *spots[node]) for node in np.flatnonzero(network.stores)],
        marks=[(*spots[mark.node], 5 if mark.colour != style.INK else 2.6, mark.colour) for mark in marks],
        crosses=crosses,
        labels=labels,
        step=_STEP,
        ramp=steps if np.isfinite(shares).any() else [],
        legend=legend,
        unreached=UNREACHED,
        nets=any(mark.colour == style.ORANGE for mark in marks),
        bar=bar / metres * window.px_per_m if metres else 0.0,
        bar_text=f"{bar / 1000:g} km" if bar >= 1000 else f"{bar:g} m",
    )


def choose_line(share: float) -> tuple[str, float]:
    """Return colour and width (px) of a link by the share of it that is seen."""
    step = int(np.searchsorted(BOUNDS, share, side="right"))
    return RAMP[step], _THIN + (_THICK - _THIN) * step / len(BOUNDS)


def _place_crosses(
    network: Network, lines: Sequence[FloatArray], spots: FloatArray, stuck: Sequence[Ending]
) -> tuple[list[tuple[float, float, float]], list[Mark]]:
    """Return crosses where bodies are stuck, larger for more, and texts for the most probable places."""
    crosses, marks = [], []
    nodes = {name: node for node, name in enumerate(network.nodes)}
    links = {name: link for link, name in enumerate(network.links)}
    for number, end in enumerate(stuck):
        if end.place in nodes and end.kind == "stuck":
            x, y = spots[nodes[end.place]].tolist()
            if number < 4:
                text = f"{end.place}: {100 * end.probability:.0f} % stuck"
                marks.append(Mark(nodes[end.place], text, style.VERMILLION))
        elif end.place in links:
            line = layout.resample_polyline(lines[links[end.place]], 3)
            x, y = line[len(line) // 2].tolist()
        else:
            continue
        crosses.append((x, y, 3 + 6 * float(np.sqrt(end.probability))))
    return crosses, marks


def _choose_times(passage: Passage) -> list[Mark]:
    """Return arrival times at probable nodes that are far from each other."""
    network = passage.network
    extent = np.ptp(network.places, axis=0).max()
    chosen = [passage.release]
    likely = (passage.probability >= 0.02) & np.isfinite(passage.age)
    for node in np.argsort(-passage.probability, kind="stable").tolist():
        if not likely[node] or len(chosen) > _MAX_TIMES:
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


def _place_marks(
    page: plot.Window, network: Network, marks: Sequence[Mark], ink: FloatArray
) -> list[tuple[float, float, str, str]]:
    """Return middle, baseline, text and colour of the texts at nodes."""
    if not marks:
        return []
    anchors = page.to_page(network.places[[mark.node for mark in marks]])
    texts = [layout.shorten(mark.text, 12, 140, bold=True) for mark in marks]
    widths = [
        layout.text_width(text, 12, bold=mark.colour != style.INK) for text, mark in zip(texts, marks, strict=True)
    ]
    boxes = layout.place_labels(anchors, widths, 14, ink, page.box)
    return [
        ((box.left + box.right) / 2, box.bottom - 3, text, mark.colour)
        for text, mark, box in zip(texts, marks, boxes, strict=True)
    ]
