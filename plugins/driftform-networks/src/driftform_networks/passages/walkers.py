"""Bodies followed one by one through flows that change with time, or that are those of one hour for ever."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import repeat
from typing import Any

import numpy as np

from driftform.types import FloatArray
from driftform_networks.hydraulics.network import STILL, IntArray, Network
from driftform_networks.passages.passage import QUANTILES, Ending, Passage, leave, make_passage
from driftform_networks.passages.routing import Routing

LEFT, HELD_IN_LINK, HELD_AT_NODE, UNDER_WAY, CIRCLING = range(5)
"""How a walk ends: out of the pipes at a node, at rest in a link or at a node, not before the simulation ends, or in a loop."""

MAX_MOVES = 10_000
"""Moves after which a body in flows that never change goes round in a loop without an exit."""

_LEAVES, _WAITS = -1, -2
"""In place of a link: out of the pipes, and nowhere as long as no water leaves the node."""


@dataclass(frozen=True, eq=False)
class Walks:
    """The routes of bodies through a network.

    Attributes:
        release: node where they enter the water.
        began: time of the release of each walk, s, (walks,).
        walk, link, node: of each move from node to node: whose it is, the link, and the node that is reached, -1 if
            none is, (moves,).
        low, high: least and greatest share of the link's length that the move reaches, from the link's start,
            (moves,).
        reached: time at the end of each move, s, (moves,).
        ends: how each walk ends, such as :data:`LEFT`, (walks,).
        place: node, or link, where it ends, (walks,).
    """

    network: Network
    release: int
    began: FloatArray
    walk: IntArray
    link: IntArray
    node: IntArray
    low: FloatArray
    high: FloatArray
    reached: FloatArray
    ends: IntArray
    place: IntArray

    @cached_property
    def ages(self) -> FloatArray:
        """Time since the release at the end of each move, s, (moves,)."""
        return np.asarray(self.reached - self.began[self.walk])

    def first_arrivals(self) -> IntArray:
        """Return the moves that end in the first arrival of a walk at a node, (arrivals,)."""
        arrived = np.flatnonzero(self.node >= 0)
        # Moves of a walk are in the order of time, so that the first of each pair is the first arrival.
        key = self.walk[arrived] * len(self.network.nodes) + self.node[arrived]
        rows = arrived[np.unique(key, return_index=True)[1]]
        return np.asarray(rows[self.node[rows] != self.release])

    def until(self, limit: FloatArray) -> "Walks":
        """Return the same walks with the moves alone that end before a time since their release, s, (walks,)."""
        kept = self.ages <= limit[self.walk] + 1e-6
        moves = {name: getattr(self, name)[kept] for name in ("walk", "link", "node", "low", "high", "reached")}
        return replace(self, **moves)

    def measure_records(self) -> FloatArray:
        """Return the length that each walk has seen, weighted, when each of its moves ends, m, (moves,)."""
        order = np.argsort(self.walk, kind="stable")
        key = self.walk[order] * len(self.network.links) + self.link[order]
        fresh = np.zeros(len(key), bool)
        fresh[np.unique(key, return_index=True)[1]] = True
        gain = fresh * (self.high - self.low)[order] * self.network.worth[self.link[order]]
        total = np.cumsum(gain)
        first = np.searchsorted(self.walk[order], self.walk[order])
        record = np.empty(len(key))
        record[order] = total - (total - gain)[first]
        return record

    def measure_sight(self) -> FloatArray:
        """Return the mean share of the length of each link that a walk has seen, (links,)."""
        links = len(self.network.links)
        key, index = np.unique(self.walk * links + self.link, return_inverse=True)
        low, high = np.full(len(key), np.inf), np.full(len(key), -np.inf)
        np.minimum.at(low, index, self.low)
        np.maximum.at(high, index, self.high)
        return np.bincount(key % links, high - low, links) / len(self.began)


def join_walks(parts: Sequence[Walks]) -> Walks:
    """Return walks from one release as one, numbered on."""
    names = ("began", "link", "node", "low", "high", "reached", "ends", "place")
    joined: dict[str, Any] = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
    firsts = np.cumsum([0, *(len(part.began) for part in parts[:-1])])
    numbers = np.concatenate([part.walk + first for part, first in zip(parts, firsts, strict=True)])
    return replace(parts[0], walk=numbers, **joined)


def walk(
    routings: Sequence[Routing],
    times: Sequence[float],
    release: int,
    began: FloatArray,
    rng: np.random.Generator,
    demand_error: float = 0.0,
) -> Walks:
    """Return routes of bodies that are drawn from their tables.

    Args:
        routings: tables of each hydraulic step.
        times: begin of each of these steps, and the end of the last, s, (steps + 1,); infinite for flows that never
            change.
        release: node where the bodies enter the water.
        began: time at which each walk begins, s, (walks,).
        demand_error: standard deviation of the logarithm of one factor for all flows that a walk meets.
    """
    walkers = _Walkers(routings, np.array(times), release, began, rng, demand_error)
    for _ in repeat(None, MAX_MOVES) if np.isinf(times[-1]) else repeat(None):
        if not walkers.active.any():
            break
        walkers.choose()
        walkers.advance()
    walkers.ends[walkers.active] = CIRCLING
    moves = [np.concatenate(column) for column in zip(*walkers.moves, strict=True)]
    # In the order of time for each walk.
    order = np.argsort(moves[0], kind="stable")
    who, link, node, low, high, reached = (column[order] for column in moves)
    network = routings[0].snapshot.network
    return Walks(network, release, began, who, link, node, low, high, reached, walkers.ends, walkers.place)


class _Walkers:
    """All walks at once: in turn, those at nodes choose a link, and those in links advance to its end or to a new flow."""

    def __init__(
        self,
        routings: Sequence[Routing],
        times: FloatArray,
        release: int,
        began: FloatArray,
        rng: np.random.Generator,
        demand_error: float,
    ) -> None:
        network, count = routings[0].snapshot.network, len(began)
        self._stack(routings)
        self._first = _accumulate(routings[0].release)
        self._bands, self._steps = routings[0].bands, len(routings)
        self._exit = np.array([routing.snapshot.exit * ~np.asarray(routing.retained) for routing in routings])
        self._kept = np.broadcast_to(routings[0].retained, len(network.nodes))
        self._times, self._rng, self._factor = times, rng, np.exp(demand_error * rng.standard_normal(count))
        self._near = _list_neighbours(network)
        self._sides = np.column_stack([network.start, network.end])
        self._volume = network.length * network.area
        self.active = np.ones(count, bool)
        self.ends, self.place = np.full(count, UNDER_WAY), np.full(count, release)
        self.moves: list[tuple[IntArray | FloatArray, ...]] = []
        """Rows of walk, link, node, low, high and reached."""
        self._t, self._step = began.copy(), np.searchsorted(times[:-1], began + 1e-6, side="right") - 1
        self._node, self._came, self._link = (np.full(count, value) for value in (release, -1, -1))
        self._band, self._following = np.zeros(count, np.int64), np.zeros(count, np.int64)
        self._x, self._low, self._high = (np.zeros(count) for _ in range(3))
        self._pace = np.ones(count)

    def _stack(self, routings: Sequence[Routing]) -> None:
        """Join the tables of all steps: one row for each link at each step, with cumulative probabilities."""
        links, most = len(routings[0].snapshot.network.links), max(routing.most for routing in routings)
        self._flow = np.zeros((len(routings), links))
        self._row = np.full((len(routings), links), -1)
        """Row of a link at a step, -1 if its water does not move."""
        outlets, choices, arrivals, row = [], [], [], 0
        for step, routing in enumerate(routings):
            snapshot = routing.snapshot
            forward = snapshot.tail == snapshot.network.start[snapshot.links]
            self._flow[step, snapshot.links] = np.where(forward, snapshot.flow, -snapshot.flow)
            self._row[step, snapshot.links] = row + np.arange(len(snapshot.links))
            row += len(snapshot.links)
            leading, choice, arrival = routing.stack_ends(most)
            outlets.append(np.where(leading >= 0, snapshot.links[leading], -1))
            choices.append(choice)
            arrivals.append(arrival)
        self._outlets = np.concatenate(outlets)
        self._choice, self._arrival = (_accumulate(np.concatenate(part)) for part in (choices, arrivals))
        runs = zip(*(routing.stack_runs() for routing in routings), strict=True)
        transfer, self._slowness, self._scatter = (np.concatenate(part) for part in runs)
        self._transfer = _accumulate(transfer)

    def choose(self) -> None:
        """Choose a link, and the band in which it is entered, for all walks at nodes."""
        here = np.flatnonzero(self.active & (self._link < 0))
        if not len(here):
            return
        step, came, node = self._step[here], self._came[here], self._node[here]
        number, second, third = self._rng.random((3, len(here)))
        row = np.where(came >= 0, self._row[step, came], -1)
        arrives = self._sides[came, (self._flow[step, came] > 0).astype(int)] == node
        by_table = (row >= 0) & arrives
        link, held = np.empty(len(here), np.int64), np.zeros(len(here), bool)
        band = _pick(np.broadcast_to(self._first, (len(here), self._bands)), second)
        link[~by_table] = self._divide(step[~by_table], node[~by_table], number[~by_table])
        at, was = row[by_table], self._band[here[by_table]]
        chosen, most = _pick(self._choice[at, was], number[by_table]), self._outlets.shape[1]
        outlet = np.minimum(chosen, most - 1)
        link[by_table] = np.where(chosen < most, self._outlets[at, outlet], _LEAVES)
        held[by_table] = chosen > most
        # At a dead end, a body waits for water that leads away.
        ended = (self._outlets[at] < 0).all(axis=1) & (chosen > most)
        link[by_table] = np.where(ended, _WAITS, link[by_table])
        held[by_table] &= ~ended
        arrival = _pick(self._arrival[at, was, outlet], second[by_table])
        band[by_table] = np.minimum(arrival, self._bands - 1)
        self._finish(here[held], HELD_AT_NODE, node[held])
        leaves = ~held & (link == _LEAVES)
        self._finish(here[leaves], LEFT, node[leaves])
        # The others wait at their nodes until the flow changes.
        waits = here[~held & (link == _WAITS)]
        self._step[waits] += 1
        self._t[waits] = self._times[self._step[waits]]
        late = waits[self._step[waits] == self._steps]
        self._finish(late, np.where(self._kept[self._node[late]], HELD_AT_NODE, UNDER_WAY), self._node[late])
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

    def _finish(self, walks: IntArray, how: IntArray | int, place: IntArray) -> None:
        self.active[walks] = False
        self.ends[walks], self.place[walks] = how, place

    def _enter(self, walks: IntArray, link: IntArray, band: IntArray, number: FloatArray) -> None:
        row = self._row[self._step[walks], link]
        following = _pick(self._transfer[row, band], number)
        held = following == self._bands
        self._finish(walks[held], HELD_IN_LINK, link[held])
        self._link[walks], self._band[walks], self._following[walks] = link, band, following
        time, scatter = self._slowness[row, band], self._scatter[row, band]
        # What spreads along its way arrives after times of this distribution (Schroedinger 1915).
        drawn = self._rng.wald(time, time**3 / np.maximum(scatter, 1e-12))
        self._pace[walks] = np.where(scatter > 0, drawn, time) / self._factor[walks]
        self._x[walks] = np.where(self._flow[self._step[walks], link] > 0, 0.0, 1.0)
        self._low[walks] = self._high[walks] = self._x[walks]

    def advance(self) -> None:
        """Advance all walks in links to the end of their links, or to the time at which the flow changes."""
        moving = np.flatnonzero(self.active & (self._link >= 0))
        link, step, x, t = self._link[moving], self._step[moving], self._x[moving], self._t[moving]
        flow, stop = self._flow[step, link], self._times[step + 1]
        still, onward = flow == 0, flow > 0
        volume = self._volume[link] * self._pace[moving]
        distance = np.where(onward, 1.0 - x, x)
        with np.errstate(divide="ignore", invalid="ignore"):
            left = np.where(still, np.inf, distance * volume / np.abs(flow))
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
        late = waiting[self._step[waiting] == self._steps]
        self._record(late, np.full(len(late), -1))
        self._finish(late, UNDER_WAY, self._link[late])

    def _record(self, walks: IntArray, node: IntArray) -> None:
        link, low, high, t = (column[walks] for column in (self._link, self._low, self._high, self._t))
        self.moves.append((walks, link, node, low, high, t))


def _pick(cumulative: FloatArray, number: FloatArray) -> IntArray:
    """Return for each row the index of the first cumulative probability above a number, their count if none is."""
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


def _accumulate(probability: FloatArray) -> FloatArray:
    """Return cumulative probabilities along the last axis; rounding must not hold a body."""
    total = np.cumsum(probability, axis=-1)
    whole = total[..., -1:] > 1 - 1e-9
    return np.where(whole & (total > 1 - 1e-9), 1.0, total)


def summarise_walks(walks: Walks, routings: Sequence[Routing], unsteady: bool = True) -> Passage:
    """Return the passage of bodies that were followed one by one, with quantiles of their arrival times."""
    nodes = len(walks.network.nodes)
    rows = walks.first_arrivals()
    node, time = walks.node[rows], walks.ages[rows]
    arrivals = np.bincount(node, minlength=nodes)
    probability = arrivals / len(walks.began)
    with np.errstate(invalid="ignore"):
        age = np.bincount(node, time, nodes) / arrivals
    probability[walks.release], age[walks.release] = 1.0, 0.0
    visits = np.bincount(walks.node[walks.node >= 0], minlength=nodes) / len(walks.began)
    visits[walks.release] += 1
    arrived, sight, hour = (visits, probability, age), walks.measure_sight(), float(walks.began.min()) / 3600
    ends, quantiles = count_ends(walks, routings), measure_quantiles(walks)
    return make_passage(routings, walks.release, hour, arrived, sight, ends, quantiles=quantiles, unsteady=unsteady)


def count_ends(walks: Walks, routings: Sequence[Routing]) -> Iterator[Ending]:
    """Yield how walks end, and where."""
    network = walks.network
    for how in range(CIRCLING + 1):
        places, counts = np.unique(walks.place[walks.ends == how], return_counts=True)
        for place, share in zip(places.tolist(), (counts / len(walks.began)).tolist(), strict=True):
            if how == LEFT:
                yield leave(network, place, share)
            elif how == UNDER_WAY:
                yield Ending("under way", "", share, "under way when the time ends")
            elif how == CIRCLING:
                yield Ending("circling", "", share, "in a loop without an exit")
            else:
                name = (network.links if how == HELD_IN_LINK else network.nodes)[place]
                yield Ending("stuck", name, share, _find_obstacle(routings, how, place))


def _find_obstacle(routings: Sequence[Routing], how: int, place: int) -> str:
    """Return the first obstacle that the tables name at a place."""
    for routing in routings:
        in_link = how == HELD_IN_LINK
        at = np.flatnonzero((routing.snapshot.links if in_link else routing.snapshot.head) == place)
        tables = routing.transfers if in_link else routing.tables
        if found := next(filter(None, (tables[link].obstacle for link in at.tolist())), ""):
            return found
    return "where no water flows on"


def measure_quantiles(walks: Walks) -> FloatArray:
    """Return quantiles of the first arrivals at each node, s, (nodes, quantiles); NaN where no walk arrives."""
    found = np.full((len(walks.network.nodes), len(QUANTILES)), np.nan)
    rows = walks.first_arrivals()
    rows = rows[np.argsort(walks.node[rows], kind="stable")]
    nodes, starts = np.unique(walks.node[rows], return_index=True)
    # Where no walk arrives at all, split returns one empty part.
    for place, times in zip(nodes, np.split(walks.ages[rows], starts[1:]), strict=False):
        found[place] = np.quantile(times, QUANTILES)
    found[walks.release] = 0.0
    return found
