"""Where a body goes in a network, when it arrives, what it sees and where it ends."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import breadth_first_order

from driftform.types import FloatArray
from driftform_networks.hydraulics.network import BoolArray, Network
from driftform_networks.hydraulics.snapshot import STILL
from driftform_networks.passages.routing import JOINT, TEE, Routing

QUANTILES = (0.05, 0.5, 0.95)
"""Quantiles of arrival times."""

MIN_PROBABILITY = 1e-6
"""Probability below which an end is left out."""


@dataclass(frozen=True)
class Ending:
    """One way in which bodies end.

    Attributes:
        kind: ``"demand"``, ``"tank"`` or ``"reservoir"`` for bodies that leave the pipes; ``"stuck"``; ``"circling"``
            for those that go round in a loop without an exit; ``"under way"`` at the end of the simulation.
        place: name of the node or link; empty for a loop.
        probability: of this end.
        reason: why it is stuck there, in a few words.
    """

    kind: str
    place: str
    probability: float
    reason: str = ""


@dataclass(frozen=True, eq=False)
class Passage:
    """Where a body goes that enters a network at a node.

    Attributes:
        release: node of the release.
        visits: mean number of its arrivals at each node, (nodes,); the release is one.
        probability: probability that it ever arrives at each node, (nodes,).
        age: mean time from the release to its arrivals at each node, s, (nodes,); NaN where it never comes.
        seen: expected share of each link that it passes, (links,).
        reachable: whether the water of the release reaches each link, (links,).
        ends: how it ends, most probable first.
        quantiles: arrival times of :data:`QUANTILES` of those that arrive at each node, s, (nodes, 3); NaN where none
            arrives, empty if no walks were made.
        unsteady: whether the flows changed on its route.
        gates: valves and the like that it passes: name of the link, what it is, and the probability of passing it.
        passings: how it passes the fittings on its routes, by node: :data:`~driftform_networks.passages.routing.TEE` or ``JOINT``
            where it was flown, else why streamtubes divide it.
        branches: the passages where branches leave the pipes at each side; empty if they were not asked for.
    """

    network: Network
    release: int
    hour: float
    visits: FloatArray
    probability: FloatArray
    age: FloatArray
    seen: FloatArray
    reachable: BoolArray
    ends: tuple[Ending, ...]
    quantiles: FloatArray = field(default_factory=lambda: np.zeros((0, len(QUANTILES))))
    unsteady: bool = False
    gates: Mapping[str, tuple[str, float]] = field(default_factory=dict)
    passings: Mapping[int, str] = field(default_factory=dict)
    branches: Mapping[str, "Passage"] = field(default_factory=dict)

    @property
    def coverage(self) -> float:
        """Expected share of the reachable length that the body sees; 0 if nothing is reachable."""
        length = np.where(self.reachable, self.network.worth, 0.0)
        return float(length @ self.seen / length.sum()) if length.sum() > 0 else 0.0

    @property
    def steps(self) -> range:
        """Hydraulic steps whose flows carry it."""
        first = self.network.hydraulics.find_step(self.hour)
        return range(first, len(self.network.hydraulics.times) if self.unsteady else first + 1)

    @property
    def stuck(self) -> tuple[Ending, ...]:
        """Places where bodies are stuck."""
        return tuple(end for end in self.ends if end.kind in ("stuck", "circling"))

    def as_document(self) -> dict[str, Any]:
        """Return the passage as plain values for JSON: nodes that are reached, coverage, ends."""
        names = self.network.nodes
        nodes: dict[str, dict[str, Any]] = {}
        for node in np.flatnonzero(self.probability > MIN_PROBABILITY):
            nodes[names[node]] = {"probability": float(self.probability[node]), "age": float(self.age[node])}
            if len(self.quantiles):
                nodes[names[node]]["age_quantiles"] = self.quantiles[node].tolist()
        links = self.link_table()
        return {
            "network": self.network.name,
            "release": names[self.release],
            "hour": self.hour,
            "unsteady": self.unsteady,
            "nodes": nodes,
            "links": dict(zip(links["link"], links["seen"], strict=True)),
            "coverage": self.coverage,
            "reachable_length": float(self.network.length[self.reachable].sum()),
            "ends": [asdict(end) for end in self.ends],
            "junctions": count_passings([self.passings]),
            "stuck": [asdict(end) for end in self.stuck],
            "passed": [
                {"link": link, "what": what, "probability": share} for link, (what, share) in self.gates.items()
            ],
        }

    def node_table(self) -> dict[str, list[Any]]:
        """Return the nodes that are reached as columns, for ``pandas.DataFrame(passage.node_table())``."""
        rows = np.flatnonzero(self.probability > MIN_PROBABILITY)
        columns: dict[str, list[Any]] = {
            "node": [self.network.nodes[row] for row in rows],
            "kind": [self.network.node_kinds[row] for row in rows],
            "x": self.network.places[rows, 0].tolist(),
            "y": self.network.places[rows, 1].tolist(),
            "probability": self.probability[rows].tolist(),
            "age_s": self.age[rows].tolist(),
            "clock": [self.network.hydraulics.format_clock(self.hour, self.age[row]) for row in rows],
        }
        if len(self.quantiles):
            for number, share in enumerate(QUANTILES):
                columns[f"age_{100 * share:g}_percent_s"] = self.quantiles[rows, number].tolist()
        return columns

    def link_table(self) -> dict[str, list[Any]]:
        """Return the reachable links as columns."""
        rows, network = np.flatnonzero(self.reachable), self.network
        corners = ([f"{x:.12g} {y:.12g}" for x, y in network.polyline(row)] for row in rows.tolist())
        return {
            "link": [network.links[row] for row in rows],
            "kind": [network.link_kinds[row] for row in rows],
            "start": [network.nodes[network.start[row]] for row in rows],
            "end": [network.nodes[network.end[row]] for row in rows],
            "length_m": network.length[rows].tolist(),
            "diameter_m": network.diameter[rows].tolist(),
            "seen": self.seen[rows].tolist(),
            "wkt": [f"LINESTRING ({', '.join(line)})" for line in corners],
        }

    def end_table(self) -> dict[str, list[Any]]:
        """Return the ends as columns."""
        return {field.name: [getattr(end, field.name) for end in self.ends] for field in fields(Ending)}


def list_rows(columns: Mapping[str, Sequence[Any]]) -> list[dict[str, Any]]:
    """Return a table of columns as rows."""
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def make_passage(
    routings: Sequence[Routing],
    release: int,
    hour: float,
    arrivals: tuple[FloatArray, FloatArray, FloatArray],
    seen: FloatArray,
    ends: Iterable[Ending],
    **more: Any,
) -> Passage:
    """Return the passage of a body by its tables: what they say of junctions, and of the water, is the same for all.

    Args:
        routings: tables of the hydraulic steps on its route.
        release, hour, seen, ends, more: attributes of :class:`Passage`; ends at the same place may be several.
        arrivals: ``visits``, ``probability`` and ``age``.
    """
    network, (_, probability, _) = routings[0].snapshot.network, arrivals
    gates = {
        network.links[link]: (table.gate, float(seen[link]))
        for routing in routings
        for link, table in zip(routing.snapshot.links.tolist(), routing.transfers, strict=True)
        if table.gate and seen[link] > MIN_PROBABILITY
    }
    reachable = find_reachable(network, release, [routing.snapshot.step for routing in routings])
    more |= {"gates": gates, "passings": find_passings(routings, probability)}
    return Passage(network, release, hour, *arrivals, seen, reachable, merge_ends(ends), **more)


def find_reachable(network: Network, release: int, steps: Sequence[int]) -> BoolArray:
    """Return whether water of a node may reach each link by the flows of some hydraulic steps, (links,).

    Other sources and tanks end its route: what comes out of them is their water.
    """
    flow = network.hydraulics.flow[list(steps)]
    forward, backward = (flow > STILL).any(axis=0), (flow < -STILL).any(axis=0)
    tails = np.concatenate([network.start[forward], network.end[backward]])
    heads = np.concatenate([network.end[forward], network.start[backward]])
    through = ~network.stores
    through[release] = True
    leads = through[tails]
    ends = (tails[leads], heads[leads])
    graph = sparse.csr_array((np.ones(leads.sum()), ends), (len(network.nodes),) * 2)
    reached = np.zeros(len(network.nodes), bool)
    reached[breadth_first_order(graph, release, return_predecessors=False)] = True
    reached &= through
    return np.asarray((forward & reached[network.start]) | (backward & reached[network.end]))


def find_passings(routings: Iterable[Routing], probability: FloatArray) -> dict[int, str]:
    """Return how bodies pass the fittings that they come to, by node; flights from one link count for its node."""
    found: dict[int, str] = {}
    for routing in routings:
        snapshot = routing.snapshot
        for node, table in zip(snapshot.head.tolist(), routing.tables, strict=True):
            if table.passing and probability[node] > MIN_PROBABILITY and found.get(node) not in (TEE, JOINT):
                found[node] = table.passing
    return found


def count_passings(passings: Iterable[Mapping[int, str]]) -> dict[str, Any]:
    """Return how many fittings bodies are flown through, by kind, and why streamtubes divide them at how many others."""
    merged: dict[int, str] = {}
    for one in passings:
        merged |= {node: how for node, how in one.items() if merged.get(node) not in (TEE, JOINT)}
    counts = Counter(merged.values())
    flown = {kind: counts.pop(kind, 0) for kind in (TEE, JOINT)}
    return {"flown": flown, "streamtubes": dict(counts.most_common())}


def leave(network: Network, node: int, probability: float) -> Ending:
    """Return the end of bodies that leave the pipes at a node."""
    kind = network.node_kinds[node]
    return Ending("demand" if kind == "junction" else kind, network.nodes[node], probability)


def merge_ends(ends: Iterable[Ending]) -> tuple[Ending, ...]:
    """Return ends of the same kind at the same place as one, the most probable first."""
    found: dict[tuple[str, str], Ending] = {}
    for end in ends:
        before = found.get((end.kind, end.place), Ending(end.kind, end.place, 0.0, end.reason))
        found[end.kind, end.place] = replace(before, probability=before.probability + float(end.probability))
    return tuple(sorted(found.values(), key=lambda end: (-end.probability, end.kind, end.place)))
