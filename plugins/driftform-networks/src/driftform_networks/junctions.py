"""What a body meets at the end of a link: bores, shares of the flow, and the sides where the outlets leave.

An EPANET file has the bores. The angles are those of the map if it is drawn to scale. Where a branch leaves the pipe (at
the top, a side, or the bottom) is in no such file: it is an input.
"""

from dataclasses import dataclass

import numpy as np

from driftform.types import FloatArray
from driftform_networks.network import Network
from driftform_networks.scale import is_to_scale
from driftform_networks.snapshot import Snapshot

SIDES = {"top": 0.0, "side": 90.0, "bottom": 180.0}
"""Sides where branches leave, as on a clock seen downstream, degrees."""

AHEAD_DEG = 45.0
"""Turn up to which an outlet of a map to scale counts as straight ahead, degrees."""

BRANCH_DEG = 90.0
"""Turn into a branch where the map is not to scale, degrees."""


@dataclass(frozen=True, eq=False)
class Junction:
    """The downstream end of a link.

    Attributes
    ----------
    bore
        diameter of the link, m; 0 for a pump.
    bores
        diameter of each outlet, m, (outlets,).
    shares
        share of each outlet in the water that leaves the node through links, (outlets,).
    exit
        share of the demand in all water that leaves the node.
    directions
        side where each outlet leaves: unit vectors to the right and upward as seen downstream; zero for straight ahead,
        (outlets, 2).
    turns
        angle between the link and each outlet, rad, (outlets,).
    stores
        whether the node is a tank or a reservoir.
    inlets
        number of links whose water comes in.
    """

    bore: float
    bores: FloatArray
    shares: FloatArray
    exit: float
    directions: FloatArray
    turns: FloatArray
    stores: bool
    inlets: int


class Geometry:
    """The junctions of a network.

    Parameters
    ----------
    network
        the network.
    branch
        where branches leave: ``"top"``, ``"side"`` or ``"bottom"``. At the side, the map says on which; a map that is
        not to scale leaves it open, and branches leave on the right, then on the left.
    """

    def __init__(self, network: Network, branch: str) -> None:
        self.network, self._branch = network, branch
        self.to_scale = is_to_scale(network) is not None
        self._known: dict[tuple[Snapshot, int], Junction] = {}
        self._courses = [self._list_courses(link) for link in range(len(network.links))]

    def _list_courses(self, link: int) -> FloatArray:
        """Return the unit vectors on the map along the parts of a link, from its start to its end, (parts, 2)."""
        steps = np.diff(self.network.polyline(link), axis=0)
        steps = steps[np.linalg.norm(steps, axis=1) > 0]
        return np.asarray(steps / np.linalg.norm(steps, axis=1)[:, None])

    def find_bends(self, link: int) -> FloatArray:
        """Return the angles by which a link turns at its vertices, rad; none if the map is not to scale."""
        course = self._courses[link] if self.to_scale else np.zeros((0, 2))
        return np.asarray(np.arccos(np.clip((course[:-1] * course[1:]).sum(axis=1), -1, 1)))

    def describe(self, snapshot: Snapshot, link: int) -> Junction:
        """Return what a body meets at the downstream end of a link of a snapshot."""
        if (snapshot, link) not in self._known:
            self._known[snapshot, link] = self._describe(snapshot, link)
        return self._known[snapshot, link]

    def _describe(self, snapshot: Snapshot, link: int) -> Junction:
        network, node = self.network, int(snapshot.head[link])
        outlets = snapshot.outlets[node]
        flow = snapshot.flow[outlets]
        bores = network.diameter[snapshot.links[outlets]]
        turns, sides = self._turn(snapshot, link)
        directions = np.zeros((len(outlets), 2))
        for outlet, side in enumerate(sides):
            if side:
                clock = np.deg2rad(SIDES[self._branch])
                directions[outlet] = (side * np.sin(clock), np.cos(clock))
        return Junction(
            float(network.diameter[snapshot.links[link]]),
            bores,
            flow / flow.sum() if len(flow) else flow,
            float(snapshot.exit[node] / snapshot.departure[node]) if snapshot.departure[node] > 0 else 1.0,
            directions,
            turns,
            bool(snapshot.stores[node]),
            int((snapshot.head == node).sum()),
        )

    def _turn(self, snapshot: Snapshot, link: int) -> tuple[FloatArray, list[int]]:
        """Return the turn into each outlet, and the side where it leaves: 1 right, -1 left, 0 straight ahead."""
        outlets = snapshot.outlets[snapshot.head[link]]
        if len(outlets) == 0:
            return np.zeros(0), []
        turns = np.zeros(len(outlets))
        if self.to_scale:
            along = self._direction(snapshot, link, at_end=True)
            away = np.array([self._direction(snapshot, outlet, at_end=False) for outlet in outlets])
            turns = np.arccos(np.clip(away @ along, -1, 1))
            # On the map, the right is clockwise.
            sides = np.where(along[0] * away[:, 1] - along[1] * away[:, 0] > 0, -1, 1)
            straightest = int(np.argmin(turns))
            ahead = straightest if len(outlets) == 1 or turns[straightest] <= np.deg2rad(AHEAD_DEG) else -1
        else:
            network = snapshot.network
            bores = network.diameter[snapshot.links[outlets]]
            # The run goes on in the widest outlet; of equal ones, in that with most water.
            ahead = int(np.lexsort((snapshot.flow[outlets], bores))[-1])
            turns[:] = np.deg2rad(BRANCH_DEG)
            turns[ahead] = 0.0
            sides = np.array([1 if number % 2 == 0 else -1 for number in range(len(outlets))])
            # Right and left alternate among the branches.
            sides[ahead + 1 :] *= -1
        if ahead >= 0:
            sides[ahead] = 0
        return turns, sides.tolist()

    def _direction(self, snapshot: Snapshot, link: int, at_end: bool) -> FloatArray:
        """Return the unit vector on the map along the flow of a link, at its downstream or its upstream end."""
        index = snapshot.links[link]
        forward, course = snapshot.tail[link] == self.network.start[index], self._courses[index]
        if not len(course):
            return np.zeros(2)
        part = course[-1] if forward == at_end else course[0]
        return np.asarray(part if forward else -part)
