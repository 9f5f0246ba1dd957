"""A water network, the flows that EPANET computes for it, and its flow at one moment, directed downstream."""

from collections.abc import Iterable, Sequence
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

SERVICE_BORE, OFFTAKE_SPEED = 0.02, 1.0
"""Least bore of the pipes through which demand leaves, m: that of a house; and the speed of the peak demand in them, m/s: the middle
of the 0.5 to 2 m/s that EN 805, 8.3.2, recommends."""

MIN_BORE, MAX_BORE, MAX_SPEED = 0.02, 4.0, 10.0
"""Bores of pipes, m, and speeds in them, m/s, beyond which a file hardly means what it says."""

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
        service_bore: bore of the pipes through which demand leaves all nodes, m; ``None`` for :attr:`offtakes`.
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
    service_bore: float | None = None

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
    def slopes(self) -> FloatArray:
        """Rise over length of each link, from its start to its end; 0 at tanks and reservoirs, and without a length, (links,)."""
        rise = self.elevation[self.end] - self.elevation[self.start]
        known = (self.length > 0) & ~self.stores[self.start] & ~self.stores[self.end]
        return np.where(known, rise, 0.0) / np.where(known, self.length, 1.0)

    @cached_property
    def stores(self) -> BoolArray:
        """Whether each node is a tank or a reservoir: what arrives there has left the pipes, (nodes,)."""
        return np.array([kind != "junction" for kind in self.node_kinds])

    def find_speeds(self, steps: Iterable[int]) -> FloatArray:
        """Return the mean speeds of the water in the pipes in some steps, m/s, 0 in other links, (steps, links)."""
        return np.asarray(np.abs(self.hydraulics.flow[list(steps)]) / np.where(self.is_pipe, self.area, np.inf))

    def find_pressures(self, steps: Sequence[int]) -> FloatArray:
        """Return the pressures of junctions that deliver water in some steps, m, infinite elsewhere, (steps, nodes)."""
        delivers = ~self.stores & (self.hydraulics.outflow[steps] > 0)
        return np.where(delivers, self.hydraulics.head[steps] - self.elevation, np.inf)

    @cached_property
    def offtakes(self) -> FloatArray:
        """Bore of what lies behind each node, m, (nodes,): as given, or a pipe for its peak demand at :data:`OFFTAKE_SPEED`."""
        if self.service_bore is not None:
            return np.full(len(self.nodes), self.service_bore)
        return np.maximum(SERVICE_BORE, np.sqrt(4 / np.pi * self.peak_demand / OFFTAKE_SPEED))

    @cached_property
    def peak_demand(self) -> FloatArray:
        """Greatest demand of each node, m3/s, (nodes,)."""
        return np.asarray(self.hydraulics.outflow.max(axis=0, initial=0.0))

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
        """Return names, sizes, values and places of some links as columns; ``kept`` and each value are (links,)."""
        rows = np.flatnonzero(kept).tolist()
        corners = ([f"{x:.12g} {y:.12g}" for x, y in self.polyline(row)] for row in rows)
        columns: dict[str, list[Any]] = {
            "link": [self.links[row] for row in rows],
            "kind": [self.link_kinds[row] for row in rows],
            "start": [self.nodes[self.start[row]] for row in rows],
            "end": [self.nodes[self.end[row]] for row in rows],
            "length_m": self.length[rows].tolist(),
            "diameter_m": self.diameter[rows].tolist(),
            **{name: value[rows].tolist() for name, value in values.items()},
        }
        return columns | {"wkt": [f"LINESTRING ({', '.join(line)})" for line in corners]}

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
    def speed(self) -> FloatArray:
        """Mean speed of the water in each link, m/s, (n,); infinite in pumps, which have no volume."""
        with np.errstate(divide="ignore"):
            return np.asarray(self.flow / self.network.area[self.links])

    @cached_property
    def duration(self) -> FloatArray:
        """Time that water takes through each link, s, (n,)."""
        return np.asarray(self.network.length[self.links] / self.speed)

    @cached_property
    def departure(self) -> FloatArray:
        """Water that leaves each node, through links or with the demand, m3/s, (nodes,)."""
        through = np.bincount(self.tail, self.flow, len(self.network.nodes))
        return np.asarray(through + self.exit)

    @cached_property
    def inlets(self) -> IntArray:
        """Number of links whose water comes into each node, (nodes,)."""
        return np.bincount(self.head, minlength=len(self.network.nodes))


