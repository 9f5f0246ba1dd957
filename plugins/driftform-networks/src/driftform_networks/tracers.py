"""Point tracers: they divide at each node like the water, and leave the pipes with the demand."""

import numpy as np

from driftform.errors import InputError
from driftform.types import FloatArray
from driftform_networks.chain import Visits, solve_chain
from driftform_networks.routing import Routing, RoutingTable, TransferTable
from driftform_networks.snapshot import Snapshot

_STRAIGHT = TransferTable(np.ones((1, 1)), np.ones(1))


def trace(snapshot: Snapshot, release: int) -> Visits:
    """Return where tracers go that enter the water at a node.

    Raises
    ------
    InputError
        if no water flows from the node into a pipe.
    """
    return follow(route_tracers(snapshot), release)


def follow(routing: Routing, release: int) -> Visits:
    """Return where bodies go that enter the water at a node, and divide there like the water.

    Raises
    ------
    InputError
        if no water flows from the node into a pipe.
    """
    first = divide_flow(routing.snapshot, release, routing.retained)[:, None] * routing.release
    return solve_chain(routing.make_chain(), release, first.ravel())


def route_tracers(snapshot: Snapshot, retained: bool = False) -> Routing:
    """Return the tables of point tracers: water mixes completely at each node, as EPANET assumes.

    Tracers that are ``retained`` do not leave with the demand of a node from which water flows on; at a dead end they do.
    """
    departure = snapshot.departure - (snapshot.exit if retained else 0.0)
    tables = []
    for node in snapshot.head.tolist():
        outlets = snapshot.outlets[node]
        choice = np.zeros((1, len(outlets)))
        if len(outlets) and not snapshot.stores[node]:
            choice[0] = snapshot.flow[outlets] / departure[node]
        tables.append(RoutingTable(choice, np.ones((1, len(outlets), 1)), 1 - choice.sum(axis=1)))
    return Routing(snapshot, [_STRAIGHT] * len(tables), tables, np.ones(1), retained)


def divide_flow(snapshot: Snapshot, node: int, retained: bool = False) -> FloatArray:
    """Return the probability that water at a node flows into each link of the snapshot, (links,).

    Bodies that are ``retained`` do not leave with the demand of the node.

    Raises
    ------
    InputError
        if it flows into none.
    """
    outlets, network = snapshot.outlets[node], snapshot.network
    if not len(outlets):
        raise InputError(
            f"--release {network.nodes[node]}: no water flows from it into a pipe at hour {snapshot.hour:g}: "
            "choose a node upstream, or another hour"
        )
    first = np.zeros(len(snapshot.links))
    whole = snapshot.departure[node] - (snapshot.exit[node] if retained else 0.0)
    first[outlets] = snapshot.flow[outlets] / whole
    return first
