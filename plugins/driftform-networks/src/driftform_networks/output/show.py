"""``driftform network show``: the facts of a network and its flow."""

from functools import partial
from typing import Any

import numpy as np

from driftform.figures import style
from driftform_networks.flights.fits import read_gates
from driftform_networks.hydraulics.network import STILL, Network, Snapshot, take_snapshot, warn_of_model
from driftform_networks.output.map import Mark, network_svg
from driftform_networks.output.results import Outputs, TextTable, list_lines, present
from driftform_networks.passages.passage import find_loops


def show_network(network: Network, hour: float, outputs: Outputs) -> None:
    """Print the facts of a network, and draw its map on request."""
    snapshot = take_snapshot(network, hour, absurd=True)
    facts = describe_network(network, snapshot)
    supply = [
        (name, network.node_kinds[network.nodes.index(name)], f"{1000 * flow:.1f}")
        for name, flow in facts["supply"].items()
    ]
    names = {kind: gate.name for kind, gate in read_gates().items()}
    text: list[str | TextTable] = [*list_lines("show.txt", **facts, names=names)]
    text += [TextTable("Where water comes from", ("water comes from", "kind", "litres/s"), supply, (2,))]
    text += warn_of_model(network, range(len(network.hydraulics.times)))
    present(facts, text, outputs.write_map(partial(_draw, network, snapshot, hour)), outputs.json)


def _draw(network: Network, snapshot: Snapshot, hour: float, page: style.Page) -> str:
    """Return the map, with the speed of the water in each link."""
    fastest = float(snapshot.speed[np.isfinite(snapshot.speed)].max(initial=1e-9))
    shares = np.full(len(network.links), np.nan)
    shares[snapshot.links] = np.minimum(snapshot.speed / fastest, 1.0)
    sources = [Mark(node, network.nodes[node]) for node in np.flatnonzero(network.stores).tolist()]
    title = f"{network.name} at hour {hour:g}"
    subtitle = f"{len(network.nodes)} nodes, {network.length.sum() / 1000:.1f} km of pipe"
    legend = f"speed of the water, relative to {fastest:.2f} m/s"
    return network_svg(network, shares, [], sources, title, subtitle, legend=legend, page=page)


def describe_network(network: Network, snapshot: Snapshot) -> dict[str, Any]:
    """Return facts about a network and its flow at one hour as plain values for JSON."""
    hydraulics, pipes = network.hydraulics, network.is_pipe
    reverses = (hydraulics.flow > STILL).any(axis=0) & (hydraulics.flow < -STILL).any(axis=0)
    supply = -hydraulics.outflow[snapshot.step]
    flowing = pipes[snapshot.links]
    kinds = ((network.node_kinds, ("junction", "tank", "reservoir")), (network.link_kinds, ("pipe", *read_gates())))
    nodes, links = ({kind: there.count(kind) for kind in known if kind in there} for there, known in kinds)
    return {
        "name": network.name,
        "digest": network.digest,
        "nodes": nodes,
        "links": links,
        "length": float(network.length.sum()),
        "bore": [float(network.diameter[pipes].min()), float(network.diameter[pipes].max())],
        "duration": hydraulics.end,
        "steps": len(hydraulics.times),
        "reversing": int(reverses.sum()),
        "to_scale": network.scale is not None,
        "hour": snapshot.hour,
        "flowing": len(snapshot.links),
        "speed": float(np.median(snapshot.speed[flowing])) if flowing.any() else 0.0,
        "splitting": sum(len(outlets) > 1 for outlets in snapshot.outlets),
        "looping": len(find_loops(snapshot)),
        "supply": {network.nodes[node]: float(supply[node]) for node in np.flatnonzero(supply > STILL)},
        "warnings": list(hydraulics.warnings),
    }
