"""Where a body goes in flows that do not change: the Markov chain over links and bands of their bore, solved."""

from collections.abc import Iterator

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import SuperLU, splu

from driftform.types import FloatArray
from driftform_networks.hydraulics.network import IntArray
from driftform_networks.hydraulics.snapshot import Snapshot, divide_flow
from driftform_networks.passages.passage import MIN_PROBABILITY, Ending, Passage, leave, make_passage
from driftform_networks.passages.routing import Routing

LOST = 1e-9
"""Probability, for each link, that a body is no longer followed: it makes loops without an exit solvable."""


def follow(routing: Routing, release: int) -> Passage:
    """Return where a body goes that enters the water at a node, and divides there like the water.

    Expected entries x into the states satisfy x = first + x P, and their ages the same equation with the durations as
    source. The probability to ever enter a set of states A follows from the entries into A and those from A into A
    (Kemeny and Snell, Finite Markov Chains, section 3.2); outside loops it is the number of entries.

    Raises InputError if no water flows from the node into a pipe.
    """
    snapshot, network, bands = routing.snapshot, routing.snapshot.network, routing.bands
    links, nodes = len(snapshot.links), len(network.nodes)
    link = np.repeat(np.arange(links), bands)
    head = snapshot.head[link]
    first = (divide_flow(snapshot, release, routing.retained)[:, None] * routing.release).ravel()
    duration = (snapshot.duration[:, None] * routing.slowness).ravel()
    step, held, leaves = _link_states(routing)
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
        age = arrival_time / visits
        passed = enters * _sum_up(link, passes, links) / entered
    seen[snapshot.links] = np.where(entered > 0, passed, 0.0)
    left = _sum_up(head, entries * leaves, nodes)
    left[release] += max(0.0, 1 - float(first.sum()))
    rests, stops = (_sum_up(link, entries * share, links) for share in (held, stays))
    ends = _list_ends(routing, left, rests, stops, LOST * float(entries.sum()))
    return make_passage([routing], release, snapshot.hour, (visits, probability, age), seen, ends)


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
        yield Ending("stuck", snapshot.name(link), held[link], routing.transfers[link].obstacle)
    if lost > MIN_PROBABILITY:
        yield Ending("circling", "", lost, "a loop without an exit")


def _link_states(routing: Routing) -> tuple[sparse.csr_array, FloatArray, FloatArray]:
    """Return the probability that a state follows another, sparse, and that the body rests in its link, or leaves after it."""
    transfer, bands = routing.transfer, np.arange(routing.bands)
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
