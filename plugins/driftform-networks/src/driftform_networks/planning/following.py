"""Where bodies go that are released at a node: the functions of notebooks, and what all commands share."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from driftform.errors import InputError
from driftform.util import progress
from driftform_networks.flights.bodies import Traveller, open_traveller
from driftform_networks.flights.junctions import SIDES
from driftform_networks.flights.travelling import Travel, Traveling, make_flights
from driftform_networks.hydraulics.network import BoolArray, Network, Snapshot, divide_flow, take_snapshot
from driftform_networks.passages.passage import Passage, find_reachable, follow
from driftform_networks.passages.routing import Routing, route_tracers
from driftform_networks.passages.walkers import Walks, join_walks, measure_quantiles, summarise_walks, walk


@dataclass(frozen=True)
class How:
    """How bodies are followed, and their flights made: the options of all functions that follow them.

    Attributes:
        steady: whether the flows remain those of the hour of the release; otherwise they change as EPANET computes them.
        walks: bodies that are followed one by one for the quantiles of arrival times, and in changing flows for
            everything.
        seed: of these walks.
        within: hours from the release after which nothing is seen any more; ``None`` without an end. With it everything
            is read from the walks.
        demand_error: standard deviation of the logarithm of a factor for all flows that a body meets: 0.1 for a model that is calibrated
            for planning (AWWA, Calibration guidelines for water distribution system modeling, 1999).
        travel: side where branches leave, bore of service pipes, and clearances.
        workers: processes that make flights; the result is the same for any number of them.
        cache: directory for flights; ``None`` for the user's.
    """

    steady: bool = False
    walks: int = 2000
    seed: int = 0
    within: float | None = None
    demand_error: float = 0.1
    travel: Travel = field(default_factory=Travel)
    workers: int = 1
    cache: Path | None = None

    def is_steady(self, network: Network) -> bool:
        """Return whether flows never change: as asked, or because EPANET computes those of one moment."""
        return self.steady or len(network.hydraulics.times) == 1

    def take_snapshots(self, network: Network, hour: float) -> list[Snapshot]:
        """Return the flow at an hour and, where flows change, that of each hydraulic step from then on, for the hours ``within``.

        Raises InputError if the simulation does not cover the hour, or ends before the flow changes or the hours have
        passed, or nobody walks in flows that change.
        """
        hydraulics, snapshot = network.hydraulics, take_snapshot(network, hour)
        is_steady = self.is_steady(network)
        if not self.walks and not (is_steady and self.within is None):
            raise InputError(
                "--walks 0: where flows change, or end, all is read from walks: choose 2000, or --steady HOUR"
            )
        if is_steady:
            return [snapshot]
        last = np.inf if self.within is None else (hour + self.within) * 3600
        if hour * 3600 >= hydraulics.end or hydraulics.end < last < np.inf:
            option = f"--at {hour:g}" if self.within is None else f"--within {self.within:g}h"
            raise InputError(
                f"{option}: {network.name} is simulated until hour {hydraulics.end / 3600:g}: choose an earlier hour or "
                "--steady HOUR, or lengthen Duration in [TIMES]"
            )
        times = hydraulics.times[snapshot.step + 1 :]
        return [snapshot, *(take_snapshot(network, time / 3600) for time in times[times < last])]

    def fly(
        self, travellers: Sequence[Traveller], travels: Sequence[Travel], snapshots: Sequence[Snapshot]
    ) -> list[list[Traveling]]:
        """Return what routes each body in each way to travel, by the weights that are drawn for it, its flights in the snapshots made."""
        made = [[Traveling(one, travel, self.cache) for one in body.drawn] for body in travellers for travel in travels]
        make_flights([*chain.from_iterable(made)], snapshots, self.workers)
        return made


@dataclass(frozen=True, eq=False)
class Case:
    """A release: node, hour, and the flows from then on, one for flows that do not change."""

    network: Network
    release: str
    hour: float
    snapshots: Sequence[Snapshot]
    how: How

    @property
    def node(self) -> int:
        """Node of the release."""
        return self.network.find_node(self.release)

    def find_reachable(self) -> BoolArray:
        """Return whether water of the release reaches each link, (links,)."""
        return find_reachable(self.network, self.node, [snapshot.step for snapshot in self.snapshots])

    def walk(self, drawn: Sequence[Sequence[Routing]]) -> Walks:
        """Return routes of bodies, as many by each of the tables that are drawn, those in each snapshot."""
        hydraulics, began = self.network.hydraulics, self.hour * 3600
        end = np.inf if self.how.is_steady(self.network) else hydraulics.end
        end = end if self.how.within is None else began + self.how.within * 3600
        times = [*(hydraulics.times[snapshot.step] for snapshot in self.snapshots), end]
        rng = np.random.default_rng(self.how.seed)
        starts = np.array_split(np.full(max(self.how.walks, 2), began), len(drawn))
        pairs = zip(drawn, starts, strict=True)
        return join_walks([walk(part, times, self.node, start, rng, self.how.demand_error) for part, start in pairs])

    def follow(self, *routes: Callable[[Snapshot], Routing]) -> Passage:
        """Return the passage of bodies, of which as many go by the tables that each of ``routes`` makes.

        Where the flows remain, the chain of the tables is solved; walks only add the distribution of arrival times. Where
        they change, a body may come back, and what it has seen depends on its whole route: all of it is read from walks.
        """
        how, drawn = self.how, [[route(snapshot) for snapshot in self.snapshots] for route in routes]
        routings = [*chain.from_iterable(drawn)]
        is_steady = how.is_steady(self.network)
        if not is_steady or how.within is not None:
            return summarise_walks(self.walk(drawn), routings, not is_steady)
        passage = follow(routings, self.node)
        if not how.walks:
            return passage
        reached = passage.probability[:, None] > 0
        return replace(passage, quantiles=np.where(reached, measure_quantiles(self.walk(drawn)), np.nan))


def find_cases(network: Network, releases: Sequence[str], hours: Sequence[float], how: How) -> list[Case]:
    """Return the releases at all nodes and hours at which water leaves the node.

    Raises InputError if there is no such node or hour, or no water leaves a node at any of the hours.
    """
    cases = list[Case]()
    nodes = {name: network.find_node(name) for name in dict.fromkeys(releases)}
    flows = {hour: how.take_snapshots(network, hour) for hour in dict.fromkeys(hours)}
    for name, node in nodes.items():
        found = [Case(network, name, hour, flow, how) for hour, flow in flows.items() if len(flow[0].outlets[node])]
        if not found:
            # Refuses a node that no water leaves, before the flights.
            divide_flow(next(iter(flows.values()))[0], node)
        cases += found
    return cases


def trace(network: Network, release: str, *, hour: float = 0.0, **how: Any) -> Passage:
    """Return where point tracers go that are released at a node: they divide like the water, without an error of demands.

    Args:
        network: from :func:`driftform_networks.open_network`.
        release: name of the node.
        hour: hour of the simulation at the release.
        how: attributes of :class:`driftform_networks.planning.following.How`.

    Raises InputError if there is no such node or hour, or no water leaves the node.
    """
    [case] = find_cases(network, [release], [hour], How(**{"demand_error": 0.0} | how))
    return case.follow(route_tracers)


def route(
    network: Network, agent: Traveller | str, release: str, *, hour: float = 0.0, compare: bool = False, **how: Any
) -> Passage:
    """Return where an agent goes that is released at a node, by flights in the bores of the network.

    Args:
        network, release, hour, how: as for :func:`trace`.
        agent: body from :func:`driftform_networks.flights.bodies.open_traveller`, or its name.
        compare: whether the result also has the passages with branches at each side of the pipes; not where flows
            change.

    Raises:
        InputError: if there is no such agent, node or hour, or no water leaves the node.
        WorkFailedError: if the agent cannot be flown.
    """
    [case] = find_cases(network, [release], [hour], How(**how))
    traveller = open_traveller(agent) if isinstance(agent, str) else agent
    travel, sides = case.how.travel, SIDES if compare and case.how.is_steady(network) else ()
    travels = [travel, *(replace(travel, branch=side) for side in sides)]
    first, *others = case.how.fly([traveller], travels, case.snapshots)
    passage = case.follow(*(one.route for one in first))
    shown = progress.track_progress(others, len(others), "sides where branches leave", 1.0)
    compared = (follow([one.route(case.snapshots[0]) for one in other], passage.release) for other in shown)
    return replace(passage, branches=dict(zip(sides, compared, strict=True)))
