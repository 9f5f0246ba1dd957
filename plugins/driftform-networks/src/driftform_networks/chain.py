"""A Markov chain over the links of a snapshot and the bands of their bore: visits, probabilities, ages."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import SuperLU, splu

from driftform.types import FloatArray
from driftform_networks.network import IntArray
from driftform_networks.snapshot import Snapshot

LOST = 1e-9
"""Probability, for each link, that a body is no longer followed: it makes loops without an exit solvable."""


@dataclass(frozen=True, eq=False)
class Chain:
    """The motion of a body through the links of a snapshot.

    A state is a link and the band of its bore in which the body enters it; state ``link * bands + band``.

    Attributes
    ----------
    snapshot
        the links.
    bands
        number of bands of a bore.
    step
        probability that a state follows another, (states, states), sparse.
    duration
        mean time that the body takes through the link of each state, s, (states,).
    held
        probability that the body comes to rest within the link of each state, (states,).
    leaves
        probability that it leaves the pipes at the downstream end of that link, (states,).
    """

    snapshot: Snapshot
    bands: int
    step: sparse.csr_array
    duration: FloatArray
    held: FloatArray
    leaves: FloatArray

    @property
    def stays(self) -> FloatArray:
        """Probability that the body comes to rest at the downstream end of the link of each state, (states,)."""
        return np.asarray(np.maximum(1 - self.held - self.leaves - self.step.sum(axis=1), 0.0))

    @property
    def link(self) -> IntArray:
        """Link of each state, (states,)."""
        return np.repeat(np.arange(len(self.snapshot.links)), self.bands)


@dataclass(frozen=True, eq=False)
class Visits:
    """Where a body of a chain goes.

    Attributes
    ----------
    chain
        the chain.
    release
        node where the body enters the water.
    first
        probability that it enters a link there, and does not leave the pipes at once.
    entries
        expected number of entries into each state, (states,).
    time
        sum over these entries of the time since the release, s, (states,).
    link_probability
        probability that the body enters each link of the snapshot, (links,).
    link_age
        mean time from the release to the entry into each link, s, (links,); NaN where it never comes.
    node_visits
        expected number of arrivals at each node, (nodes,).
    node_probability
        probability that the body ever arrives at each node, (nodes,).
    node_age
        mean time from the release to the arrivals at each node, s, (nodes,); NaN where it never comes.
    """

    chain: Chain
    release: int
    first: float
    entries: FloatArray
    time: FloatArray
    link_probability: FloatArray
    link_age: FloatArray
    node_visits: FloatArray
    node_probability: FloatArray
    node_age: FloatArray


def solve_chain(chain: Chain, release: int, first: FloatArray) -> Visits:
    """Return where a body goes that enters the states with probabilities ``first``, (states,), from a node.

    Expected entries x satisfy x = first + x P, and their ages the same equation with the durations as source. The
    probability to ever enter a set of states A follows from the entries into A and those from A into A (Kemeny and
    Snell, Finite Markov Chains, section 3.2); outside loops it is the number of entries.
    """
    snapshot = chain.snapshot
    count, nodes = len(first), len(snapshot.network.nodes)
    step = chain.step * (1 - LOST)
    solver = splu(sparse.csc_array(sparse.eye_array(count) - step.T))
    entries = solver.solve(first)
    # What rounding leaves of states that cannot be entered.
    entries[entries < 1e-15] = 0.0
    time = solver.solve(step.T @ (entries * chain.duration))
    arrives = 1 - chain.held
    head = snapshot.head[chain.link]
    visits = np.asarray(np.bincount(head, entries * arrives, nodes), dtype=np.float64)
    # The time of an arrival is that of the entry, and the time through the link.
    arrival_time = np.bincount(head, (time + entries * chain.duration) * arrives, nodes)
    visits[release] += 1
    probability = np.minimum(visits, 1.0)
    link_entries = entries.reshape(-1, chain.bands).sum(axis=1)
    link_probability = np.minimum(link_entries, 1.0)
    for node in find_loops(snapshot):
        probability[node] = arrives @ _enter_once(solver, entries, np.flatnonzero(head == node))
        for link in snapshot.outlets[node]:
            states = np.arange(link * chain.bands, (link + 1) * chain.bands)
            link_probability[link] = _enter_once(solver, entries, states).sum()
    probability[release] = 1.0
    with np.errstate(invalid="ignore", divide="ignore"):
        return Visits(
            chain,
            release,
            float(first.sum()),
            entries,
            time,
            link_probability,
            time.reshape(-1, chain.bands).sum(axis=1) / link_entries,
            visits,
            probability,
            arrival_time / visits,
        )


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
