"""The tables of a body in a network: made from flights, kept on disk, shared by all networks."""

import operator
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from functools import cache, partial
from itertools import chain, product
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from driftform.errors import InputError, did_you_mean
from driftform.types import FloatArray
from driftform.util import progress
from driftform_networks.cache import find_cache
from driftform_networks.flights import tees
from driftform_networks.flights.bodies import SCENARIO, Traveller
from driftform_networks.flights.bore import BANDS, MIRROR, MIXED
from driftform_networks.flights.fits import find_gate, find_obstacle, read_gates
from driftform_networks.flights.junctions import SIDES, Junction, describe_junction, divide_bodies, find_bends
from driftform_networks.flights.straight import StraightFlights, StraightTask
from driftform_networks.flights.tees import Tee, TeeTask
from driftform_networks.flights.transit import transit
from driftform_networks.hydraulics.epanet import split_option
from driftform_networks.hydraulics.network import Network, Snapshot
from driftform_networks.passages.routing import JOINT, TEE, Routing, RoutingTable, TransferTable

SPEED_STEP = 1.5
"""Flights are made at speeds that differ by this factor, and serve the speeds around them."""

MIN_SPEED = 0.005
"""Least speed of these flights, m/s: slower water carries a body at this pace relative to its own."""

SLOPES = (-0.5, -0.15, -0.05, 0.0, 0.05, 0.15, 0.5)
"""Slopes of these flights, rise over length; a pipe takes the nearest."""

Task: TypeAlias = StraightTask | TeeTask
"""Flights to make."""

_Outlet: TypeAlias = tuple[int, list[tuple[TeeTask, float]]]
"""An outlet, and the flights that stand for the path into it, with weights of the sum 1."""


@dataclass(frozen=True, eq=False)
class Travel:
    """How bodies travel, apart from the body.

    Attributes:
        branch: side where branches leave the pipes: ``"top"``, ``"side"`` or ``"bottom"``.
        clearance: opening of pumps, valves and meters over the bore, by kind or by the name of a link; others as in
            ``clearances.toml``.
    """

    branch: str = "side"
    clearance: Mapping[str, float] = field(default_factory=dict)

    @classmethod
    def parse(cls, network: Network, branch: str, clearance: Sequence[str] | None) -> "Travel":
        """Return the parsed options.

        Raises InputError if there is no such side, kind or link, or a clearance is not a number from 0 to 1.
        """
        if branch not in SIDES:
            raise InputError(f"--branch {branch}: no such side{did_you_mean(branch, SIDES)}")
        shares = {}
        for text in clearance or ():
            name, share = split_option("--clearance", text)
            if name not in read_gates() and name not in network.links:
                raise InputError(f"--clearance {text}: no such kind or link{did_you_mean(name, read_gates())}")
            if not (isinstance(share, float) and share <= 1):
                raise InputError(f"--clearance {text}: a clearance is a share of the bore from 0 to 1")
            shares[name] = share
        return cls(branch, shares)

    def list_blocked(self, network: Network) -> list[int]:
        """Return the links that let no body pass, however small."""
        narrow = [row for row, kind in enumerate(network.link_kinds) if kind in read_gates()]
        named = [network.links.index(name) for name in self.clearance if name in network.links]
        return [row for row in (*narrow, *named) if find_gate(self.clearance, None, network, row)[0]]


