"""``driftform network show``: what a network is."""

from pathlib import Path
from typing import Any

import numpy as np

from driftform.cli.output import CommandResult, TextTable
from driftform_networks.chain import find_loops
from driftform_networks.map import Mark, network_svg
from driftform_networks.network import Network
from driftform_networks.reading import open_network
from driftform_networks.results import Outputs, write_map
from driftform_networks.scale import is_to_scale
from driftform_networks.snapshot import STILL, Snapshot, take_snapshot

_ROUNDING = 1e-9
"""Flow that EPANET's rounding leaves in closed links, m3/s."""


def show_network(source: str, hour: float, map: Path | None, cache: Path | None) -> CommandResult:
    """Return what ``driftform network show`` prints, and draw the map if it is asked for."""
    Outputs(map).check()
    network = open_network(source, cache)
    snapshot = take_snapshot(network, hour)
    document: dict[str, Any] = describe_network(network, snapshot)
    files: tuple[Path, ...] = ()
    if map is not None:
        title = f"{network.name} at hour {hour:g}"
        fastest = float(snapshot.speed[np.isfinite(snapshot.speed)].max())
        shares = np.full(len(network.links), np.nan)
        shares[snapshot.links] = np.minimum(snapshot.speed / fastest, 1.0)
        sources = [
            Mark(node, network.nodes[node])
            for node, kind in enumerate(network.node_kinds)
            if kind != "junction"
        ]
        subtitle = f"{len(network.nodes)} nodes, {document['length'] / 1000:.1f} km of pipe"
        legend = f"speed of the water, relative to {fastest:.2f} m/s"
        files = write_map(network_svg(network, shares, sources, title, subtitle, legend=legend), map)
    document["files"] = [str(file) for file in files]
    rows = [
        ("nodes", ", ".join(f"{count} {kind}s" for kind, count in document["nodes"].items())),
        ("links", ", ".join(f"{count} {kind}s" for kind, count in document["links"].items())),
        (
            "pipes",
            f"{document['length'] / 1000:.2f} km, bore {1000 * document['bore'][0]:.0f} to {1000 * document['bore'][1]:.0f} mm",
        ),
        ("simulation", f"{document['duration'] / 3600:g} h in {document['steps']} hydraulic steps"),
        ("reversals", f"the flow of {document['reversing']} links changes its direction"),
        (
            "map",
            "drawn to scale"
            if document["to_scale"]
            else "not drawn to scale: angles are not those of the pipes",
        ),
        (f"hour {hour:g}", f"{document['flowing']} links flow, at a median of {document['speed']:.2f} m/s"),
        ("", f"{document['splitting']} nodes divide the flow; {document['looping']} lie in loops of flow"),
    ]
    supply = [
        (name, network.node_kinds[network.nodes.index(name)], f"{1000 * flow:.1f}")
        for name, flow in document["supply"].items()
    ]
    text: list[str | TextTable] = [network.name]
    text += [f"  {name:10}  {value}" for name, value in rows]
    text += [TextTable(("water comes from", "kind", "litres/s"), supply, right=(2,))]
    text += [f"warning: EPANET: {line}" for line in network.hydraulics.warnings]
    text += [f"wrote {file}" for file in files]
    return CommandResult(document, text)


def describe_network(network: Network, snapshot: Snapshot) -> dict[str, object]:
    """Return facts about a network and its flow at one hour as plain values for JSON."""
    hydraulics, pipes = network.hydraulics, np.array([kind == "pipe" for kind in network.link_kinds])
    reverses = (hydraulics.flow > _ROUNDING).any(axis=0) & (hydraulics.flow < -_ROUNDING).any(axis=0)
    supply = -hydraulics.outflow[snapshot.step]
    flowing = pipes[snapshot.links]
    return {
        "name": network.name,
        "digest": network.digest,
        "nodes": _count(network.node_kinds, ("junction", "tank", "reservoir")),
        "links": _count(network.link_kinds, ("pipe", "pump", "valve")),
        "length": float(network.length.sum()),
        "bore": [float(network.diameter[pipes].min()), float(network.diameter[pipes].max())],
        "duration": hydraulics.end,
        "steps": len(hydraulics.times),
        "reversing": int(reverses.sum()),
        "to_scale": is_to_scale(network) is not None,
        "hour": snapshot.hour,
        "flowing": len(snapshot.links),
        "speed": float(np.median(snapshot.speed[flowing])) if flowing.any() else 0.0,
        "splitting": sum(len(outlets) > 1 for outlets in snapshot.outlets),
        "looping": len(find_loops(snapshot)),
        "supply": {network.nodes[node]: float(supply[node]) for node in np.flatnonzero(supply > STILL)},
        "warnings": list(hydraulics.warnings),
    }


def _count(kinds: tuple[str, ...], known: tuple[str, ...]) -> dict[str, int]:
    return {kind: kinds.count(kind) for kind in known if kind in kinds}
