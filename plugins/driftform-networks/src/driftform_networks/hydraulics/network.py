"""A water network, the flows that EPANET computes for it, and its flow at one moment, directed downstream."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from driftform.errors import InputError, did_you_mean
from driftform.types import FloatArray

IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

TOLERANCE, MAX_OFF = 0.1, 0.2
"""Largest deviation of drawn from given length at which a link is to scale, and largest share of the length that is not."""

MAX_KNOWN = 12
"""Nodes of a network up to which an error names all."""


@dataclass(frozen=True, eq=False)
class Hydraulics:
    """What EPANET computes; a row holds from its time until the next one.

    Attributes:
        times: start of each hydraulic step, s, (steps,), from 0.
        end: end of the last step, s; equal to its start in a network without a duration.
        flow: volume flow of each link, m3/s, positive from its start to its end, (steps, links).
        outflow: water that leaves the pipes at each node, m3/s, (steps, nodes): demand of a junction, or what a tank or
            a reservoir takes in; negative where water comes in.
        head: hydraulic head of each node, m, (steps, nodes).
        warnings: what EPANET warned of, one line each.
        clock: time of the day at which the simulation begins, s.
    """

    times: FloatArray
    end: float
    flow: FloatArray
    outflow: FloatArray
    head: FloatArray
    warnings: tuple[str, ...] = ()
    clock: float = 0.0

    def find_step(self, hour: float) -> int:
        """Return the index of the step that covers an hour of the simulation.

        Raises InputError if the simulation does not cover it.
        """
        if not 0 <= hour * 3600 <= self.end:
            raise InputError(f"--at {hour:g}: the simulation lasts from hour 0 to hour {self.end / 3600:g}")
        return int(np.searchsorted(self.times, hour * 3600 + 1e-6, side="right")) - 1

    def format_clock(self, hour: float, age: float) -> str:
        """Return the time of day ``age`` seconds after an hour of the simulation, with the days since its begin."""
        if not np.isfinite(age):
            return "-"
        minutes = round((self.clock + 3600 * hour + age) / 60)
        days = f"{minutes // 1440} d " if minutes >= 1440 else ""
        return f"{days}{minutes // 60 % 24:02d}:{minutes % 60:02d}"


@dataclass(frozen=True, eq=False)
class Network:
    """A water network with its flows.

    Attributes:
        name: name of its file, without suffix.
        digest: SHA-256 of its file.
        nodes, links: names of nodes and links.
        node_kinds: ``"junction"``, ``"tank"`` or ``"reservoir"``.
        link_kinds: ``"pipe"``, ``"cv"`` (a pipe with a check valve), ``"pump"``, or the valves of EPANET from ``"prv"``
            to ``"pcv"``.
        elevation: elevation of each node, m, (nodes,).
        places: coordinates of each node on the map of the file, in the file's unit, (nodes, 2); NaN where the file has
            none.
        vertices: points of each link between its ends, on the same map, (k, 2) each.
        start, end: index of the nodes at the ends of each link, (links,).
        length: length of each link, m, (links,); 0 for pumps and valves.
        diameter: inner diameter of each link, m, (links,); 0 for pumps.
        weight: how much each metre of a link counts, (links,); ``None`` for all alike.
    """

    name: str
    digest: str
    nodes: tuple[str, ...]
    node_kinds: tuple[str, ...]
    elevation: FloatArray
    places: FloatArray
    links: tuple[str, ...]
    link_kinds: tuple[str, ...]
    start: IntArray
    end: IntArray
    length: FloatArray
    diameter: FloatArray
    vertices: tuple[FloatArray, ...] = field(repr=False)
    hydraulics: Hydraulics = field(repr=False)
    weight: FloatArray | None = None

    def find_node(self, name: str, option: str = "--release") -> int:
        """Return the index of a node that an option names. Raises InputError if no node has the name."""
        if name not in self.nodes:
            hint = did_you_mean(name, self.nodes)
            if hint.startswith("; known") and len(self.nodes) > MAX_KNOWN:
                hint = f"; it has {len(self.nodes)}, such as {', '.join(self.nodes[:3])}"
            raise InputError(f"{option} {name}: {self.name} has no such node{hint}")
        return self.nodes.index(name)

    @cached_property
    def is_pipe(self) -> BoolArray:
        """Whether each link is a pipe, with a check valve or without, (links,)."""
        return np.isin(self.link_kinds, ("pipe", "cv"))

    @cached_property
    def stores(self) -> BoolArray:
        """Whether each node is a tank or a reservoir: what arrives there has left the pipes, (nodes,)."""
        return np.array([kind != "junction" for kind in self.node_kinds])

    def find_low_pressures(self, step: int) -> tuple[IntArray, FloatArray]:
        """Return the junctions that deliver water at negative pressure, the lowest first, and their pressures, m."""
        pressure = self.hydraulics.head[step] - self.elevation
        delivers = ~self.stores & (self.hydraulics.outflow[step] > 0)
        rows = np.flatnonzero(delivers & ~(pressure > -1e-3))
        rows = rows[np.argsort(pressure[rows], kind="stable")]
        return rows, pressure[rows]

    @property
    def worth(self) -> FloatArray:
        """Length of each link times its weight, m, (links,)."""
        return self.length if self.weight is None else self.length * self.weight

    @property
    def area(self) -> FloatArray:
        """Cross-section of each link, m2, (links,)."""
        return np.asarray(np.pi / 4 * self.diameter**2)

    @cached_property
    def scale(self) -> float | None:
        """Metres for each unit of the map if it is drawn to scale, else ``None``.

        The scale is the median, by length, of given over drawn lengths; the map is to scale if at least 80 % of the length
        deviates from it by at most 10 %.
        """
        if not np.isfinite(self.places).all():
            return None
        lines = (self.polyline(link) for link in range(len(self.links)))
        drawn = np.array([np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in lines])
        pipes = (drawn > 0) & (self.length > 0)
        if not pipes.any():
            return None
        ratio, length = self.length[pipes] / drawn[pipes], self.length[pipes]
        order = np.argsort(ratio)
        middle = np.searchsorted(np.cumsum(length[order]), length.sum() / 2)
        scale = float(ratio[order][min(middle, len(order) - 1)])
        off = length[np.abs(ratio / scale - 1) > TOLERANCE].sum() / length.sum()
        return scale if off <= MAX_OFF else None

    def polyline(self, link: int) -> FloatArray:
        """Return the points of a link on the map, from its start to its end, (k, 2)."""
        ends = self.places[[self.start[link], self.end[link]]]
        return np.vstack([ends[:1], self.vertices[link].reshape(-1, 2), ends[1:]])

    def tabulate_links(self, kept: BoolArray, **values: FloatArray) -> dict[str, list[Any]]:
        """Return names, lengths and further values of some links as columns; ``kept`` and each value are (links,)."""
        rows = np.flatnonzero(kept)
        columns: dict[str, list[Any]] = {
            "link": [self.links[row] for row in rows],
            "length_m": self.length[rows].tolist(),
        }
        return columns | {name: value[rows].tolist() for name, value in values.items()}

    @cached_property
    def courses(self) -> list[FloatArray]:
        """Unit vectors on the map along the parts of each link, from its start to its end, (parts, 2) each."""
        steps = [np.diff(self.polyline(link), axis=0) for link in range(len(self.links))]
        lengths = [np.linalg.norm(step, axis=1) for step in steps]
        return [step[long > 0] / long[long > 0, None] for step, long in zip(steps, lengths, strict=True)]


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