class Traveling:
    """Routes one body through the snapshots of a network.

    Args:
        traveller: the body.
        travel: side of the branches, and the like.
        folder: directory for tables; ``None`` for the user's.
    """

    def __init__(self, traveller: Traveller, travel: Travel, folder: Path | None) -> None:
        # Workers need no design, and its pipeline does not go to other processes.
        self._traveller = replace(traveller, design=None)
        self._folder = find_cache(folder)
        self._read_straight, self._read_tee = cache(StraightTask.__call__), cache(TeeTask.__call__)
        self._repeat_cells, self._find_bend = cache(repeat_cells), cache(self._fit_bends)
        self._find_bends = cache(find_bends)
        self._describe = cache(partial(describe_junction, branch=travel.branch))
        self._travel = travel

    def list_tasks(self, snapshot: Snapshot) -> Iterator[Task]:
        """Yield the flights through straight pipes and fittings that a snapshot needs."""
        for link in range(len(snapshot.links)):
            if self._needs_flights(snapshot, link):
                yield self._find_straight(snapshot, link)
            yield from (task for _, task, _ in self._list_bends(snapshot, link))
            outlets, _ = self._find_outlets(snapshot, link, self._describe(snapshot, link))
            yield from (task for _, tasks in outlets for task, _ in tasks if task.tee.share not in _ALL_INTO)

    def route(self, snapshot: Snapshot) -> Routing:
        """Return the tables of the body in a snapshot; flights that were not made are made."""
        links = progress.track_progress(range(len(snapshot.links)), len(snapshot.links), "pipes", 1.0)
        made = [(self._transfer(snapshot, link), self._divide(snapshot, link)) for link in links]
        retained = self._traveller.width >= snapshot.network.offtakes
        return Routing(snapshot, [one for one, _ in made], [table for _, table in made], MIXED, retained)

    def find_barrier(self, network: Network, index: int) -> tuple[str, str, float]:
        """Return why the body cannot pass a link, or else what it passes, in a few words, and the opening, m."""
        obstacle, gate, opening = find_gate(self._travel.clearance, self._traveller.agent.body, network, index)
        return obstacle or (self._find_bend(network, index) if network.is_pipe[index] else ""), gate, opening

    def _needs_flights(self, snapshot: Snapshot, link: int) -> bool:
        network, index = snapshot.network, snapshot.links[link]
        is_pipe = network.is_pipe[index]
        fits = self._traveller.width <= network.diameter[index]
        return bool(is_pipe and fits and not self._traveller.is_mixed(float(snapshot.speed[link])))

    def _find_straight(self, snapshot: Snapshot, link: int, share: float = 1.0) -> StraightTask:
        """Return the flights through a straight pipe that stand for a link, with a share of its water."""
        network, index = snapshot.network, snapshot.links[link]
        slope = float(network.slopes[index]) * (1 if snapshot.tail[link] == network.start[index] else -1)
        return StraightTask(
            self._traveller,
            self._folder,
            round(float(network.diameter[index]), 4),
            match_speed(share * float(snapshot.speed[link])),
            min(SLOPES, key=lambda known: abs(known - slope)),
        )

    def _transfer(self, snapshot: Snapshot, link: int) -> TransferTable:
        network, index = snapshot.network, int(snapshot.links[link])
        obstacle, gate, _ = self.find_barrier(network, index)
        if obstacle:
            return TransferTable(np.zeros((BANDS, BANDS)), np.ones(BANDS), obstacle)
        if not self._needs_flights(snapshot, link):
            time, scatter = 1.0, 0.0
            if network.is_pipe[index]:
                there = self._traveller.place(float(network.diameter[index]), float(snapshot.speed[link]))
                time, scatter = transit(there, self._traveller.width, float(network.length[index]))
            return TransferTable(np.tile(MIXED, (BANDS, 1)), np.full(BANDS, time), "", gate, scatter)
        task = self._find_straight(snapshot, link)
        flights = self._read_straight(task)
        cells = max(1, round(float(network.length[index]) / flights.cell))
        if bends := self._list_bends(snapshot, link):
            table = self._run_along(flights, cells, bends, task)
        else:
            table = self._repeat_cells(flights, cells, task)
        return replace(table, gate=gate) if gate else table

    def _list_bends(self, snapshot: Snapshot, link: int) -> list[tuple[float, TeeTask, bool]]:
        """Return share of the length before each bend drawn in a link, its flights, and whether it leads to the left."""
        network, index = snapshot.network, int(snapshot.links[link])
        if not self._needs_flights(snapshot, link) or not len(network.vertices[index]):
            return []
        turns, places = self._find_bends(network, index)
        if snapshot.tail[link] != network.start[index]:
            turns, places = -turns[::-1], 1 - places[::-1]
        straight, found = self._find_straight(snapshot, link), list[tuple[float, TeeTask, bool]]()
        for turn, place in zip(turns.tolist(), places.tolist(), strict=True):
            angle = tees.match_angle(turn, tees.BENDS_DEG)
            tee = Tee(straight.bore, straight.speed, 1.0, angle, 90.0, None)
            found += [(place, TeeTask(self._traveller, self._folder, tee, straight), turn < 0)] * (angle > 0)
        return found

    def _run_along(
        self, flights: StraightFlights, cells: int, bends: list[tuple[float, TeeTask, bool]], task: StraightTask
    ) -> TransferTable:
        """Return the table of a run of cells with bends, in which bodies take no time."""
        power, spent, before = np.eye(BANDS), np.zeros((BANDS, 2)), 0
        for place, bend, left in [*bends, (1.0, None, False)]:
            if (run := round(place * cells) - before) > 0:
                table = self._repeat_cells(flights, run, task)
                spent += power @ np.column_stack([run * table.slowness, run**2 * table.scatter])
                power = power @ table.transfer
                before += run
            if bend is not None:
                power = power @ _mirror(self._read_tee(bend).onward, left)[:, tees.RUN]
        obstacle = self._repeat_cells(flights, cells, task).obstacle
        return TransferTable(power, np.maximum(spent[:, 0] / cells, 1e-3), obstacle, scatter=spent[:, 1] / cells**2)

    def _fit_bends(self, network: Network, index: int) -> str:
        """Return why the body cannot pass the bends of a link, empty if it can."""
        bore, body = float(network.diameter[index]), self._traveller.agent.body
        found = (find_obstacle(body, bore, bore, turn) for turn in (0.0, *abs(self._find_bends(network, index)[0])))
        return next(filter(None, found), "")

    def _divide(self, snapshot: Snapshot, link: int) -> RoutingTable:
        junction, points = self._describe(snapshot, link), None
        if self._needs_flights(snapshot, link):
            points = self._read_straight(self._find_straight(snapshot, link)).states[:, :3]
        outlets, passing = self._find_outlets(snapshot, link, junction)
        onward = self._fly_on(junction, outlets)
        return divide_bodies(self._traveller, junction, points, onward, passing)

    def _find_outlets(self, snapshot: Snapshot, link: int, junction: Junction) -> tuple[list[_Outlet], str]:
        """Return the flights that stand for the end of a link, and how bodies pass it; none where streamtubes divide them.

        A cross is two tees in a row, that of the larger branch first.
        """
        if junction.stores or not len(junction.bores):
            return [], ""
        size = self._traveller.width / (junction.bore or np.inf)
        is_pipe = snapshot.network.is_pipe[snapshot.links[link]]
        is_mixed = not self._needs_flights(snapshot, link)
        if len(junction.bores) == 1:
            turn, ratio = tees.find_joint(junction, size)
            if is_mixed or not is_pipe or size >= 1 or (turn, ratio) == (0.0, 1.0):
                return [], ""
            straight = self._find_straight(snapshot, link)
            tee = Tee(straight.bore, straight.speed, ratio, turn, 90.0, None)
            return [(0, [(TeeTask(self._traveller, self._folder, tee, straight), 1.0)])], JOINT
        branches, reason = tees.find_branches(junction)
        if is_mixed and size < tees.NARROW:
            reason = reason or "narrow body"
        if reason or not is_pipe or size >= 1:
            return [], reason or "valve upstream"
        outlets, left = [], 1.0
        for branch in branches:
            straight = self._find_straight(snapshot, link, left)
            right, up = junction.directions[branch]
            speed, clock = straight.speed, np.rad2deg(np.arctan2(abs(right), up))
            if is_mixed:
                # Neither gravity nor what lies upstream matters.
                speed, clock = match_speed(max(speed, tees.MIN_MIXED_SPEED)), 90.0
            width = float(junction.bores[branch]) / junction.bore
            turn = float(junction.turns[branch]) if width > tees.NARROW_BRANCH else np.pi / 2
            angle = tees.match_angle(turn, tuple(tees.RATIOS))
            ratio = tees.match_ratio(width, size, tees.RATIOS[angle])
            shares = tees.weigh_shares(float(junction.shares[branch]) / left, size if is_mixed else 0.0)
            main, tasks = None if is_mixed else straight, []
            for share, weight in shares:
                tee = Tee(straight.bore, speed, ratio, angle, round(float(clock)), share)
                tasks.append((TeeTask(self._traveller, self._folder, tee, main), weight))
            outlets.append((branch, tasks))
            left -= float(junction.shares[branch])
        return outlets, TEE

    def _fly_on(self, junction: Junction, outlets: list[_Outlet]) -> FloatArray | None:
        """Return the probability of each outlet and band by flights, (bands, outlets, bands); ``None`` without flights."""
        if not outlets:
            return None
        onward, here = np.zeros((BANDS, len(junction.bores), BANDS)), np.eye(BANDS)
        for branch, tasks in outlets:
            table = np.zeros((BANDS, 2, BANDS))
            for task, weight in tasks:
                if task.tee.share in _ALL_INTO:
                    table[:, _ALL_INTO[task.tee.share]] += weight * np.eye(BANDS)
                else:
                    table += weight * self._read_tee(task).onward
            table = _mirror(table, junction.directions[branch, 0] < -1e-6)
            onward[:, branch] = here @ table[:, tees.BRANCH]
            here = here @ table[:, tees.RUN]
        ahead = set(range(len(junction.bores))) - {branch for branch, _ in outlets}
        onward[:, min(ahead, default=0)] = here
        return onward


