"""What a body meets at the end of a link (bores, shares of the flow, and sides of the outlets), and where it goes there.

An EPANET file has the bores. The angles are those of the map if it is drawn to scale. Where a branch leaves the pipe (at
the top, a side, or the bottom) is in no such file: it is an input.
"""

from dataclasses import dataclass

import numpy as np

from driftform.types import FloatArray
from driftform_networks.flights.bodies import Traveller
from driftform_networks.flights.bore import BANDS, MIXED, divide_bore, divide_mixed
from driftform_networks.flights.fits import find_obstacle
from driftform_networks.hydraulics.network import IntArray, Network, Snapshot
from driftform_networks.passages.routing import JOINT, TEE, RoutingTable

SIDES = {"top": 0.0, "side": 90.0, "bottom": 180.0}
"""Sides where branches leave, as on a clock seen downstream, degrees."""

AHEAD_DEG = 45.0
"""Turn up to which an outlet of a map to scale counts as straight ahead, degrees."""

BRANCH_DEG = 90.0
"""Turn into a branch where the map is not to scale, degrees."""

_HELD = {TEE: "held in a tee: where the flow divides", JOINT: "held in a bend or reducer"}


@dataclass(frozen=True, eq=False)
class Junction:
    """The downstream end of a link.

    Attributes:
        bore: diameter of the link, m; 0 for a pump.
        bores: diameter of each outlet, m, (outlets,).
        shares: share of each outlet in the water that leaves the node through links, (outlets,).
        exit: share of the demand in all water that leaves the node.
        directions: side where each outlet leaves: unit vectors to the right and upward as seen downstream; zero for
            straight ahead, (outlets, 2). A single outlet leaves in the plane of the map.
        turns: angle between the link and each outlet, rad, (outlets,).
        stores: whether the node is a tank or a reservoir.
        inlets: number of links whose water comes in.
        offtake: bore of the pipe through which the demand leaves, m.
    """

    bore: float
    bores: FloatArray
    shares: FloatArray
    exit: float
    directions: FloatArray
    turns: FloatArray
    stores: bool
    inlets: int
    offtake: float


def find_bends(network: Network, link: int) -> tuple[FloatArray, FloatArray]:
    """Return how a link turns at its vertices, from its start on, and where; nothing if the map is not to scale.

    Returns:
        turns, places: angles, rad, positive to the right; and the share of the length before each, (bends,) each.
    """
    if network.scale is None or not len(network.vertices[link]):
        return np.zeros(0), np.zeros(0)
    steps = np.diff(network.polyline(link), axis=0)
    length = np.linalg.norm(steps, axis=1)
    (x, z), (u, v) = network.courses[link][:-1].T, network.courses[link][1:].T
    return np.arctan2(z * u - x * v, x * u + z * v), np.cumsum(length[length > 0])[:-1] / length.sum()


def describe_junction(snapshot: Snapshot, link: int, branch: str) -> Junction:
    """Return what a body meets at the downstream end of a link of a snapshot.

    Branches leave at the ``"top"``, ``"side"`` or ``"bottom"``. At the side, the map says on which; a map that is not to
    scale leaves it open, and branches leave on the right, then on the left.
    """
    network, node = snapshot.network, int(snapshot.head[link])
    outlets, clock = snapshot.outlets[node], np.deg2rad(SIDES[branch])
    flow, bores = snapshot.flow[outlets], network.diameter[snapshot.links[outlets]]
    if len(outlets) == 0:
        turns, sides = np.zeros(0), np.zeros(0)
    elif network.scale is None:
        # The run continues in the widest outlet, of equal ones in that with most water; branches leave right and left in turn.
        ahead = int(np.lexsort((flow, bores))[-1])
        sides = np.insert((-1.0) ** np.arange(len(bores) - 1), ahead, 0.0)
        turns = np.abs(sides) * np.deg2rad(BRANCH_DEG)
    else:
        turns, sides = _read_turns(snapshot, link, outlets)
    if len(outlets) == 1:
        clock = np.pi / 2
    return Junction(
        float(network.diameter[snapshot.links[link]]),
        bores,
        flow / flow.sum() if len(flow) else flow,
        float(snapshot.exit[node] / snapshot.departure[node]) if snapshot.departure[node] > 0 else 1.0,
        np.column_stack([sides * np.sin(clock), np.abs(sides) * np.cos(clock)]),
        turns,
        bool(network.stores[node]),
        int(snapshot.inlets[node]),
        float(network.offtakes[node]),
    )


