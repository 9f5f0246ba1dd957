"""What a body does in a link and at its end: tables of probabilities over the bands of a bore."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from driftform.types import FloatArray
from driftform_networks.chain import Chain
from driftform_networks.snapshot import Snapshot


@dataclass(frozen=True, eq=False)
class RoutingTable:
    """What a body does at the end of a link, by the band in which it arrives.

    What is left of 1 in the sum of ``choice`` and ``leaves`` is the probability that the body is held there.

    Attributes
    ----------
    choice
        probability that it goes into each outlet, (bands, outlets).
    arrival
        probability of each band in which it enters an outlet, (bands, outlets, bands).
    leaves
        probability that it leaves the pipes with the demand, (bands,).
    obstacle
        what holds bodies there, in a few words.
    is_flown
        whether bodies were flown there.
    """

    choice: FloatArray
    arrival: FloatArray
    leaves: FloatArray
    obstacle: str = ""
    is_flown: bool = False


@dataclass(frozen=True, eq=False)
class TransferTable:
    """What a body does in a straight run, by the band in which it enters.

    What is left of 1 in a row of ``transfer`` is the probability that the body is held there.

    Attributes
    ----------
    transfer
        probability of each band in which it arrives at the end, (bands, bands).
    slowness
        mean time that it takes, relative to that of the water, (bands,).
    obstacle
        what holds bodies there, in a few words.
    """

    transfer: FloatArray
    slowness: FloatArray
    obstacle: str = ""


@dataclass(frozen=True, eq=False)
class Routing:
    """The tables of a body in a snapshot.

    Attributes
    ----------
    snapshot
        the flow.
    transfers
        for each link of the snapshot.
    tables
        at the downstream end of each link of the snapshot.
    release
        for a body that is released at a node: bands that it enters each outlet in, (bands,).
    retained
        whether the body is too wide for the pipes through which demand leaves.
    """

    snapshot: Snapshot
    transfers: Sequence[TransferTable]
    tables: Sequence[RoutingTable]
    release: FloatArray
    retained: bool = False

    @property
    def bands(self) -> int:
        """Number of bands of a bore."""
        return len(self.release)

    def make_chain(self) -> Chain:
        """Return the Markov chain of these tables."""
        snapshot, bands = self.snapshot, self.bands
        rows, columns, values, durations, held, leaves = [], [], [], [], [], []
        states = np.arange(bands)
        for link, (straight, table) in enumerate(zip(self.transfers, self.tables, strict=True)):
            outlets = snapshot.outlets[snapshot.head[link]]
            steps = np.einsum("ab,bo,boc->aoc", straight.transfer, table.choice, table.arrival)
            shape = steps.shape
            rows.append(np.broadcast_to((link * bands + states)[:, None, None], shape).ravel())
            columns.append(np.broadcast_to(outlets[:, None] * bands + states, shape).ravel())
            values.append(steps.ravel())
            durations.append(snapshot.duration[link] * straight.slowness)
            held.append(1 - straight.transfer.sum(axis=1))
            leaves.append(straight.transfer @ table.leaves)
        count = len(self.tables) * bands
        entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
        step = sparse.csr_array(entries, (count, count))
        step.eliminate_zeros()
        return Chain(
            snapshot,
            bands,
            step,
            np.concatenate(durations),
            np.clip(np.concatenate(held), 0.0, 1.0),
            np.concatenate(leaves),
        )
