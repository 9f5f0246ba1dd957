"""Networks in notebooks and scripts: what the commands call."""

from dataclasses import replace
from typing import Any

from driftform.util import progress
from driftform_networks.bodies import Traveller, open_traveller
from driftform_networks.chain import follow
from driftform_networks.following import How, find_cases
from driftform_networks.junctions import SIDES
from driftform_networks.network import Network
from driftform_networks.passage import Passage
from driftform_networks.tracers import route_tracers


def trace(network: Network, release: str, *, hour: float = 0.0, **how: Any) -> Passage:
    """Return where point tracers go that are released at a node: they divide like the water.

    Args:
        network: from :func:`driftform_networks.open_network`.
        release: name of the node.
        hour: hour of the simulation at the release.
        how: attributes of :class:`driftform_networks.following.How`.

    Raises:
        InputError: if there is no such node or hour, or no water leaves the node.
    """
    [case] = find_cases(network, [release], [hour], How(**how))
    return case.follow(route_tracers)


def route(
    network: Network, agent: Traveller | str, release: str, *, hour: float = 0.0, compare: bool = False, **how: Any
) -> Passage:
    """Return where an agent goes that is released at a node, by flights in the bores of the network.

    Args:
        network, release, hour, how: as for :func:`trace`.
        agent: body from :func:`driftform_networks.bodies.open_traveller`, or its name.
        compare: whether the result also has the passages with branches at each side of the pipes; not where flows
            change.

    Raises:
        InputError: if there is no such agent, node or hour, or no water leaves the node.
        WorkFailedError: if the agent cannot be flown.
    """
    [case] = find_cases(network, [release], [hour], How(**how))
    traveller = open_traveller(agent) if isinstance(agent, str) else agent
    travel, sides = case.how.travel, SIDES if compare and not case.how.unsteady else ()
    travels = [travel, *(replace(travel, branch=side) for side in sides)]
    first, *others = case.how.fly([traveller], travels, case.snapshots)
    passage = case.follow(first.route)
    shown = progress.track_progress(others, len(others), "sides where branches leave", 1.0)
    compared = (follow(other.route(case.snapshots[0]), passage.release) for other in shown)
    return replace(passage, branches=dict(zip(sides, compared, strict=True)))
