"""The plan of an inspection: where and when bodies are released, where nets catch them, and what they see until then."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import chain
from typing import Any

import numpy as np

from driftform.types import FloatArray
from driftform.util import progress
from driftform_networks.flights.bodies import Traveller
from driftform_networks.hydraulics.network import BoolArray, IntArray, Network
from driftform_networks.passages.passage import Ending, count_passings, find_passings, list_rows, merge_ends
from driftform_networks.passages.walkers import Walks, count_ends
from driftform_networks.planning.choosing import choose_fleet
from driftform_networks.planning.following import Case, How, find_cases

AIMS = ("records", "caught")
"""Aims of nets: the length of pipe that caught bodies have seen, or the number of caught bodies."""

MAX_PLACES = 400
"""Most places for nets that are compared: those that most bodies pass."""

_DRAWS = 200
"""Number of random placements, whose mean is compared with the choice."""


@dataclass(frozen=True, eq=False)
class Plan:
    """A plan of an inspection.

    Attributes:
        members: agent, node and hour of each release.
        nets: nodes of the nets, in the order of the choice.
        catches: share of the bodies that each net is the first to catch, (nets,).
        arrivals: mean time of these catches since the release, s, (nets,); NaN for a net that catches none.
        reachable: whether water of the releases reaches each link, (links,).
        alone, seen: probability that any body sees each link before its battery ends, without nets and with them,
            (links,).
        recorded: the same for bodies that are caught alone, (links,): what is known if what a lost body has seen is
            lost.
        value, bound, random: what the nets are for, as a share of what all nets at once could give; an upper bound on
            it for any choice of as many nets; and its mean over random ones.
        passings: how each member passes the junctions on its ways, as in a passage.
        ends: how members end without nets, with their number in place of a probability.
        steps: hydraulic steps whose flows carry them.
    """

    network: Network
    members: tuple[tuple[str, str, float], ...]
    nets: tuple[str, ...]
    catches: FloatArray
    arrivals: FloatArray
    reachable: BoolArray
    alone: FloatArray
    seen: FloatArray
    recorded: FloatArray
    value: float
    bound: float
    random: float
    passings: Sequence[Mapping[int, str]]
    ends: Sequence[Ending]
    steps: Sequence[int]

    def measure(self, seen: FloatArray) -> float:
        """Return the share of the length in reach that is seen, by the probability of each link."""
        worth = np.where(self.reachable, self.network.worth, 0.0)
        return float(worth @ seen / worth.sum())

    def list_tables(self) -> dict[str, dict[str, list[Any]]]:
        """Return the tables by name: the releases, the nets with their places on the map, and the reachable links."""
        x, y = self.network.places[[self.network.find_node(name) for name in self.nets]].T.tolist()
        shares = {name: getattr(self, name) for name in ("alone", "seen", "recorded")}
        return {
            "members": dict(zip(("agent", "release", "hour"), map(list, zip(*self.members, strict=True)), strict=True)),
            "nets": {"node": list(self.nets), "x": x, "y": y}
            | {"catches": self.catches.tolist(), "mean_age_s": self.arrivals.tolist()},
            "links": self.network.tabulate_links(self.reachable, **shares),
        }

    def as_document(self) -> dict[str, Any]:
        """Return the plan as plain values for JSON."""
        tables = self.list_tables()
        return {
            "network": self.network.name,
            "members": list_rows(tables["members"]),
            "nets": list_rows(tables["nets"]),
            "caught": float(self.catches.sum()),
            "coverage": self.measure(self.alone),
            "coverage_with_nets": self.measure(self.seen),
            "recorded": self.measure(self.recorded),
            **{name: getattr(self, name) for name in ("value", "bound", "random")},
            "junctions": count_passings(self.passings),
            "reachable_length": float(self.network.length[self.reachable].sum()),
        }


def choose_nets(times: FloatArray, worth: FloatArray, size: int) -> tuple[IntArray, float, float]:
    """Choose places of nets one after the other, then exchange them while that helps; the first net on its route catches a body.

    Args:
        times: when each walk comes to each place, infinite where it does not, (places, walks).
        worth: what it is worth to catch the walk there, (places, walks).
        size: most nets.

    Returns:
        chosen, value, bound: rows of the places; what they are worth; and an upper bound on what any choice of so many
            places is worth. A net upstream takes from one downstream, so that the value is not submodular where the
            worth grows along the path. What is bounded is the worth at the best net that a walk passes, which is
            submodular and never less: so many nets add to any set at most the sum of the largest gains (Nemhauser,
            Wolsey and Fisher 1978, doi:10.1007/BF01588971).
    """
    worth = np.where(np.isfinite(times), worth, 0.0)
    size, chosen = min(size, len(times)), list[int]()

    def evaluate(others: list[int]) -> FloatArray:
        """What each place is worth together with others."""
        value, _, when = catch(times[others], worth[others])
        return np.asarray(np.where(times < when, worth, value).sum(axis=1))

    bound = float(worth.max(axis=0, initial=0.0).sum())
    for number in range(size + 1):
        best = worth[chosen].max(axis=0, initial=0.0)
        gains = np.sort(np.maximum(worth - best, 0.0).sum(axis=1))[::-1]
        bound = min(bound, float(best.sum() + gains[:size].sum()))
        if number < size:
            chosen.append(_find_best(evaluate(chosen)))
    for place in list(range(size)) * 5:
        others = chosen[:place] + chosen[place + 1 :]
        values = evaluate(others)
        if values.max() > values[chosen[place]] * (1 + 1e-9):
            chosen[place] = _find_best(values)
    # Where one more net would take more from the others than it yields, or catch nobody, there are fewer.
    value, first, when = catch(times[chosen], worth[chosen])
    kept = {chosen[net] for net in first[np.isfinite(when)].tolist()}
    return np.array([place for place in dict.fromkeys(chosen) if place in kept], np.int64), float(value.sum()), bound


def _find_best(values: FloatArray) -> int:
    """Return the first of the greatest values: rounding must not decide between equals."""
    return int(np.flatnonzero(values >= values.max() - 1e-9 * abs(values.max()))[0])


def plan_inspection(
    network: Network,
    travellers: Sequence[Traveller],
    releases: Sequence[str],
    nets: int,
    *,
    places: Sequence[str] = (),
    hours: Sequence[float] = (0.0,),
    size: int = 3,
    within: float = 8.0,
    battery: float | None = None,
    aim: str = "records",
    **how: Any,
) -> Plan:
    """Choose releases, hours, and nets: bodies that see most before their battery ends, and nets that catch them in time.

    Args:
        network, travellers, releases, hours, how: as for :func:`driftform_networks.plan_fleet`; all is read from walks.
        nets: most nets.
        places: nodes where nets may be; all junctions if there are none.
        size: number of bodies.
        within: hours from the release until which bodies may be caught, such as a shift.
        battery: hours from the release in which they see; ``None`` for ``within``.
        aim: one of :data:`AIMS`.

    Raises:
        InputError: if there is no such node or hour, or no water leaves a node at any of the hours.
        WorkFailedError: if a body cannot be flown.
    """
    asked = How(within=within, **how)
    cases = find_cases(network, releases, hours, asked)
    flows = {case.hour: case.snapshots for case in cases}
    travelings = asked.fly(travellers, [asked.travel], [snap for flow in flows.values() for snap in flow])
    followed: list[tuple[str, Case, Walks]] = []
    passed: list[tuple[dict[int, str], list[Ending]]] = []
    for traveller, drawn in zip(travellers, travelings, strict=True):
        routes = [cache(traveling.route) for traveling in drawn]
        for case in progress.track_progress(cases, len(cases), "releases", 1.0):
            tables = [[route(snap) for snap in case.snapshots] for route in routes]
            routings = [*chain.from_iterable(tables)]
            followed.append((traveller.name, case, case.walk(tables)))
            visits = np.bincount(followed[-1][2].node + 1, minlength=len(network.nodes) + 1)[1:]
            ends = list(count_ends(followed[-1][2], routings))
            passed.append((find_passings(routings, visits.astype(np.float64)), ends))
    reachable = np.any([case.find_reachable() for case in cases], axis=0)
    life = np.full(len(followed[0][2].began), 3600 * (within if battery is None else min(battery, within)))
    sight = np.array([walks.until(life).measure_sight() for *_, walks in followed])
    picked, _, _ = choose_fleet(sight, np.where(reachable, network.worth, 0.0), size)
    members = [followed[row] for row in picked.tolist()]
    paths = [walks for *_, walks in members]
    allowed = [network.find_node(name) for name in places] or np.flatnonzero(~network.stores).tolist()
    times, worth, nodes = _tabulate(paths, life, allowed, aim)
    chosen, value, bound = choose_nets(times, worth, nets)
    rng, total = np.random.default_rng(asked.seed), max(float(worth.max(axis=0, initial=0.0).sum()), 1e-300)
    draws = [rng.choice(len(nodes), len(chosen), replace=False) for _ in range(_DRAWS)]
    random = float(np.mean([catch(times[draw], worth[draw])[0].sum() for draw in draws]))
    _, first, when = catch(times[chosen], worth[chosen])
    caught = [when[np.isfinite(when) & (first == net)] for net in range(len(chosen))]
    until = (np.full(len(when), np.inf), when, np.where(np.isfinite(when), when, -1.0))
    parts = [zip(paths, np.split(ends, len(paths)), strict=True) for ends in until]
    sights = [[walks.until(np.minimum(life, end)).measure_sight() for walks, end in part] for part in parts]
    # Probability that any body sees each link, if each walk ends at its time or with its battery.
    alone, seen, recorded = (1 - np.prod(1 - np.array(each), axis=0) for each in sights)
    return Plan(
        network,
        tuple((name, case.release, case.hour) for name, case, _ in members),
        tuple(network.nodes[nodes[row]] for row in chosen),
        np.array([len(some) / len(when) for some in caught]),
        np.array([some.mean() if len(some) else np.nan for some in caught]),
        reachable,
        alone,
        seen,
        recorded,
        value / total,
        bound / total,
        random / total,
        [passed[row][0] for row in picked.tolist()],
        merge_ends(end for row in picked.tolist() for end in passed[row][1]),
        sorted({snap.step for _, case, _ in members for snap in case.snapshots}),
    )


def _tabulate(
    paths: Sequence[Walks], life: FloatArray, allowed: Sequence[int], aim: str
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Return when each body comes first to each place, what that is worth, and the nodes of these places.

    Returns:
        times, worth, nodes: since the release, s, (places, bodies); length that it has seen, or 1, (places, bodies);
            and (places,).
    """
    count, network = len(life), paths[0].network
    marks = np.zeros(len(network.nodes), bool)
    marks[list(allowed)] = True
    rows, columns, times, records = [], [], [], []
    for number, path in enumerate(paths):
        record = np.where(path.ages <= life[path.walk], path.measure_records(), -1.0)
        # A body that outlives its battery keeps what it has seen until then.
        best = np.zeros(count)
        np.maximum.at(best, path.walk, record)
        arrived = path.first_arrivals()
        arrived = arrived[marks[path.node[arrived]]]
        rows.append(path.node[arrived])
        columns.append(number * count + path.walk[arrived])
        times.append(path.ages[arrived])
        records.append(np.where(record[arrived] >= 0, record[arrived], best[path.walk[arrived]]))
    row, column = np.concatenate(rows), np.concatenate(columns)
    passed = np.bincount(row, minlength=len(marks))
    nodes = np.sort(np.argsort(-passed, kind="stable")[: min(MAX_PLACES, int((passed > 0).sum()))])
    place = np.full(len(marks), -1)
    place[nodes] = np.arange(len(nodes))
    kept = place[row] >= 0
    shape, where = (len(nodes), len(paths) * count), (place[row[kept]], column[kept])
    table, worth = np.full(shape, np.inf), np.zeros(shape)
    table[where] = np.concatenate(times)[kept]
    worth[where] = np.concatenate(records)[kept] if aim == "records" else 1.0
    return table, worth, nodes


def catch(times: FloatArray, worth: FloatArray) -> tuple[FloatArray, IntArray, FloatArray]:
    """Return for each walk what catching it is worth, the first net that it meets, and when, infinite without one, s."""
    if not len(times):
        return np.zeros(times.shape[1]), np.zeros(times.shape[1], np.int64), np.full(times.shape[1], np.inf)
    first, columns = np.argmin(times, axis=0), np.arange(times.shape[1])
    when = times[first, columns]
    return np.where(np.isfinite(when), worth[first, columns], 0.0), first, when
