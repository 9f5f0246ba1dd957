"""Where a body goes in a network, when it arrives, what it sees and where it ends."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import breadth_first_order, connected_components
from scipy.sparse.linalg import SuperLU, splu

from driftform.types import FloatArray
from driftform_networks.hydraulics.network import STILL, BoolArray, IntArray, Network, Snapshot, divide_flow
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
        reason: how it leaves there, or why it does not, in a few words; a colon comes before what differs from place to
            place.
    """

    kind: str
    place: str
    probability: float
    reason: str


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

    def list_tables(self) -> dict[str, dict[str, list[Any]]]:
        """Return the tables by name."""
        return {"nodes": self.node_table(), "links": self.link_table(), "ends": self.end_table()}

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
        return self.network.tabulate_links(self.reachable, seen=self.seen)

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


def find_reachable(network: Network, release: int, steps: Sequence[int], passes: BoolArray | bool = True) -> BoolArray:
    """Return whether water of a node may reach each link by the flows of some hydraulic steps, where it ``passes``, (links,).

    Other sources and tanks end its route: what comes out of them is their water.
    """
    flow = network.hydraulics.flow[list(steps)] * passes
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
    kind, reason = network.node_kinds[node], f"in a {network.node_kinds[node]}"
    if kind == "junction":
        kind, reason = "demand", f"drawn off with the demand: {1000 * network.peak_demand[node]:.3g} l/s at most"
    return Ending(kind, network.nodes[node], probability, reason)


def word_ends(ends: Iterable[Ending], count: int = 1) -> str:
    """Return a line with the shares of ``count`` bodies that end for each reason, which add up to the whole."""
    shares = dict[str, float]()
    for end in ends:
        reason = end.reason.partition(":")[0]
        shares[reason] = shares.get(reason, 0.0) + end.probability / count
    parts = (
        f"{100 * shares[reason]:.1f} % {reason}"
        for reason in sorted(shares, key=lambda reason: -shares[reason])
        if shares[reason] >= 5e-4
    )
    return f"bodies end {', '.join(parts)}"


def merge_ends(ends: Iterable[Ending]) -> tuple[Ending, ...]:
    """Return ends of the same kind at the same place as one, the most probable first."""
    found: dict[tuple[str, str], Ending] = {}
    for end in ends:
        before = found.get((end.kind, end.place), Ending(end.kind, end.place, 0.0, end.reason))
        found[end.kind, end.place] = replace(before, probability=before.probability + float(end.probability))
    return tuple(sorted(found.values(), key=lambda end: (-end.probability, end.kind, end.place)))


LOST = 1e-9
"""Probability, for each link, that a body is no longer followed: it makes loops without an exit solvable."""


def follow(routings: Sequence[Routing], release: int) -> Passage:
    """Return where bodies go that enter the water at a node, and divide there like the water: as many by each of some tables.

    Raises InputError if no water flows from the node into a pipe.
    """
    parts = [_solve(routing, release) for routing in routings]
    visits, probability, spent, seen = (np.mean(column, axis=0) for column in list(zip(*parts, strict=True))[:4])
    with np.errstate(invalid="ignore", divide="ignore"):
        age = spent / visits
    ends = (replace(end, probability=end.probability / len(parts)) for part in parts for end in part[4])
    return make_passage(routings, release, routings[0].snapshot.hour, (visits, probability, age), seen, ends)


