"""Networks in notebooks and scripts: what the commands call."""

from collections.abc import Callable

import numpy as np

from driftform_networks.network import Network
from driftform_networks.passage import Passage, measure_quantiles, summarise_visits, summarise_walks
from driftform_networks.routing import Routing
from driftform_networks.snapshot import Snapshot, take_snapshot
from driftform_networks.tracers import follow, route_tracers
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
