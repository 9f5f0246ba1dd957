"""The tables of a body in a network: made from flights, kept on disk, shared by all networks."""

from collections.abc import Callable, Iterable, Sequence
from copy import copy
from dataclasses import asdict, dataclass, replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from driftform.errors import InputError, did_you_mean
from driftform.types import FloatArray
from driftform_networks.bodies import SCENARIO, Traveller
from driftform_networks.bore import BANDS, MIRROR, MIXED
from driftform_networks.cache import find_cache, hash_content
from driftform_networks.dividing import divide_bodies
from driftform_networks.fits import find_obstacle
from driftform_networks.junctions import SIDES, Geometry, Junction
from driftform_networks.routing import Routing, RoutingTable, TransferTable
from driftform_networks.snapshot import Snapshot
from driftform_networks.tees import (
    ANGLES_DEG,
    BRANCH,
    NARROW,
    RUN,
    SLOWEST_MIXED,
    Tee,
    find_branch,
    match_ratio,
    send_all,
    weigh_shares,
)

if TYPE_CHECKING:
    from driftform_networks.flights import StraightFlights, StraightTask
    from driftform_networks.tee_flights import TeeFlights, TeeTask

SPEED_STEP = 1.5
"""Flights are made at speeds that differ by this factor, and serve the speeds around them."""

SLOWEST = 0.005
"""Least speed of these flights, m/s: slower water carries a body at this pace relative to its own."""

SLOPES = (-0.5, -0.15, -0.05, 0.0, 0.05, 0.15, 0.5)
"""Slopes of these flights, rise over length; a pipe takes the nearest."""

SERVICE_BORE = 0.02
"""Default bore of the service pipes through which demand leaves, m: a narrower body leaves with it."""

Progress = Callable[[int, int], None]
"""Takes the number of tables that are made, and of all."""

_Key = tuple[float, float, float]
"""Bore, speed and slope of flights."""