def _solve(routing: Routing, release: int) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, list[Ending]]:
    """Return visits and probability of each node, the sum of the times of its visits, what is seen of each link, and the ends.

    Expected entries x into the states satisfy x = first + x P, and their ages the same equation with the durations as
    source. The probability to ever enter a set of states A follows from the entries into A and those from A into A
    (Kemeny and Snell, Finite Markov Chains, section 3.2); outside loops it is the number of entries.
    """
    snapshot, network, bands = routing.snapshot, routing.snapshot.network, routing.bands
    links, nodes = len(snapshot.links), len(network.nodes)
    link = np.repeat(np.arange(links), bands)
    head = snapshot.head[link]
    first = (divide_flow(snapshot, release, routing.retained)[:, None] * routing.release).ravel()
    transfer, slowness, _ = routing.stack_runs()
    duration = (snapshot.duration[:, None] * slowness).ravel()
    step, held, leaves = _link_states(routing, transfer)
    stays = np.maximum(1 - held - leaves - step.sum(axis=1), 0.0)
    step = step * (1 - LOST)
    solver = splu(sparse.csc_array(sparse.eye_array(len(first)) - step.T))
    entries = solver.solve(first)
    # What rounding leaves of states that cannot be entered.
    entries[entries < 1e-15] = 0.0
    time = solver.solve(step.T @ (entries * duration))
    passes = entries * (1 - held)
    visits = _sum_up(head, passes, nodes)
    visits[release] += 1
    # The time of an arrival is that of the entry, and the time through the link.
    arrival_time = _sum_up(head, (time + entries * duration) * (1 - held), nodes)
    entered = _sum_up(link, entries, links)
    probability = np.minimum(visits, 1.0)
    enters = np.minimum(entries.reshape(links, bands).sum(axis=1), 1.0)
    for node in find_loops(snapshot):
        probability[node] = (1 - held) @ _enter_once(solver, entries, np.flatnonzero(head == node))
        for outlet in snapshot.outlets[node]:
            enters[outlet] = _enter_once(solver, entries, np.flatnonzero(link == outlet)).sum()
    probability[release] = 1.0
    seen = np.zeros(len(network.links))
    with np.errstate(invalid="ignore", divide="ignore"):
        passed = enters * _sum_up(link, passes, links) / entered
    seen[snapshot.links] = np.where(entered > 0, passed, 0.0)
    left = _sum_up(head, entries * leaves, nodes)
    left[release] += max(0.0, 1 - float(first.sum()))
    rests, stops = (_sum_up(link, entries * share, links) for share in (held, stays))
    ends = _list_ends(routing, left, rests, stops, LOST * float(entries.sum()))
    return visits, probability, arrival_time, seen, list(ends)


def _sum_up(place: IntArray, values: FloatArray, count: int) -> FloatArray:
    """Return the sums of values of states that are at the same place, (count,)."""
    return np.asarray(np.bincount(place, values, count), dtype=np.float64)


def _list_ends(
    routing: Routing, left: FloatArray, held: FloatArray, stays: FloatArray, lost: float
) -> Iterator[Ending]:
    """Yield the ends: out of the pipes at nodes, at rest in links and at their downstream ends, and in loops."""
    snapshot, network = routing.snapshot, routing.snapshot.network
    for node in np.flatnonzero(left > MIN_PROBABILITY).tolist():
        yield leave(network, node, left[node])
    for link in np.flatnonzero(stays > MIN_PROBABILITY).tolist():
        yield Ending("stuck", network.nodes[snapshot.head[link]], stays[link], routing.tables[link].obstacle)
    for link in np.flatnonzero(held > MIN_PROBABILITY).tolist():
        yield Ending("stuck", network.links[snapshot.links[link]], held[link], routing.transfers[link].obstacle)
    if lost > MIN_PROBABILITY:
        yield Ending("circling", "", lost, "in a loop without an exit")


def _link_states(routing: Routing, transfer: FloatArray) -> tuple[sparse.csr_array, FloatArray, FloatArray]:
    """Return the probability that a state follows another, sparse, and that the body rests in its link, or leaves after it."""
    bands = np.arange(routing.bands)
    outlets, choice, arrival = routing.stack_ends(routing.most)
    steps = np.einsum("lab,lbo,lboc->laoc", transfer, choice[..., :-1], arrival)
    states = np.arange(len(transfer) * len(bands)).reshape(-1, len(bands), 1, 1)
    following = outlets[:, None, :, None] * len(bands) + bands
    exists = steps > 0
    row, column = (np.broadcast_to(index, steps.shape)[exists] for index in (states, following))
    step = sparse.csr_array((steps[exists], (row, column)), (states.size, states.size))
    held = np.clip(1 - transfer.sum(axis=2), 0.0, 1.0)
    leaves = transfer @ choice[..., -1:]
    return step, held.ravel(), leaves.ravel()


def _enter_once(solver: SuperLU, entries: FloatArray, states: IntArray) -> FloatArray:
    """Return for each state the probability that it is the first of ``states`` that is entered, (states of the chain,)."""
    states = states[entries[states] > 0]
    unit = np.zeros((len(entries), len(states)))
    unit[states, np.arange(len(states))] = 1.0
    # Column b holds the entries into each state after a start in b.
    again = solver.solve(unit)[states]
    first = np.zeros_like(entries)
    first[states] = np.linalg.solve(again, entries[states])
    return first


def find_loops(snapshot: Snapshot) -> IntArray:
    """Return the nodes that water can come back to."""
    nodes = len(snapshot.network.nodes)
    ones = np.ones(len(snapshot.links))
    graph = sparse.csr_array((ones, (snapshot.tail, snapshot.head)), (nodes, nodes))
    _, label = connected_components(graph, directed=True, connection="strong")
    return np.flatnonzero(np.bincount(label)[label] > 1)
