"""The tables of a body in a network: made from flights, kept on disk, shared by all networks."""

from collections.abc import Callable, Iterable, Sequence
from contextlib import closing
from copy import copy
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from driftform.errors import InputError, did_you_mean
from driftform.types import FloatArray
from driftform_networks.bodies import SCENARIO, Traveller
from driftform_networks.bore import BANDS, spread_points
from driftform_networks.cache import find_cache, hash_content
from driftform_networks.fits import find_obstacle
from driftform_networks.junctions import SIDES, Geometry, Junction
from driftform_networks.routing import Routing, RoutingTable, TransferTable
from driftform_networks.snapshot import Snapshot
from driftform_networks.streamtubes import divide_bore

if TYPE_CHECKING:
    from driftform_networks.flights import StraightFlights, StraightTask

SPEED_STEP = 1.5
"""Flights are made at speeds that differ by this factor, and serve the speeds around them."""

SLOWEST = 0.005
"""Least speed of these flights, m/s: slower water carries a body at this pace relative to its own."""

SLOPES = (-0.5, -0.15, -0.05, 0.0, 0.05, 0.15, 0.5)
"""Slopes of these flights, rise over length; a pipe takes the nearest."""

SERVICE_BORE = 0.02
"""Default bore of the service pipes through which demand leaves, m: a narrower body leaves with it."""

MIXED = np.full(BANDS, 1 / BANDS)
"""Probability of each band of a body that is anywhere in the bore: the bands have the same area."""

Progress = Callable[[int, int], None]
"""Takes the number of tables that are made, and of all."""

_Key = tuple[float, float, float]
"""Bore, speed and slope of flights."""


@dataclass(frozen=True, eq=False)
class Travel:
    """How bodies travel, apart from the body.

    Attributes
    ----------
    branch
        side where branches leave the pipes: ``"top"``, ``"side"`` or ``"bottom"``.
    service_bore
        bore of service pipes, m.
    """

    branch: str = "side"
    service_bore: float = SERVICE_BORE

    @classmethod
    def parse(cls, branch: str, service_bore: float) -> "Travel":
        """Return what the options say.

        Raises
        ------
        InputError
            if there is no such side.
        """
        if branch not in SIDES:
            raise InputError(f"--branch {branch}: no such side{did_you_mean(branch, SIDES)}")
        return cls(branch, service_bore)


