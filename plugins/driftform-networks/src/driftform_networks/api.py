"""Networks in notebooks and scripts: what the commands call."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from driftform_networks.bodies import Traveller, open_traveller
from driftform_networks.junctions import SIDES, Geometry
from driftform_networks.network import Network
from driftform_networks.passage import Passage, measure_quantiles, summarise_visits, summarise_walks
from driftform_networks.routing import Routing
from driftform_networks.snapshot import Snapshot, take_snapshot
from driftform_networks.tracers import divide_flow, follow, route_tracers
from driftform_networks.travelling import Progress, Travel, Traveling, make_flights
from driftform_networks.walkers import walk_network, walk_snapshot

WALKS = 2000
"""Walks by default."""


def trace(
    network: Network,
    release: str,
    *,
    hour: float = 0.0,
    unsteady: bool = False,
    walks: int = WALKS,
    seed: int = 0,
) -> Passage:
    """Return where point tracers go that are released at a node: they divide like the water.

    Parameters
    ----------
    network
        from :func:`driftform_networks.open_network`.
    release
        name of the node.
    hour
        hour of the simulation at the release.
    unsteady
        whether the flows change after the release, as EPANET computes them; otherwise they remain those of that hour.
    walks
        tracers that are followed one by one for the quantiles of arrival times, and with ``unsteady`` for everything.
    seed
        of these walks.

    Raises
    ------
    InputError
        if there is no such node or hour, no water leaves the node, or EPANET finds negative pressures.
    """
    return follow_bodies(network, route_tracers, release, hour, unsteady, walks, seed)


def route(
    network: Network,
    agent: Traveller | str,
    release: str,
    *,
    hour: float = 0.0,
    unsteady: bool = False,
    walks: int = WALKS,
    seed: int = 0,
    travel: Travel | None = None,
    workers: int = 1,
    cache: Path | None = None,
    progress: Progress = lambda _, __: None,
) -> Passage:
    """Return where an agent goes that is released at a node, by flights in the bores of the network.

    Parameters
    ----------
    network, release, hour, unsteady, walks, seed
        as for :func:`trace`.
    agent
        body from :func:`driftform_networks.bodies.open_traveller`, or its name.
    travel
        side where branches leave, and bore of service pipes.
    workers
        processes that make flights; the result is the same for any number of them.
    cache
        directory for flights; ``None`` for the user's.
    progress
        takes the number of tables that are made, and of all.

    Raises
    ------
    InputError
        if there is no such agent, node or hour, no water leaves the node, or EPANET finds negative pressures.
    WorkFailedError
        if the agent cannot be flown.
    """
    return route_by_branch(
        network,
        agent,
        release,
        hour=hour,
        unsteady=unsteady,
        walks=walks,
        seed=seed,
        travel=travel,
        workers=workers,
        cache=cache,
        progress=progress,
        compare=False,
    )[0]


def route_by_branch(
    network: Network,
    agent: Traveller | str,
    release: str,
    *,
    hour: float,
    unsteady: bool,
    walks: int,
    seed: int,
    travel: Travel | None,
    workers: int,
    cache: Path | None,
    progress: Progress,
    compare: bool,
) -> tuple[Passage, dict[str, Passage]]:
    """Return the result of :func:`route`, and with ``compare`` the same for branches at each side of the pipes.

    These have neither quantiles nor flows that change.
    """
    travel = travel or Travel()
    node = network.find_node(release)
    snapshots = [take_snapshot(network, hour)]
    # Refuses a node that no water leaves, before the flights.
    divide_flow(snapshots[0], node)
    if unsteady:
        snapshots += [
            take_snapshot(network, time / 3600) for time in network.hydraulics.times[snapshots[0].step :]
        ]
    traveller = open_traveller(agent) if isinstance(agent, str) else agent
    traveling = Traveling(traveller, Geometry(network, travel.branch), travel, cache)
    sides = {
        side: traveling if side == travel.branch else traveling.with_branch(side)
        for side in (SIDES if compare and not unsteady else ())
    }
    make_flights([traveling, *sides.values()], snapshots, workers, progress)
    passage = follow_bodies(network, traveling.route, release, hour, unsteady, walks, seed)
    others = {}
    for side, other in sides.items():
        routing = other.route(snapshots[0])
        others[side] = summarise_visits(follow(routing, node), routing)
    return passage, others


def follow_bodies(
    network: Network,
    route: Callable[[Snapshot], Routing],
    release: str,
    hour: float,
    unsteady: bool,
    walks: int,
    seed: int,
) -> Passage:
    """Return the passage of bodies whose tables ``route`` makes; the other parameters are those of :func:`trace`."""
    node, rng = network.find_node(release), np.random.default_rng(seed)
    snapshot = take_snapshot(network, hour)
    if unsteady:
        first = network.hydraulics.find_step(hour)
        routings: list[Routing] = []

        def keep(snapshot: Snapshot) -> Routing:
            routings.append(route(snapshot))
            return routings[-1]

        found = walk_network(network, keep, node, np.full(walks, hour), rng)
        return summarise_walks(found, routings, range(first, len(network.hydraulics.times)))
    routing = route(snapshot)
    passage = summarise_visits(follow(routing, node), routing)
    if not walks:
        return passage
    return passage.with_quantiles(measure_quantiles(walk_snapshot(routing, node, walks, rng)))