def _read_turns(snapshot: Snapshot, link: int, outlets: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return the turn into each outlet on the map, and the side where it leaves: 1 right, -1 left, 0 straight ahead."""
    along = _direction(snapshot, link, at_end=True)
    away = np.array([_direction(snapshot, outlet, at_end=False) for outlet in outlets.tolist()])
    turns = np.arccos(np.clip(away @ along, -1, 1))
    # On the map, the right is clockwise.
    sides = np.where(along[0] * away[:, 1] - along[1] * away[:, 0] > 0, -1.0, 1.0)
    straightest = int(np.argmin(turns))
    if len(outlets) > 1 and turns[straightest] <= np.deg2rad(AHEAD_DEG):
        sides[straightest] = 0
    return turns, sides


def _direction(snapshot: Snapshot, link: int, at_end: bool) -> FloatArray:
    """Return the unit vector on the map along the flow of a link, at its downstream or its upstream end."""
    network, index = snapshot.network, int(snapshot.links[link])
    forward, course = snapshot.tail[link] == network.start[index], network.courses[index]
    if not len(course):
        return np.zeros(2)
    part = course[-1] if forward == at_end else course[0]
    return np.asarray(part if forward else -part)


def divide_bodies(
    traveller: Traveller,
    junction: Junction,
    points: FloatArray | None,
    onward: FloatArray | None = None,
    passing: str = "",
) -> RoutingTable:
    """Return where a body goes at a junction, by flights or by the streamtubes of its bore.

    Args:
        points: band and place of bodies at the end of the link, (n, 3); ``None`` for a body that is anywhere in the
            bore.
        onward: probability of each outlet and of the band in it by flights, for each band, (bands, outlets, bands);
            ``None`` for streamtubes.
        passing: of the table.
    """
    outlets = len(junction.bores)
    nothing = np.zeros((BANDS, outlets))
    band = MIXED if points is None else np.eye(BANDS)[:, None, :]
    arrival = np.broadcast_to(band, (BANDS, outlets, BANDS))
    if junction.stores:
        return RoutingTable(nothing, arrival, np.ones(BANDS))
    leaves = junction.exit if traveller.width < junction.offtake else 0.0
    if not outlets:
        obstacle = f"at a dead end: too wide for the {1000 * junction.offtake:.0f} mm that its demand takes"
        return RoutingTable(nothing, arrival, np.full(BANDS, 1.0 if leaves else 0.0), obstacle)
    obstacles = [
        find_obstacle(traveller.agent.body, junction.bore, float(bore), turn)
        for bore, turn in zip(junction.bores, junction.turns, strict=True)
    ]
    passes = np.array([not obstacle for obstacle in obstacles])
    obstacle = next(filter(None, obstacles), "")
    if onward is None:
        share = _choose(traveller, junction, points)
    else:
        share, obstacle = onward.sum(axis=2), obstacle or _HELD.get(passing, "")
        arrival = np.where(share[:, :, None] > 0, onward / np.maximum(share, 1e-300)[:, :, None], arrival)
    return RoutingTable(share * (1 - leaves) * passes, arrival, np.full(BANDS, leaves), obstacle, passing)


def _choose(traveller: Traveller, junction: Junction, points: FloatArray | None) -> FloatArray:
    """Return the share of the bodies in each band that the streamtubes carry into each outlet, (bands, outlets)."""
    outlets = len(junction.bores)
    if outlets == 1:
        return np.ones((BANDS, 1))
    bore = junction.bore or float(junction.bores.max())
    room = max(1 - traveller.width / bore, 1e-3)
    mixed = divide_mixed(junction.directions, junction.shares, room)
    if points is None or not len(points):
        return np.tile(mixed, (BANDS, 1))
    bands = points[:, 0].astype(np.int64)
    counts = np.zeros((BANDS, outlets))
    np.add.at(counts, bands, divide_bore(points[:, 1:], junction.directions, junction.shares))
    total = counts.sum(axis=1, keepdims=True)
    # In a band where no flight ended, a body is anywhere.
    return np.asarray(np.where(total > 0, counts / np.maximum(total, 1e-300), mixed))
