"""Fleets: which bodies, released where and when, see most of a network together."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Any

import numpy as np

from driftform.types import FloatArray
from driftform.util import progress
from driftform_networks.flights.bodies import Traveller
from driftform_networks.hydraulics.network import BoolArray, Network, Snapshot
from driftform_networks.passages.passage import Ending, Passage, count_passings, list_rows, merge_ends
from driftform_networks.passages.routing import Routing, route_tracers
from driftform_networks.planning.choosing import bound_steering, choose_fleet
from driftform_networks.planning.following import How, find_cases


@dataclass(frozen=True, eq=False)
class Member:
    """A member of a fleet.

    Attributes:
        passage: where it goes, with node and hour of its release.
        coverage: share of the length within reach of the fleet that it sees alone.
        gain: what it adds to that of the members before it.
    """

    agent: str
    passage: Passage
    coverage: float
    gain: float


@dataclass(frozen=True, eq=False)
class Fleet:
    """A fleet compared with tracers and steered bodies; a curve has the share of the reachable length that 1, 2, ... bodies see, (size,).

    Attributes:
        reachable: whether water from any of the releases reaches each link, (links,).
        seen: probability that any member sees each link, (links,).
        members: in the order of the choice.
        choice_bound: of the best choice among the same candidates, an upper bound.
        tracers: of point tracers, which divide like the water, at the best releases.
        retained: of bodies that divide like the water but stay in the pipes where demand leaves them, at the best
            releases.
        bound: of bodies that choose their route at every node, an upper bound.
    """

    network: Network
    reachable: BoolArray
    seen: FloatArray
    members: tuple[Member, ...]
    curve: FloatArray
    choice_bound: FloatArray
    tracers: FloatArray
    retained: FloatArray
    bound: FloatArray

    @property
    def coverage(self) -> float:
        """Expected share of the reachable length that the fleet sees."""
        return float(self.curve[-1])

    @property
    def gap_closed(self) -> float:
        """Share of the distance from point tracers to perfect steering; 0 without a distance between them."""
        gap = float(self.bound[-1] - self.tracers[-1])
        return round(float(self.curve[-1] - self.tracers[-1]) / gap, 12) if gap > 1e-9 else 0.0

    @property
    def stuck(self) -> tuple[Ending, ...]:
        """Where members are stuck, with the number of them that is expected there in place of a probability."""
        return merge_ends(end for member in self.members for end in member.passage.stuck)

    @property
    def steps(self) -> list[int]:
        """Hydraulic steps whose flows carry members."""
        return sorted({step for member in self.members for step in member.passage.steps})

    def list_tables(self) -> dict[str, dict[str, list[Any]]]:
        """Return the tables by name."""
        return {"members": self.member_table(), "curve": self.curve_table(), "links": self.link_table()}

    def as_document(self) -> dict[str, Any]:
        """Return the fleet as plain values for JSON."""
        members, links = self.member_table(), self.link_table()
        members["stuck"] = [sum(end.probability for end in member.passage.stuck) for member in self.members]
        return {
            "network": self.network.name,
            "size": len(self.members),
            "members": list_rows(members),
            "coverage": self.coverage,
            "split_by_flow": float(self.tracers[-1]),
            "retained": float(self.retained[-1]),
            "bound": float(self.bound[-1]),
            "choice_bound": float(self.choice_bound[-1]),
            "gap_closed": self.gap_closed,
            "reachable_length": float(self.network.length[self.reachable].sum()),
            "junctions": count_passings(member.passage.passings for member in self.members),
            "curve": self.curve_table(),
            "links": dict(zip(links["link"], links["seen"], strict=True)),
            "stuck": [
                {"kind": end.kind, "place": end.place, "expected": end.probability, "reason": end.reason}
                for end in self.stuck
            ],
        }

    def member_table(self) -> dict[str, list[Any]]:
        """Return the members as columns, for ``pandas.DataFrame(fleet.member_table())``."""
        return {
            "agent": [member.agent for member in self.members],
            "release": [self.network.nodes[member.passage.release] for member in self.members],
            "hour": [member.passage.hour for member in self.members],
            "probability": [member.coverage for member in self.members],
            "gain": [member.gain for member in self.members],
        }

    def curve_table(self) -> dict[str, list[Any]]:
        """Return the curves as columns."""
        return {
            "size": list(range(1, len(self.curve) + 1)),
            "coverage": self.curve.tolist(),
            "choice_bound": self.choice_bound.tolist(),
            "split_by_flow": self.tracers.tolist(),
            "retained": self.retained.tolist(),
            "bound": self.bound.tolist(),
        }

    def link_table(self) -> dict[str, list[Any]]:
        """Return the reachable links as columns."""
        return self.network.tabulate_links(self.reachable, seen=self.seen)


def plan_fleet(
    network: Network,
    travellers: Sequence[Traveller],
    releases: Sequence[str],
    size: int,
    *,
    hours: Sequence[float] = (0.0,),
    **how: Any,
) -> Fleet:
    """Choose a fleet: bodies, each released at a node and an hour, that see most together.

    Bodies travel independently of each other, and one may be chosen more than once.

    Args:
        network: from :func:`driftform_networks.open_network`.
        travellers: bodies to choose from.
        releases, hours: nodes and hours to choose from.
        size: number of members.
        how: attributes of :class:`driftform_networks.planning.following.How`.

    Raises:
        InputError: if there is no such node or hour, or no water leaves a node at any of the hours.
        WorkFailedError: if a body cannot be flown.
    """
    asked = How(**how)
    # Steady flows need no walks.
    is_solved = asked.is_steady(network) and asked.within is None
    cases = find_cases(network, releases, hours, replace(asked, walks=0) if is_solved else asked)
    flows = {case.hour: case.snapshots for case in cases}
    travelings = asked.fly(travellers, [asked.travel], [snap for flow in flows.values() for snap in flow])
    reachable = np.any([case.find_reachable() for case in cases], axis=0)
    length = np.where(reachable, network.worth, 0.0)
    blocked = asked.travel.list_blocked(network)

    def follow_all(*routes: Callable[[Snapshot], Routing]) -> list[Passage]:
        known = [cache(route) for route in routes]
        return [case.follow(*known) for case in cases]

    def choose_water(retained: bool) -> FloatArray:
        drifters = follow_all(partial(route_tracers, retained=retained, blocked=blocked))
        return choose_fleet(np.array([passage.seen for passage in drifters]), length, size)[1]

    names = [traveller.name for traveller in travellers for _ in cases]
    bodies = progress.track_progress(travelings, len(travelings), "bodies", 1.0)
    passages = [passage for drawn in bodies for passage in follow_all(*(one.route for one in drawn))]
    seen = np.array([passage.seen for passage in passages])
    chosen, curve, choice_bound = choose_fleet(seen, length, size)
    missed = np.cumprod(1 - seen[chosen], axis=0) @ length / length.sum()
    members = tuple(
        Member(names[row], passages[row], float(seen[row] @ length / length.sum()), float(gain))
        for row, gain in zip(chosen.tolist(), (-np.diff(missed, prepend=1.0)).tolist(), strict=True)
    )
    nodes = list(dict.fromkeys(case.node for case in cases))
    sizes = progress.track_progress(range(1, size + 1), size, "sizes of a fleet that is steered", 1.0)
    steered = (bound_steering(list(flows.values()), nodes, reachable, count, blocked) for count in sizes)
    bound, by_any = np.fromiter(steered, float), 1 - np.prod(1 - seen[chosen], axis=0)
    water = choose_water(False), choose_water(True)
    return Fleet(network, reachable, by_any, members, curve, choice_bound, *water, bound)
