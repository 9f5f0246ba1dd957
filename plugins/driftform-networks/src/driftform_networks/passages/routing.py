"""Routing tables: probabilities of what a body, or a point tracer, does in a link and at its end."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from driftform.types import FloatArray
from driftform_networks.hydraulics.network import BoolArray, IntArray, Snapshot

TEE, JOINT = "tees and crosses", "bends and reducers"
"""Fittings that bodies are flown through."""


@dataclass(frozen=True, eq=False)
class RoutingTable:
    """What a body does at the end of a link, by the band in which it arrives.

    What is left of 1 in the sum of ``choice`` and ``leaves`` is the probability that the body is held there.

    Attributes:
        choice: probability that it goes into each outlet, (bands, outlets).
        arrival: probability of each band in which it enters an outlet, (bands, outlets, bands).
        leaves: probability that it leaves the pipes with the demand, (bands,).
        obstacle: what holds bodies there, in a few words.
        passing: how bodies pass it: :data:`TEE` or :data:`JOINT` where they were flown, why streamtubes divide them in
            a few words, or empty where nothing divides or turns them.
    """

    choice: FloatArray
    arrival: FloatArray
    leaves: FloatArray
    obstacle: str = ""
    passing: str = ""


@dataclass(frozen=True, eq=False)
class TransferTable:
    """What a body does in a straight run, by the band in which it enters.

    What is left of 1 in a row of ``transfer`` is the probability that the body is held there.

    Attributes:
        transfer: probability of each band in which it arrives at the end, (bands, bands).
        slowness: mean time that it takes, relative to that of the water, (bands,).
        obstacle: what holds bodies there, in a few words.
        gate: what narrows the bore and lets bodies pass, such as a valve, in a few words.
        scatter: variance of this time, (bands,), or the same for all.
    """

    transfer: FloatArray
    slowness: FloatArray
    obstacle: str = ""
    gate: str = ""
    scatter: FloatArray | float = 0.0


@dataclass(frozen=True, eq=False)
class Routing:
    """The tables of a body in a snapshot.

    They are a Markov chain. A state is a link and the band of its bore in which the body enters it; its number is
    ``link * bands + band``. :func:`driftform_networks.passages.passage.follow` solves the chain, and
    :func:`driftform_networks.passages.walkers.walk` draws routes from it, also where the tables change with time.

    Attributes:
        snapshot: the flow.
        transfers: for each link of the snapshot.
        tables: at the downstream end of each link of the snapshot.
        release: for a body that is released at a node: bands that it enters each outlet in, (bands,).
        retained: whether the body is too wide for the pipes through which the demand of each node leaves, (nodes,), or of all.
    """

    snapshot: Snapshot
    transfers: Sequence[TransferTable]
    tables: Sequence[RoutingTable]
    release: FloatArray
    retained: BoolArray | bool = False

    @property
    def bands(self) -> int:
        """Number of bands of a bore."""
        return len(self.release)

    @property
    def most(self) -> int:
        """Largest number of outlets at the end of a link."""
        return max(1, *map(len, self.snapshot.outlets))

    def stack_runs(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return transfer, slowness and scatter of each link, (links, bands, bands) and twice (links, bands)."""
        count, bands = len(self.transfers), self.bands
        transfer = np.array([straight.transfer for straight in self.transfers]).reshape(count, bands, bands)
        times = [(straight.slowness, np.broadcast_to(straight.scatter, bands)) for straight in self.transfers]
        slowness, scatter = np.array(times).reshape(count, 2, bands).swapaxes(0, 1)
        return transfer, slowness, scatter

    def stack_ends(self, most: int) -> tuple[IntArray, FloatArray, FloatArray]:
        """Return what bodies do at the end of each link as arrays with room for ``most`` outlets.

        Returns:
            outlets, choice, arrival: links of the snapshot that lead on, filled with -1, (links, most); probability
                of each outlet, and as the last that of leaving the pipes, (links, bands, most + 1); probability of
                each band there, (links, bands, most, bands).
        """
        count, bands = len(self.tables), self.bands
        outlets = np.full((count, most), -1)
        choice, arrival = np.zeros((count, bands, most + 1)), np.zeros((count, bands, most, bands))
        for link, table in enumerate(self.tables):
            leading = self.snapshot.outlets[self.snapshot.head[link]]
            outlets[link, : len(leading)] = leading
            choice[link, :, : len(leading)], choice[link, :, most] = table.choice, table.leaves
            arrival[link, :, : len(leading)] = table.arrival
        return outlets, choice, arrival


_STRAIGHT = TransferTable(np.ones((1, 1)), np.ones(1))
_BLOCKED = TransferTable(np.zeros((1, 1)), np.ones(1), "before a pump or valve that lets no body pass")


def route_tracers(snapshot: Snapshot, retained: BoolArray | bool = False, blocked: Collection[int] = ()) -> Routing:
    """Return the tables of point tracers: water mixes completely at each node, as EPANET assumes.

    Tracers that are ``retained`` do not leave with the demand of a node from which water flows on; at a dead end they do.
    None pass links of the network that are ``blocked``.
    """
    departure = snapshot.departure - snapshot.exit * retained
    tables = []
    for node in snapshot.head.tolist():
        outlets = snapshot.outlets[node]
        choice = np.zeros((1, len(outlets)))
        if len(outlets) and not snapshot.network.stores[node]:
            choice[0] = snapshot.flow[outlets] / departure[node]
        tables.append(RoutingTable(choice, np.ones((1, len(outlets), 1)), 1 - choice.sum(axis=1)))
    straights = [_BLOCKED if link in blocked else _STRAIGHT for link in snapshot.links.tolist()]
    return Routing(snapshot, straights, tables, np.ones(1), retained)
