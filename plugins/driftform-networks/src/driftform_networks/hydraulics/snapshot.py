"""The flow of a network at one moment, as links that are directed downstream."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from driftform.errors import InputError
from driftform.types import FloatArray
from driftform_networks.hydraulics.network import IntArray, Network

STILL = 1.114e-5 * 0.3048**3
"""Flow below which the water of a link does not move, m3/s: EPANET's Q_STAGNANT of 1.114e-5 ft3/s (its types.h)."""

MAX_SUCTION = 1e4
"""Pressure below that of the air, m, from which on a solution is meaningless: so EPANET shows that water is lacking."""


@dataclass(frozen=True, eq=False)
class Snapshot:
    """The links of a network in which water flows at one moment, each directed downstream.

    Attributes:
        step: index of the hydraulic step.
        links: index of each of these links in the network, (n,).
        tail, head: nodes at the upstream and the downstream end of each link, (n,).
        flow: volume flow, m3/s, positive, (n,).
        exit: demand at each junction, m3/s, at least 0, (nodes,).
    """

    network: Network
    hour: float
    step: int
    links: IntArray
    tail: IntArray
    head: IntArray
    flow: FloatArray
    exit: FloatArray
    outlets: tuple[IntArray, ...] = field(repr=False, default=())
    """For each node, the links of this snapshot that lead away from it."""

    @cached_property
    def length(self) -> FloatArray:
        """Length of each link, m, (n,)."""
        return np.asarray(self.network.length[self.links])

    @cached_property
    def speed(self) -> FloatArray:
        """Mean speed of the water in each link, m/s, (n,); infinite in pumps, which have no volume."""
        with np.errstate(divide="ignore"):
            return np.asarray(self.flow / self.network.area[self.links])

    @cached_property
    def duration(self) -> FloatArray:
        """Time that water takes through each link, s, (n,)."""
        return np.asarray(self.length / self.speed)

    @cached_property
    def departure(self) -> FloatArray:
        """Water that leaves each node, through links or with the demand, m3/s, (nodes,)."""
        through = np.bincount(self.tail, self.flow, len(self.network.nodes))
        return np.asarray(through + self.exit)

    @cached_property
    def inlets(self) -> IntArray:
        """Number of links whose water comes into each node, (nodes,)."""
        return np.bincount(self.head, minlength=len(self.network.nodes))

    def name(self, link: int) -> str:
        """Return the name of a link of this snapshot."""
        return str(self.network.links[int(self.links[link])])


def take_snapshot(network: Network, hour: float = 0.0, absurd: bool = False) -> Snapshot:
    """Return the flow of a network at an hour of the simulation, with ``absurd`` also where no network has such pressures.

    Raises InputError if the simulation does not cover the hour, or EPANET finds pressures below :data:`MAX_SUCTION`
    then.
    """
    hydraulics = network.hydraulics
    step = hydraulics.find_step(hour)
    low, pressure = network.find_low_pressures(step)
    if len(low) and not pressure[0] > -MAX_SUCTION and not absurd:
        raise InputError(
            f"{network.name}: EPANET finds a pressure of {pressure[0]:.3g} m at {network.nodes[low[0]]} at hour {hour:g}: no "
            "source can supply what the file demands; correct its demands, pumps or open links, or choose another hour"
        )
    flow = hydraulics.flow[step]
    links = np.flatnonzero(np.abs(flow) > STILL)
    forward = flow[links] > 0
    tail = np.where(forward, network.start[links], network.end[links])
    head = np.where(forward, network.end[links], network.start[links])
    exit = np.where(network.stores, 0.0, np.maximum(hydraulics.outflow[step], 0.0))
    order = np.argsort(tail, kind="stable")
    outlets = np.split(order, np.searchsorted(tail[order], np.arange(1, len(network.nodes))))
    return Snapshot(network, hour, step, links, tail, head, np.abs(flow[links]), exit, tuple(outlets))


def warn_of_pressure(network: Network, steps: Sequence[int]) -> list[str]:
    """Return a warning for negative pressures in some hydraulic steps, with the lowest of them; none without."""
    found: dict[int, tuple[float, int]] = {}
    for step in steps:
        for node, value in zip(*network.find_low_pressures(step), strict=True):
            found[int(node)] = min(found.get(int(node), (np.inf, 0)), (float(value), step))
    if not found:
        return []
    lowest = sorted(found.items(), key=lambda item: item[1])[:5]
    values = ", ".join(f"{network.nodes[node]} {value:.3g} m" for node, (value, _) in lowest)
    hour = network.hydraulics.times[lowest[0][1][1]] / 3600
    return [
        f"warning: EPANET finds a negative pressure at {len(found)} junctions that deliver water, the lowest at hour {hour:g}: "
        f"{values}: there its flows are not those of a real network"
    ]


def divide_flow(snapshot: Snapshot, node: int, retained: bool = False) -> FloatArray:
    """Return the probability that water at a node flows into each link of the snapshot, (links,).

    Bodies that are ``retained`` do not leave with the demand of the node.

    Raises InputError if it flows into none.
    """
    outlets, network = snapshot.outlets[node], snapshot.network
    if not len(outlets):
        raise InputError(
            f"--release {network.nodes[node]}: no water flows from it into a pipe at hour {snapshot.hour:g}: "
            "choose a node upstream, or another hour"
        )
    first = np.zeros(len(snapshot.links))
    whole = snapshot.departure[node] - snapshot.exit[node] * retained
    first[outlets] = snapshot.flow[outlets] / whole
    return first