class Traveling:
    """Routes one body through the snapshots of a network.

    Parameters
    ----------
    traveller
        the body.
    geometry
        junctions of the network.
    travel
        side of the branches, and the like.
    cache
        directory for tables; ``None`` for the user's.
    """

    def __init__(self, traveller: Traveller, geometry: Geometry, travel: Travel, cache: Path | None) -> None:
        self._traveller, self._geometry, self._travel = traveller, geometry, travel
        self._retained = traveller.agent.body.max_diameter >= travel.service_bore
        self._folder = find_cache(cache)
        self._hash = traveller.hash()
        self._flights: dict[_Key, StraightFlights] = {}
        self._transfers: dict[tuple[object, ...], TransferTable] = {}
        self._bends: dict[int, str] = {}

    def with_branch(self, branch: str) -> "Traveling":
        """Return the same body where branches leave the pipes at another side; it shares the flights."""
        other = copy(self)
        other._geometry = Geometry(self._geometry.network, branch)
        other._travel = replace(self._travel, branch=branch)
        return other

    def list_tasks(self, snapshots: Iterable[Snapshot]) -> "list[StraightTask]":
        """Return the flights that these snapshots need and that were not read yet."""
        from driftform_networks.flights import StraightTask

        keys = {
            self._key(snapshot, link)
            for snapshot in snapshots
            for link in range(len(snapshot.links))
            if self._needs_flights(snapshot, link)
        }
        return [
            StraightTask(self._traveller, *key, self._path(key))
            for key in sorted(keys - self._flights.keys())
        ]

    def _path(self, key: _Key) -> Path:
        return self._folder / f"{hash_content({'body': self._hash, 'straight': key})}.npz"

    def read(self, tasks: "Sequence[StraightTask]", flights: "Sequence[StraightFlights]") -> None:
        """Take the results of tasks."""
        for task, found in zip(tasks, flights, strict=True):
            self._flights[task.bore, task.speed, task.slope] = found

    def route(self, snapshot: Snapshot) -> Routing:
        """Return the tables of the body in a snapshot; its flights must have been made."""
        transfers, tables = [], []
        for link in range(len(snapshot.links)):
            transfers.append(self._transfer(snapshot, link))
            tables.append(self._divide(snapshot, link))
        return Routing(snapshot, transfers, tables, MIXED, self._retained)

    def _needs_flights(self, snapshot: Snapshot, link: int) -> bool:
        network, index = snapshot.network, snapshot.links[link]
        is_pipe = network.link_kinds[index] == "pipe"
        fits = self._traveller.agent.body.max_diameter <= network.diameter[index]
        return bool(is_pipe and fits and not self._traveller.is_mixed(float(snapshot.speed[link])))

    def _key(self, snapshot: Snapshot, link: int) -> _Key:
        network, index = snapshot.network, snapshot.links[link]
        speed = max(float(snapshot.speed[link]), SLOWEST)
        rise = network.elevation[snapshot.head[link]] - network.elevation[snapshot.tail[link]]
        slope = rise / network.length[index] if network.node_kinds[snapshot.tail[link]] == "junction" else 0.0
        slope = 0.0 if network.node_kinds[snapshot.head[link]] != "junction" else slope
        nearest = min(SLOPES, key=lambda known: abs(known - slope))
        return (
            round(float(network.diameter[index]), 4),
            float(SPEED_STEP ** round(np.log(speed) / np.log(SPEED_STEP))),
            nearest,
        )

    def _transfer(self, snapshot: Snapshot, link: int) -> TransferTable:
        network, index = snapshot.network, int(snapshot.links[link])
        if network.link_kinds[index] != "pipe":
            return _MIXING
        if obstacle := self._find_bend(network.diameter[index], index):
            return TransferTable(np.zeros((BANDS, BANDS)), np.ones(BANDS), obstacle)
        if not self._needs_flights(snapshot, link):
            return _MIXING
        key = self._key(snapshot, link)
        cells = max(1, round(float(network.length[index]) / self._flights[key].cell))
        name = (key, cells)
        if name not in self._transfers:
            self._transfers[name] = _repeat(self._flights[key], cells, key)
        return self._transfers[name]

    def _find_bend(self, bore: float, index: int) -> str:
        """Return why the body cannot pass the bends of a link, empty if it can."""
        if index not in self._bends:
            turns = [0.0, *self._geometry.find_bends(index)]
            found = [find_obstacle(self._traveller.agent.body, bore, bore, turn) for turn in turns]
            self._bends[index] = next(filter(None, found), "")
        return self._bends[index]

    def _divide(self, snapshot: Snapshot, link: int) -> RoutingTable:
        junction = self._geometry.describe(snapshot, link)
        points = None
        if self._needs_flights(snapshot, link):
            points = self._flights[self._key(snapshot, link)].states[:, :3]
        return divide_bodies(self._traveller, junction, points, self._travel.service_bore)


_MIXING = TransferTable(np.tile(MIXED, (BANDS, 1)), np.ones(BANDS))


def _repeat(flights: "StraightFlights", cells: int, key: _Key) -> TransferTable:
    """Return the table of a run of so many cells."""
    power, spent = np.eye(BANDS), np.zeros(BANDS)
    # By doubling: transfer and time of 1, 2, 4, ... cells.
    transfer, slow, left = flights.transfer, flights.slowness.copy(), cells
    while left:
        if left % 2:
            spent, power = spent + power @ slow, power @ transfer
        slow, transfer, left = slow + transfer @ slow, transfer @ transfer, left // 2
    bore, speed, _ = key
    return TransferTable(
        power,
        np.maximum(spent / cells, 1e-3),
        f"rests on the wall of a {1000 * bore:.0f} mm bore at about {speed:.2g} m/s",
    )


