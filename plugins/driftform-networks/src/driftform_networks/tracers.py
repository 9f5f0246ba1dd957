"""Point tracers: they divide at each node like the water, and leave the pipes with the demand."""

import numpy as np

from driftform_networks.routing import Routing, RoutingTable, TransferTable
from driftform_networks.snapshot import Snapshot

_STRAIGHT = TransferTable(np.ones((1, 1)), np.ones(1))


def route_tracers(snapshot: Snapshot, retained: bool = False) -> Routing:
    """Return the tables of point tracers: water mixes completely at each node, as EPANET assumes.

    Tracers that are ``retained`` do not leave with the demand of a node from which water flows on; at a dead end they do.
    """
    departure = snapshot.departure - snapshot.exit * retained
    tables = []
    for node in snapshot.head.tolist():
        outlets = snapshot.outlets[node]
        choice = np.zeros((1, len(outlets)))
        if len(outlets) and not snapshot.stores[node]:
            choice[0] = snapshot.flow[outlets] / departure[node]
        tables.append(RoutingTable(choice, np.ones((1, len(outlets), 1)), 1 - choice.sum(axis=1)))
    return Routing(snapshot, [_STRAIGHT] * len(tables), tables, np.ones(1), retained)
