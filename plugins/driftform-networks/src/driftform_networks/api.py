"""Networks in notebooks and scripts: what the commands call."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from driftform.errors import InputError
from driftform_networks.bodies import Traveller, open_traveller
from driftform_networks.chain import follow
from driftform_networks.junctions import SIDES
from driftform_networks.network import Network
from driftform_networks.passage import Passage
from driftform_networks.routing import Routing
from driftform_networks.snapshot import Snapshot, divide_flow, take_snapshot
from driftform_networks.tracers import route_tracers
from driftform_networks.travelling import Progress, Travel, Traveling, make_flights
from driftform_networks.walkers import measure_quantiles, summarise_walks, walk

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

    Args:
        network: from :func:`driftform_networks.open_network`.
        release: name of the node.
        hour: hour of the simulation at the release.
        unsteady: whether the flows change after the release, as EPANET computes them; otherwise they remain those of
            that hour.
        walks: tracers that are followed one by one for the quantiles of arrival times, and with ``unsteady`` for
            everything.
        seed: of these walks.

    Raises:
        InputError: if there is no such node or hour, no water leaves the node, or EPANET finds negative pressures.
    """
    snapshots = _take_snapshots(network, release, hour, unsteady)
    return _follow(snapshots, route_tracers, release, hour, unsteady, walks, seed)


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
    compare: bool = False,
) -> Passage:
    """Return where an agent goes that is released at a node, by flights in the bores of the network.

    Args:
        network, release, hour, unsteady, walks, seed: as for :func:`trace`.
        agent: body from :func:`driftform_networks.bodies.open_traveller`, or its name.
        travel: side where branches leave, and bore of service pipes.
        workers: processes that make flights; the result is the same for any number of them.
        cache: directory for flights; ``None`` for the user's.
        progress: takes the number of tables that are made, and of all.
        compare: whether the result also has the passages with branches at each side of the pipes; not with
            ``unsteady``.

    Raises:
        InputError: if there is no such agent, node or hour, no water leaves the node, or EPANET finds negative
            pressures.
        WorkFailedError: if the agent cannot be flown.
    """
    travel = travel or Travel()
    snapshots = _take_snapshots(network, release, hour, unsteady)
    traveller = open_traveller(agent) if isinstance(agent, str) else agent
    sides = (travel.branch, *(SIDES if compare and not unsteady else ()))
    travelings = {side: Traveling(traveller, replace(travel, branch=side), cache) for side in sides}
    make_flights(list(travelings.values()), snapshots, workers, progress)
    passage = _follow(snapshots, travelings[travel.branch].route, release, hour, unsteady, walks, seed)
    branches = {
        side: follow(travelings[side].route(snapshots[0]), passage.release)
        for side in SIDES
        if len(sides) > 1
    }
    return replace(passage, branches=branches)


def _take_snapshots(network: Network, release: str, hour: float, unsteady: bool) -> list[Snapshot]:
    """Return the flow at an hour, with ``unsteady`` that of each hydraulic step from then on.

    Raises:
        InputError: if there is no such node or hour, no water leaves the node at that hour, EPANET finds a negative
            pressure, or the simulation ends before the flow changes.
    """
    node, hydraulics = network.find_node(release), network.hydraulics
    snapshot = take_snapshot(network, hour)
    # Refuses a node that no water leaves, before the flights.
    divide_flow(snapshot, node)
    if not unsteady:
        return [snapshot]
    if hour * 3600 >= hydraulics.end:
        raise InputError(
            f"--at {hour:g}: the simulation of {network.name} ends at hour {hydraulics.end / 3600:g}, so that no flow "
            "changes later: leave out --unsteady, or choose an earlier hour"
        )
    return [take_snapshot(network, time / 3600) for time in hydraulics.times[snapshot.step :]]


def _follow(
    snapshots: Sequence[Snapshot],
    route: Callable[[Snapshot], Routing],
    release: str,
    hour: float,
    unsteady: bool,
    walks: int,
    seed: int,
) -> Passage:
    """Return the passage of bodies whose tables ``route`` makes; the other parameters are those of :func:`trace`.

    Where the flows remain, the chain of the tables is solved; walks only add the distribution of arrival times. Where they
    change, a body may come back, and what it has seen depends on its whole way: all of it is read from walks.
    """
    network, rng = snapshots[0].network, np.random.default_rng(seed)
    node, routings = network.find_node(release), [route(snapshot) for snapshot in snapshots]
    if unsteady:
        times = [*network.hydraulics.times[snapshots[0].step :], network.hydraulics.end]
        return summarise_walks(walk(routings, times, node, np.full(walks, 3600 * hour), rng), routings)
    passage = follow(routings[0], node)
    if not walks:
        return passage
    found = walk(routings, [0.0, np.inf], node, np.zeros(walks), rng)
    reached = passage.probability[:, None] > 0
    return replace(passage, quantiles=np.where(reached, measure_quantiles(found), np.nan))