_TeeKey = tuple[Tee, _Key | None]
"""A tee, and the flights through the main whose ends lead into it; ``None`` for a mixed body."""


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
        # Workers need no design, and its pipeline does not go to other processes.
        self._traveller = replace(traveller, design=None)
        self._geometry, self._travel = geometry, travel
        self._retained = traveller.agent.body.max_diameter >= travel.service_bore
        self._folder = find_cache(cache)
        self._hash = traveller.hash()
        self._flights: dict[_Key, StraightFlights] = {}
        self._tees: dict[_TeeKey, TeeFlights] = {}
        self._transfers: dict[tuple[object, ...], TransferTable] = {}
        self._bends: dict[int, str] = {}

    def with_branch(self, branch: str) -> "Traveling":
        """Return the same body where branches leave the pipes at another side; it shares the flights."""
        other = copy(self)
        other._geometry = Geometry(self._geometry.network, branch)
        other._travel = replace(self._travel, branch=branch)
        return other

    def list_straights(self, snapshots: Iterable[Snapshot]) -> "list[StraightTask]":
        """Return the flights through straight pipes that these snapshots need and that were not read yet."""
        keys = {
            self._key(snapshot, link)
            for snapshot in snapshots
            for link in range(len(snapshot.links))
            if self._needs_flights(snapshot, link)
        }
        return [self._straight(key) for key in sorted(keys - self._flights.keys())]

    def list_tees(self, snapshots: Iterable[Snapshot]) -> "list[TeeTask]":
        """Return the flights through tees that these snapshots need and that were not read yet."""
        from driftform_networks.tee_flights import TeeTask

        keys = {
            key
            for snapshot in snapshots
            for link in range(len(snapshot.links))
            for key, _ in self._find_tees(snapshot, link, self._geometry.describe(snapshot, link))
            if key[0].share not in (0.0, 1.0)
        }
        return [
            TeeTask(
                self._traveller,
                tee,
                None if key is None else self._straight(key),
                self._path("tee", (tee, key)),
            )
            for tee, key in sorted(keys - self._tees.keys(), key=repr)
        ]

    def _straight(self, key: _Key) -> "StraightTask":
        from driftform_networks.flights import StraightTask

        return StraightTask(self._traveller, *key, self._path("straight", key))

    def _path(self, name: str, key: _Key | _TeeKey) -> Path:
        plain = [asdict(part) if isinstance(part, Tee) else part for part in key]
        return self._folder / f"{hash_content({'body': self._hash, name: plain})}.npz"

    def read_straights(self, tasks: "Iterable[StraightTask]") -> None:
        """Take the results of tasks."""
        for task in tasks:
            key = task.bore, task.speed, task.slope
            # Copies of this object, with branches at other sides, may have read them.
            self._flights[key] = self._flights.get(key) or task()

    def read_tees(self, tasks: "Iterable[TeeTask]") -> None:
        """Take the results of tasks."""
        for task in tasks:
            straight = task.straight
            key = None if straight is None else (straight.bore, straight.speed, straight.slope)
            self._tees[task.tee, key] = self._tees.get((task.tee, key)) or task()

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
        return round(float(network.diameter[index]), 4), _match_speed(speed), nearest

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
        onward = self._fly_on(junction, self._find_tees(snapshot, link, junction))
        return divide_bodies(self._traveller, junction, points, self._travel.service_bore, onward)

    def _find_tees(self, snapshot: Snapshot, link: int, junction: Junction) -> list[tuple[_TeeKey, float]]:
        """Return the tees that stand for a junction, with weights; none for one that streamtubes divide."""
        branch = find_branch(junction)
        size = self._traveller.agent.body.max_diameter / (junction.bore or np.inf)
        is_pipe = snapshot.network.link_kinds[snapshot.links[link]] == "pipe"
        is_mixed = not self._needs_flights(snapshot, link)
        if branch is None or not is_pipe or size >= 1 or (is_mixed and size < NARROW):
            return []
        bore, speed, slope = self._key(snapshot, link)
        right, up = junction.directions[branch]
        clock = np.rad2deg(np.arctan2(abs(right), up))
        if is_mixed:
            # Neither gravity nor what lies upstream matters.
            speed, clock = _match_speed(max(speed, SLOWEST_MIXED)), 90.0
        turn = float(np.rad2deg(junction.turns[branch]))
        angle = min(ANGLES_DEG, key=lambda known: abs(known - turn))
        ratio = match_ratio(float(junction.bores[branch]) / junction.bore, size)
        return [
            (
                (
                    Tee(bore, speed, ratio, angle, round(float(clock)), share),
                    None if is_mixed else (bore, speed, slope),
                ),
                weight,
            )
            for share, weight in weigh_shares(float(junction.shares[branch]), size if is_mixed else 0.0)
        ]

    def _fly_on(self, junction: Junction, tees: list[tuple[_TeeKey, float]]) -> FloatArray | None:
        """Return the probability of each outlet and band by flights, (bands, outlets, bands); ``None`` without tees."""
        branch = find_branch(junction)
        if branch is None or not tees:
            return None
        ends = {0.0: RUN, 1.0: BRANCH}
        onward = np.zeros((BANDS, 2, BANDS))
        for key, weight in tees:
            share = key[0].share
            onward += weight * (send_all(ends[share]) if share in ends else self._tees[key].onward)
        if junction.directions[branch, 0] < -1e-6:
            # Flights are those of a branch at the right.
            onward = onward[MIRROR][:, :, MIRROR]
        return np.asarray(onward[:, [RUN, BRANCH] if branch == 1 else [BRANCH, RUN]])


def _match_speed(speed: float) -> float:
    return float(SPEED_STEP ** round(np.log(speed) / np.log(SPEED_STEP)))


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
    straights = [traveling.list_straights(snapshots) for traveling in travelings]
    tees = [traveling.list_tees(snapshots) for traveling in travelings]
    # Flights through tees begin where those through straight pipes end.
    stages = [_find_missing(straights), _find_missing(tees)]
    if any(stages):
        _work(stages, workers, progress)
    for traveling, runs, forks in zip(travelings, straights, tees, strict=True):
        traveling.read_straights(runs)
        traveling.read_tees(forks)


def _find_missing(wanted: "Sequence[Sequence[StraightTask | TeeTask]]") -> "list[StraightTask | TeeTask]":
    """Return the tasks whose results are not on disk, each once."""
    tasks = {task.path: task for tasks in wanted for task in tasks}
    return [task for path, task in tasks.items() if not path.is_file()]


def _work(stages: "Sequence[Sequence[StraightTask | TeeTask]]", workers: int, progress: Progress) -> None:
    total = sum(map(len, stages))
    if workers == 1 or total == 1:
        for done, task in enumerate(chain.from_iterable(stages), start=1):
            task()
            progress(done, total)
        return
    from driftform import load_study
    from driftform.search import open_executor

    with open_executor(load_study(str(SCENARIO), run={"seed": 0}), workers=workers) as executor:
        size, done = 4 * workers, 0
        for tasks in stages:
            for start in range(0, len(tasks), size):
                executor.call(tasks[start : start + size])
                done += len(tasks[start : start + size])
                progress(done, total)