def divide_bodies(
    traveller: Traveller, junction: Junction, points: FloatArray | None, service_bore: float
) -> RoutingTable:
    """Return where a body goes at a junction by the streamtubes of its bore.

    Parameters
    ----------
    points
        band and place of bodies at the end of the link, (n, 3); ``None`` for a body that is anywhere in the bore.
    service_bore
        bore of service pipes, m.
    """
    body, outlets = traveller.agent.body, len(junction.bores)
    nothing = np.zeros((BANDS, outlets))
    arrival = np.broadcast_to(MIXED, (BANDS, outlets, BANDS))
    if points is not None:
        arrival = np.broadcast_to(np.eye(BANDS)[:, None, :], (BANDS, outlets, BANDS))
    if junction.stores:
        return RoutingTable(nothing, arrival, np.ones(BANDS))
    leaves = junction.exit if body.max_diameter < service_bore else 0.0
    if not outlets:
        obstacle = f"a dead end: too wide for service pipes of {1000 * service_bore:.0f} mm"
        return RoutingTable(nothing, arrival, np.full(BANDS, 1.0 if leaves else 0.0), obstacle)
    obstacles = [
        find_obstacle(body, junction.bore, bore, turn)
        for bore, turn in zip(junction.bores, junction.turns, strict=True)
    ]
    passes = np.array([not obstacle for obstacle in obstacles])
    choice = _choose(traveller, junction, points) * (1 - leaves) * passes
    return RoutingTable(choice, arrival, np.full(BANDS, leaves), next(filter(None, obstacles), ""))


def _choose(traveller: Traveller, junction: Junction, points: FloatArray | None) -> FloatArray:
    """Return the share of the bodies in each band that the streamtubes carry into each outlet, (bands, outlets)."""
    outlets = len(junction.bores)
    if outlets == 1:
        return np.ones((BANDS, 1))
    bore = junction.bore or float(junction.bores.max())
    room = max(1 - traveller.agent.body.max_diameter / bore, 1e-3)
    # All water carries the body, also that within its radius of the wall: there its centre is as near as it can be.
    anywhere = spread_points(1.0)
    anywhere = anywhere * np.minimum(1.0, room / np.linalg.norm(anywhere, axis=1))[:, None]
    mixed = divide_bore(anywhere, junction.directions, junction.shares).mean(axis=0)
    if points is None or not len(points):
        return np.tile(mixed, (BANDS, 1))
    bands = points[:, 0].astype(np.int64)
    counts = np.zeros((BANDS, outlets))
    np.add.at(counts, bands, divide_bore(points[:, 1:], junction.directions, junction.shares))
    total = counts.sum(axis=1, keepdims=True)
    # In a band where no flight ended, a body is anywhere.
    return np.asarray(np.where(total > 0, counts / np.maximum(total, 1e-300), mixed))


def make_flights(
    travelings: Sequence[Traveling], snapshots: Sequence[Snapshot], workers: int, progress: Progress
) -> None:
    """Make the flights that bodies need in snapshots, in worker processes, and give them to the bodies.

    What is on disk is read. Each result is written as soon as it is there: after an interruption, only flights that
    were being made are made again.

    Raises
    ------
    WorkFailedError
        if a body cannot be flown, or workers die again and again.
    """
    wanted = [(traveling, traveling.list_tasks(snapshots)) for traveling in travelings]
    missing = [task for _, tasks in wanted for task in tasks if not task.path.is_file()]
    if missing:
        _work(missing, workers, progress)
    for traveling, tasks in wanted:
        traveling.read(tasks, [task() for task in tasks])


def _work(tasks: "Sequence[StraightTask]", workers: int, progress: Progress) -> None:
    if workers == 1 or len(tasks) == 1:
        for done, task in enumerate(tasks, start=1):
            task()
            progress(done, len(tasks))
        return
    from driftform.execution import LocalProcesses
    from driftform.study import load_study

    with closing(LocalProcesses(load_study(str(SCENARIO), run={"seed": 0}).document, workers)) as executor:
        size = 4 * workers
        for start in range(0, len(tasks), size):
            executor.call(tasks[start : start + size])
            progress(min(start + size, len(tasks)), len(tasks))