def take_snapshot(network: Network, hour: float = 0.0, absurd: bool = False) -> Snapshot:
    """Return the flow of a network at an hour of the simulation, with ``absurd`` also where no network has such pressures.

    Raises InputError if the simulation does not cover the hour, EPANET finds pressures below :data:`MAX_SUCTION` then, or
    the median bore is not that of a pipe.
    """
    hydraulics, bores = network.hydraulics, network.diameter[network.is_pipe]
    step = hydraulics.find_step(hour)
    if len(bores) and not MIN_BORE <= (bore := float(np.median(bores))) <= MAX_BORE and not absurd:
        raise InputError(
            f"{network.name}: [PIPES]: the median bore is {1000 * bore:.3g} mm: EPANET files have bores in millimetres, or inches "
            "with Units of GPM and the like: correct Units in [OPTIONS], or the diameters"
        )
    pressure = network.find_pressures([step])[0]
    lowest = int(pressure.argmin())
    if not pressure[lowest] > -MAX_SUCTION and not absurd:
        raise InputError(
            f"{network.name}: EPANET finds a pressure of {pressure[lowest]:.3g} m at {network.nodes[lowest]} at hour {hour:g}: no "
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


def warn_of_model(network: Network, steps: Sequence[int]) -> list[str]:
    """Return warnings: those of EPANET, and of absurd bores, speeds and pressures in some hydraulic steps, with the worst of them."""
    rows, is_pipe, bores = list(steps), network.is_pipe, network.diameter
    speeds, pressures = network.find_speeds(rows).max(axis=0), network.find_pressures(rows)
    hour = network.hydraulics.times[rows[int(pressures.min(axis=1).argmin())]] / 3600
    negative = (
        f"EPANET finds a negative pressure at {{}} junctions that deliver water, the lowest at hour {hour:g}: {{}}: there its flows "
        "are not those of a real network"
    )
    wrong_bore, check = is_pipe & ((bores < MIN_BORE) | (bores > MAX_BORE)), "check units and diameters of the file"
    checks = (
        (f"{{}} bores are not from 20 mm to 4 m: {{}}: {check}", network.links, wrong_bore, 1000 * bores, "mm"),
        (f"{{}} pipes are faster than 10 m/s: {{}}: {check}", network.links, speeds > MAX_SPEED, speeds, "m/s"),
        (negative, network.nodes, pressures.min(axis=0) < -1e-3, pressures.min(axis=0), "m"),
    )
    lines = [f"warning: EPANET: {line}" for line in network.hydraulics.warnings]
    for words, names, is_wrong, values, unit in checks:
        if len(found := np.flatnonzero(is_wrong)):
            worst = found[np.argsort(-np.abs(values[found]), kind="stable")][:5]
            listed = ", ".join(f"{names[row]} {values[row]:.3g} {unit}" for row in worst)
            lines.append(f"warning: {words.format(len(found), listed)}")
    return lines


def divide_flow(snapshot: Snapshot, node: int, retained: BoolArray | bool = False) -> FloatArray:
    """Return the probability that water at a node flows into each link of the snapshot, (links,).

    Bodies that are ``retained``, at all nodes or (nodes,), do not leave with the demand.

    Raises InputError if it flows into none.
    """
    outlets, network = snapshot.outlets[node], snapshot.network
    if not len(outlets):
        raise InputError(
            f"--release {network.nodes[node]}: no water flows from it into a pipe at hour {snapshot.hour:g}: "
            "choose a node upstream, or another hour"
        )
    first = np.zeros(len(snapshot.links))
    whole = (snapshot.departure - snapshot.exit * retained)[node]
    first[outlets] = snapshot.flow[outlets] / whole
    return first