_ALL_INTO: dict[float | None, int] = {0.0: tees.RUN, 1.0: tees.BRANCH}
"""Outlet that all bodies take if the branch has this share of the water, so that none need be flown."""


def _mirror(table: FloatArray, left: bool) -> FloatArray:
    """Return a table of flights, which are those of a branch, or a bend, at the right."""
    return table[MIRROR][:, :, MIRROR] if left else table


def match_speed(speed: float) -> float:
    """Return the speed (m/s) of the flights that stand for water at another speed."""
    return float(SPEED_STEP ** round(np.log(max(speed, MIN_SPEED)) / np.log(SPEED_STEP)))


def repeat_cells(flights: StraightFlights, cells: int, task: StraightTask) -> TransferTable:
    """Return the table of a run of ``cells`` cells."""
    power, spent = np.eye(BANDS), np.zeros((BANDS, 2))
    # By doubling: transfer, and mean and variance of the time, of 1, 2, 4, ... cells.
    transfer, slow, left = flights.transfer, np.column_stack([flights.slowness, flights.scatter]), cells
    while left:
        if left % 2:
            spent, power = spent + power @ slow, power @ transfer
        slow, transfer, left = slow + transfer @ slow, transfer @ transfer, left // 2
    obstacle = f"at rest on the wall: {1000 * task.bore:.0f} mm, about {task.speed:.2g} m/s"
    return TransferTable(power, np.maximum(spent[:, 0] / cells, 1e-3), obstacle, scatter=spent[:, 1] / cells**2)


def make_flights(travelings: Sequence[Traveling], snapshots: Sequence[Snapshot], workers: int) -> None:
    """Make the flights that bodies need in snapshots and that are not on disk, in worker processes.

    Each result is written as soon as it is there: after an interruption, only flights that were being made are made again.

    Raises WorkFailedError if a body cannot be flown, or workers die again and again.
    """
    needed = chain.from_iterable(traveling.list_tasks(snap) for traveling, snap in product(travelings, snapshots))
    missing = [task for path, task in {task.path: task for task in needed}.items() if not path.is_file()]
    # Flights through tees begin where those through straight pipes end.
    stages = [[task for task in missing if isinstance(task, kind)] for kind in (StraightTask, TeeTask)]
    if not (total := len(missing)):
        return
    from driftform import load_study
    from driftform.search import open_executor

    with progress.count_progress("flight tables") as show, ExitStack() as stack:
        call: Callable[[Sequence[Task]], Iterable[Any]] = partial(map, operator.call)
        if min(workers, total) > 1:
            call = stack.enter_context(open_executor(load_study(str(SCENARIO), run={"seed": 0}), workers=workers)).call
        show(0, total)
        for done, _ in enumerate(chain.from_iterable(map(call, stages)), start=1):
            show(done, total)
