"""Bodies followed one by one through flows that change with time, or that are those of one hour for ever."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from driftform.errors import InputError
from driftform.types import FloatArray
from driftform_networks.network import IntArray, Network
from driftform_networks.routing import Routing
from driftform_networks.snapshot import STILL, Snapshot, take_snapshot

LEFT, HELD_IN_LINK, HELD_AT_NODE, UNDER_WAY = range(4)
"""How a walk ends: out of the pipes at a node, at rest in a link or at a node, or not before the simulation ends."""

_LEAVES, _WAITS = -1, -2
"""In place of a link: out of the pipes, and nowhere as long as no water leaves the node."""


@dataclass(frozen=True, eq=False)
class Walks:
    """The ways of bodies through a network.

    Attributes
    ----------
    network
        the network.
    release
        node where they enter the water.
    began
        time of the release of each walk, s, (walks,).
    walk, link, node
        of each move from node to node: whose it is, the link, and the node that is reached, -1 if none is, (moves,).
    low, high
        least and greatest share of the link's length that the move reaches, from the link's start, (moves,).
    left, reached
        time at the begin and the end of each move, s, (moves,).
    ends
        how each walk ends: :data:`LEFT`, :data:`HELD_IN_LINK`, :data:`HELD_AT_NODE` or :data:`UNDER_WAY`, (walks,).
    place
        node, or link, where it ends, (walks,).
    """

    network: Network
    release: int
    began: FloatArray
    walk: IntArray
    link: IntArray
    node: IntArray
    low: FloatArray
    high: FloatArray
    left: FloatArray
    reached: FloatArray
    ends: IntArray
    place: IntArray

    @property
    def count(self) -> int:
        """Number of walks."""
        return len(self.began)

    def first_arrivals(self) -> tuple[IntArray, IntArray, FloatArray]:
        """Return walk, node and time since the release of each first arrival of a walk at a node, (arrivals,) each."""
        arrived = np.flatnonzero(self.node >= 0)
        # Moves of a walk are in the order of time, so that the first of each pair is the first arrival.
        key = self.walk[arrived] * len(self.network.nodes) + self.node[arrived]
        _, first = np.unique(key, return_index=True)
        rows = arrived[first]
        keep = self.node[rows] != self.release
        rows = rows[keep]
        return self.walk[rows], self.node[rows], self.reached[rows] - self.began[self.walk[rows]]

    def covered(self) -> tuple[IntArray, IntArray, FloatArray]:
        """Return walk, link and share of its length that the walk has seen, for each link that a walk enters."""
        links = len(self.network.links)
        key, index = np.unique(self.walk * links + self.link, return_inverse=True)
        low, high = np.full(len(key), np.inf), np.full(len(key), -np.inf)
        np.minimum.at(low, index, self.low)
        np.maximum.at(high, index, self.high)
        return key // links, key % links, high - low


def walk_snapshot(routing: Routing, release: int, count: int, rng: np.random.Generator) -> Walks:
    """Return walks through the flows of one hour, which never change."""
    snapshot = routing.snapshot
    flow = np.zeros(len(snapshot.network.links))
    forward = snapshot.tail == snapshot.network.start[snapshot.links]
    flow[snapshot.links] = np.where(forward, 1.0, -1.0) * snapshot.flow
    return _walk([routing], flow[None], np.array([0.0]), np.inf, release, np.zeros(count), rng)


def walk_network(
    network: Network,
    route: Callable[[Snapshot], Routing],
    release: int,
    hours: FloatArray,
    rng: np.random.Generator,
) -> Walks:
    """Return walks through the flows as they change until the end of the simulation.

    Parameters
    ----------
    route
        makes the tables of each hydraulic step.
    hours
        hour at which each walk begins, (walks,).

    Raises
    ------
    InputError
        if the simulation ends before such an hour, or EPANET finds a negative pressure later.
    """
    hydraulics, latest = network.hydraulics, float(np.max(hours))
    first = hydraulics.find_step(float(np.min(hours)))
    if latest * 3600 >= hydraulics.end:
        raise InputError(
            f"--at {latest:g}: the simulation of {network.name} ends at hour {hydraulics.end / 3600:g}, so that no flow "
            "changes later: leave out --unsteady, or choose an earlier hour"
        )
    times = hydraulics.times[first:]
    routings = [route(take_snapshot(network, time / 3600)) for time in times]
    return _walk(
        routings,
        hydraulics.flow[first:],
        times,
        hydraulics.end,
        release,
        3600 * np.asarray(hours, float),
        rng,
    )


def _walk(
    routings: Sequence[Routing],
    flow: FloatArray,
    times: FloatArray,
    end: float,
    release: int,
    began: FloatArray,
    rng: np.random.Generator,
) -> Walks:
    walk = _Walk(routings, flow, times, end, release, began)
    while walk.active.any():
        walk.choose(rng)
        walk.advance()
    moves = [np.concatenate(column) for column in zip(*walk.moves, strict=True)]
    # In the order of time for each walk.
    order = np.argsort(moves[0], kind="stable")
    network = routings[0].snapshot.network
    who, link, node, low, high, left, reached = (column[order] for column in moves)
    return Walks(network, release, began, who, link, node, low, high, left, reached, walk.ends, walk.place)


@dataclass(frozen=True, eq=False)
class _Tables:
    """The tables of all steps as arrays.

    Attributes
    ----------
    entry
        row of a link at a step in ``outlets``, ``fork`` and ``run``, -1 if its water stands still, (steps, links).
    outlets, fork, run
        links at the downstream end, (rows, most), and the numbers of its tables, (rows,).
    choice
        of each fork, cumulative over outlets and then out of the pipes, (forks, bands, most + 1).
    arrival, transfer
        cumulative over the bands that follow, (forks, bands, most, bands) and (runs, bands, bands).
    slowness
        of each run, (runs, bands).
    """

    entry: IntArray
    outlets: IntArray
    fork: IntArray
    run: IntArray
    choice: FloatArray
    arrival: FloatArray
    transfer: FloatArray
    slowness: FloatArray


class _Walk:
    """All walks at once: in turn, those at nodes choose a link, and those in links advance to its end or to a new flow."""

    def __init__(
        self,
        routings: Sequence[Routing],
        flow: FloatArray,
        times: FloatArray,
        end: float,
        release: int,
        began: FloatArray,
    ) -> None:
        network, count = routings[0].snapshot.network, len(began)
        self._tables = _number_tables(routings)
        self._first = _accumulate(routings[0].release)
        self._bands = routings[0].bands
        self._flow = np.where(np.abs(flow) > STILL, flow, 0.0)
        self._exit = np.array([routing.snapshot.exit * (not routing.retained) for routing in routings])
        self._times = np.append(times, end)
        self._near = _list_neighbours(network)
        self._sides = np.column_stack([network.start, network.end])
        self._volume = network.length * network.area
        self.active = np.ones(count, bool)
        self.ends, self.place = np.full(count, UNDER_WAY), np.full(count, release)
        self.moves: list[tuple[IntArray | FloatArray, ...]] = []
        """Rows of walk, link, node, low, high, left and reached."""
        self._t, self._step = began.copy(), np.searchsorted(times, began + 1e-6, side="right") - 1
        self._node, self._came, self._link = (np.full(count, value) for value in (release, -1, -1))
        self._band, self._following = np.zeros(count, np.int64), np.zeros(count, np.int64)
        self._x, self._low, self._high, self._left = (np.zeros(count) for _ in range(4))
        self._pace = np.ones(count)

    def choose(self, rng: np.random.Generator) -> None:
        """Choose a link, and the band in which it is entered, for all walks at nodes."""
        here = np.flatnonzero(self.active & (self._link < 0))
        if not len(here):
            return
        step, came, node = self._step[here], self._came[here], self._node[here]
        number, second, third = rng.random((3, len(here)))
        row = np.where(came >= 0, self._tables.entry[step, came], -1)
        arrives = self._sides[came, (self._flow[step, came] > 0).astype(int)] == node
        by_table = (row >= 0) & arrives
        link, held = np.empty(len(here), np.int64), np.zeros(len(here), bool)
        band = _pick(np.broadcast_to(self._first, (len(here), self._bands)), second)
        link[~by_table] = self._divide(step[~by_table], node[~by_table], number[~by_table])
        if by_table.any():
            t, at = self._tables, row[by_table]
            fork, was = t.fork[at], self._band[here[by_table]]
            chosen = _pick(t.choice[fork, was], number[by_table])
            most = t.outlets.shape[1]
            link[by_table] = np.where(chosen < most, t.outlets[at, np.minimum(chosen, most - 1)], _LEAVES)
            held[by_table] = chosen > most
            arrival = t.arrival[fork, was, np.minimum(chosen, most - 1)]
            band[by_table] = np.minimum(_pick(arrival, second[by_table]), self._bands - 1)
        self._finish(here[held], HELD_AT_NODE, node[held])
        leaves = ~held & (link == _LEAVES)
        self._finish(here[leaves], LEFT, node[leaves])
        waits = ~held & (link == _WAITS)
        self._wait(here[waits])
        enters = ~held & (link >= 0)
        self._enter(here[enters], link[enters], band[enters], third[enters])

    def _divide(self, step: IntArray, node: IntArray, number: FloatArray) -> IntArray:
        """Return links that lead away from nodes, chosen by flow, :data:`_LEAVES` or :data:`_WAITS`."""
        near = self._near[node]
        flow = self._flow[step[:, None], near]
        away = (near >= 0) & (self._sides[near, (flow < 0).astype(int)] == node[:, None])
        total = np.cumsum(np.where(away, np.abs(flow), 0.0), axis=1)
        whole = total[:, -1] + self._exit[step, node]
        chosen = _pick(total, number * whole)
        link = near[np.arange(len(near)), np.minimum(chosen, near.shape[1] - 1)]
        link = np.where(chosen < near.shape[1], link, _LEAVES)
        return np.where(whole > STILL, link, _WAITS)

    def _finish(self, walks: IntArray, how: int, place: IntArray) -> None:
        self.active[walks] = False
        self.ends[walks], self.place[walks] = how, place

    def _wait(self, walks: IntArray) -> None:
        """Let walks wait at their nodes until the flow changes."""
        self._step[walks] += 1
        self._t[walks] = self._times[self._step[walks]]
        late = walks[self._step[walks] == len(self._flow)]
        self._finish(late, UNDER_WAY, self._node[late])

    def _enter(self, walks: IntArray, link: IntArray, band: IntArray, number: FloatArray) -> None:
        run = self._tables.run[self._tables.entry[self._step[walks], link]]
        following = _pick(self._tables.transfer[run, band], number)
        held = following == self._bands
        self._finish(walks[held], HELD_IN_LINK, link[held])
        self._link[walks], self._band[walks], self._following[walks] = link, band, following
        self._pace[walks] = self._tables.slowness[run, band]
        self._x[walks] = np.where(self._flow[self._step[walks], link] > 0, 0.0, 1.0)
        self._low[walks] = self._high[walks] = self._x[walks]
        self._left[walks] = self._t[walks]

    def advance(self) -> None:
        """Advance all walks in links to the end of their links, or to the time at which the flow changes."""
        moving = np.flatnonzero(self.active & (self._link >= 0))
        if not len(moving):
            return
        link, step, x, t = self._link[moving], self._step[moving], self._x[moving], self._t[moving]
        flow, stop = self._flow[step, link], self._times[step + 1]
        still, onward = flow == 0, flow > 0
        volume = self._volume[link] * self._pace[moving]
        way = np.where(onward, 1.0 - x, x)
        with np.errstate(divide="ignore", invalid="ignore"):
            left = np.where(still, np.inf, way * volume / np.abs(flow))
            part = np.where(still, 0.0, flow * (stop - t) / volume)
        arrives = t + left <= stop
        x = np.where(arrives, onward.astype(float), x + np.where(arrives, 0.0, part))
        self._x[moving] = x
        self._low[moving] = np.minimum(self._low[moving], x)
        self._high[moving] = np.maximum(self._high[moving], x)
        self._t[moving] = np.where(arrives, t + left, stop)
        done = moving[arrives]
        self._node[done] = self._sides[link[arrives], onward[arrives].astype(int)]
        self._record(done, self._node[done])
        self._came[done], self._link[done], self._band[done] = self._link[done], -1, self._following[done]
        waiting = moving[~arrives]
        self._step[waiting] += 1
        late = waiting[self._step[waiting] == len(self._flow)]
        self._record(late, np.full(len(late), -1))
        self._finish(late, UNDER_WAY, self._link[late])

    def _record(self, walks: IntArray, node: IntArray) -> None:
        columns = (self._link, self._low, self._high, self._left, self._t)
        link, low, high, left, t = (column[walks] for column in columns)
        self.moves.append((walks, link, node, low, high, left, t))


def _pick(cumulative: FloatArray, number: FloatArray) -> IntArray:
    """Return for each row the index of the first cumulative probability above a number, their count if there is none."""
    return np.asarray((number[:, None] >= cumulative).sum(axis=1))


def _list_neighbours(network: Network) -> IntArray:
    """Return the links at each node, filled with -1, (nodes, most)."""
    ends = np.concatenate([network.start, network.end])
    links = np.tile(np.arange(len(network.links)), 2)
    order = np.argsort(ends, kind="stable")
    count = np.bincount(ends, minlength=len(network.nodes))
    near = np.full((len(count), count.max()), -1)
    near[np.arange(near.shape[1]) < count[:, None]] = links[order]
    return near


def _number_tables(routings: Sequence[Routing]) -> _Tables:
    """Return the tables of all steps as arrays, each different table once."""
    network, bands = routings[0].snapshot.network, routings[0].bands
    forks = {id(table): table for routing in routings for table in routing.tables}
    runs = {id(table): table for routing in routings for table in routing.transfers}
    fork_number = {key: number for number, key in enumerate(forks)}
    run_number = {key: number for number, key in enumerate(runs)}
    most = max(table.choice.shape[1] for table in forks.values())
    rows = sum(len(routing.tables) for routing in routings)
    entry = np.full((len(routings), len(network.links)), -1)
    outlets, fork, run = np.full((rows, most), -1), np.empty(rows, np.int64), np.empty(rows, np.int64)
    row = 0
    for step, routing in enumerate(routings):
        snapshot = routing.snapshot
        for link, table in enumerate(routing.tables):
            leading = snapshot.links[snapshot.outlets[snapshot.head[link]]]
            entry[step, snapshot.links[link]] = row
            outlets[row, : len(leading)] = leading
            fork[row], run[row] = fork_number[id(table)], run_number[id(routing.transfers[link])]
            row += 1
    choice = np.zeros((len(forks), bands, most + 1))
    arrival = np.zeros((len(forks), bands, most, bands))
    for number, table in enumerate(forks.values()):
        choice[number, :, : table.choice.shape[1]] = table.choice
        choice[number, :, most] = table.leaves
        arrival[number, :, : table.choice.shape[1]] = table.arrival
    return _Tables(
        entry,
        outlets,
        fork,
        run,
        _accumulate(choice),
        _accumulate(arrival),
        _accumulate(np.array([table.transfer for table in runs.values()])),
        np.array([table.slowness for table in runs.values()]),
    )


def _accumulate(probability: FloatArray) -> FloatArray:
    """Return cumulative probabilities along the last axis; rounding must not hold a body."""
    total = np.cumsum(probability, axis=-1)
    whole = total[..., -1:] > 1 - 1e-9
    return np.where(whole & (total > 1 - 1e-9), 1.0, total)
