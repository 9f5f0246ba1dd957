"""Point tracers: they divide at each node like the water, and leave the pipes with the demand."""

from collections.abc import Collection

import numpy as np

from driftform_networks.routing import Routing, RoutingTable, TransferTable
from driftform_networks.snapshot import Snapshot

_STRAIGHT = TransferTable(np.ones((1, 1)), np.ones(1))
_BLOCKED = TransferTable(np.zeros((1, 1)), np.ones(1), "a pump or valve that lets no body pass")


def route_tracers(snapshot: Snapshot, retained: bool = False, blocked: Collection[int] = ()) -> Routing:
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
