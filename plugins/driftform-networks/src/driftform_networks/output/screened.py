"""``driftform network bodies``: what bodies meet, in one table and on one map."""

from collections import Counter
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from driftform.figures import style
from driftform_networks.output.map import Mark, format_time, network_svg
from driftform_networks.output.results import Outputs, TextTable, list_lines, present
from driftform_networks.passages.passage import Ending, Passage
from driftform_networks.planning.screening import Screened, list_catches

_HEADER = ("body", "net weight g", "goes into %", "nodes", "worst at", "rides %", "drags %", "stops %", "ways end at")


def present_bodies(bodies: Sequence[Screened], best: Screened, passage: Passage, outputs: Outputs) -> None:
    """Print what bodies meet, and draw on request where the best goes and stops."""
    network, facts = passage.network, best.facts
    clock, rows = partial(network.hydraulics.format_clock, age=0.0), []
    for one in (body.facts for body in bodies):
        worst, weight = one["worst"], -1000 * one["net_buoyancy"] / best.body.scenario.fluid.gravity + 0.0
        states = [f"{100 * worst[name]:.0f}" if one["reach"] else "-" for name in ("rides", "drags", "stops")]
        row = [one["body"], f"{weight:.2f}", f"{100 * one['reach']:.1f}", f"{one['nodes']}", clock(worst["hour"])]
        rows.append([*row, *states, f"{(count := len(one['closed']))} link{'s' * (count != 1)}"])
    reasons = Counter(reason.partition(":")[0] for reason in facts["closed"].values()).most_common()
    document: dict[str, Any] = {
        "network": network.name,
        "release": network.nodes[passage.release],
        "hour": passage.hour,
    }
    document |= {"use": facts["body"], "bodies": [one.facts for one in bodies], "catch": list_catches(passage)}
    words = {
        "reasons": reasons,
        "length": network.length.sum(),
        "clock": network.hydraulics.format_clock,
        "time": format_time,
    }
    title = f"{network.name}: bodies from {document['release']} at hour {passage.hour:g}"
    lines = list_lines("bodies.txt", **document | words | {"use": facts})
    table = TextTable("What bodies meet", _HEADER, rows, range(1, 9), len(rows))
    figure = partial(_draw, best, passage, title, lines[0])
    present(document, [title, table, *lines], outputs.write_map(figure), outputs.json)


def _draw(best: Screened, passage: Passage, title: str, subtitle: str, page: style.Page) -> str:
    """Return the map, with the share of the time in which a body stops in each link, and where most come by bore."""
    network = passage.network
    shares = np.where(best.goes, best.stops, np.nan)
    crosses = [Ending("closed", link, 0.1, reason) for link, reason in best.facts["closed"].items()]
    marks = [
        Mark(network.find_node(one["node"]), f"{1000 * one['bore']:.0f} mm: {100 * one['probability']:.0f} %")
        for one in list_catches(passage)
    ]
    legend = "share of the time in which it stops there"
    return network_svg(network, shares, [passage.release], marks, title, subtitle, crosses, legend, page)
