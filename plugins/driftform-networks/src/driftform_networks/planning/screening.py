"""Which bodies may be used: where each can go from a release, where it drags along the wall or stops, and what it meets there."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from driftform.types import FloatArray
from driftform_networks.flights.bodies import Traveller, buoyancy_error
from driftform_networks.flights.threshold import moving_speed
from driftform_networks.flights.travelling import SLOPES, Traveling
from driftform_networks.hydraulics.network import STILL, BoolArray, Network
from driftform_networks.passages.passage import Passage, find_reachable
from driftform_networks.passages.routing import route_tracers
from driftform_networks.planning.following import Case, How, find_cases

SIZES_MM = (100, 80, 60, 45, 30, 20, 10)
"""Diameters of spheres, mm, besides that of the port."""

LIFT = 5e-6
"""Weight of the water that a sphere displaces over the cube of its diameter, N/mm3, rounded down: what is lighter is left out."""

WEIGHTS = (0.0, -0.001, -0.01, -0.1)
"""Their net buoyancies by default, N: neutral, and a tenth of a gram, one and ten grams heavier than the water."""

DAY_H, FAR = 24.0, 0.95
"""Hours that are looked at by default, and share of the greatest reach from which a body goes as far as any."""


@dataclass(frozen=True, eq=False)
class Screened:
    """What a body meets on its ways.

    Attributes:
        goes: whether it can go into each link at some hour, (links,).
        stops: share of the time in which it stands still there, (links,).
        facts: reach, shares of its ways by hour, bore, fitting, pressure, and why its ways end, as plain values for JSON.
    """

    body: Traveller
    goes: BoolArray
    stops: FloatArray
    facts: Mapping[str, Any]


def screen_bodies(
    network: Network, travellers: Sequence[Traveller], release: str, *, hour: float = 0.0, **how: Any
) -> tuple[list[Screened], Screened, Passage]:
    """Compare bodies by what they meet on all ways of the water from a release, without flights.

    Args:
        network, release, hour, how: as for :func:`driftform_networks.route`; ``within`` is by default a day, or what is simulated.
        travellers: bodies to compare.

    Returns:
        bodies, best, passage: all; of those that can be made, the widest that goes as far as any, and the heaviest of these; and
            where this one goes if it divides like the water.

    Raises InputError if there is no such node or hour, or no water leaves the node.
    """
    asked, left = How(**how), network.hydraulics.end / 3600 - hour
    if asked.is_steady(network):
        # The chain says all, also where bodies go round in a loop for ever.
        asked = replace(asked, walks=0, within=None)
    elif asked.within is None and left > 0:
        asked = replace(asked, within=min(DAY_H, left))
    [case] = find_cases(network, [release], [hour], asked)
    bodies = [_screen(case, traveller) for traveller in travellers]
    # Nobody makes a neutral body, so that its reach is nobody's.
    doubts = [buoyancy_error(one.body.agent, one.body.scenario) for one in bodies]
    made = [one for one, doubt in zip(bodies, doubts, strict=True) if abs(one.body.net_buoyancy) > doubt / 2] or bodies
    most = max(one.facts["reach"] for one in made)
    far = [one for one in made if one.facts["reach"] >= FAR * most]
    best = max(far, key=lambda one: (one.body.width, abs(one.facts["net_buoyancy"])))
    blocked, retained = set(np.flatnonzero(~best.goes).tolist()), best.body.width >= network.offtakes
    return bodies, best, case.follow(partial(route_tracers, retained=retained, blocked=blocked))


def list_catches(passage: Passage) -> list[dict[str, Any]]:
    """Return for each bore, by the widest pipe of a junction, the one at which most bodies arrive; the largest bore first."""
    network, bores = passage.network, np.zeros(len(passage.network.nodes))
    for ends in (network.start, network.end):
        np.maximum.at(bores, ends, np.where(network.is_pipe, network.diameter, 0.0))
    likely = np.where(network.stores, 0.0, passage.probability)
    likely[passage.release] = 0.0
    found = {float(bores[node]): node for node in np.argsort(likely, kind="stable").tolist() if likely[node] >= 0.01}
    return [
        {"bore": bore, "node": network.nodes[node], "probability": float(likely[node]), "age": float(passage.age[node])}
        for bore, node in sorted(found.items(), reverse=True)
    ]


def _screen(case: Case, traveller: Traveller) -> Screened:
    """Return what a body meets from a release on."""
    network, hydraulics, fluid = case.network, case.network.hydraulics, traveller.scenario.fluid
    steps = [snapshot.step for snapshot in case.snapshots]
    find = Traveling(traveller, case.how.travel, None).find_barrier
    obstacles, gates, openings = zip(*(find(network, link) for link in range(len(network.links))), strict=True)
    flow, speeds, fits = hydraulics.flow[steps], network.find_speeds(steps), np.array([not one for one in obstacles])
    flows, net = np.abs(flow) > STILL, traveller.agent.mass.net_buoyancy(fluid)
    moves = fits & flows & (speeds >= _list_thresholds(traveller, network, flow, fits))
    rides = moves & (traveller.mixing_limit(1.0) * speeds**2 >= abs(net))
    goes = find_reachable(network, case.node, steps, moves)
    length = np.where(goes, network.length, 0.0)
    parts = [part @ length / max(length.sum(), 1e-9) for part in (rides, moves & ~rides, ~moves)]
    names, times = ("hour", "rides", "drags", "stops"), hydraulics.times[steps] / 3600
    hours = [dict(zip(names, row, strict=True)) for row in np.column_stack([times, *parts]).tolist()]
    nodes = np.unique(np.concatenate([[case.node], network.start[goes], network.end[goes]]))
    through = nodes[~network.stores[nodes] | (nodes == case.node)]
    ends = flows & ~goes & np.isin(np.where(flow > 0, network.start, network.end), through)
    heads = (hydraulics.head[steps] - network.elevation)[:, nodes]
    row, column = np.unravel_index(int(heads.argmax()), heads.shape)
    design, passed = traveller.design, np.flatnonzero(goes)
    hull = design and design.pipeline.builder.describe_strength(traveller.agent.body, fluid)
    facts = {
        "body": traveller.name,
        "diameter": traveller.width,
        "net_buoyancy": net,
        "reach": float(length.sum() / network.length.sum()),
        "nodes": len(nodes),
        "worst": min(hours, key=lambda hour: (-round(hour["stops"], 6), hour["rides"])),
        "hours": hours,
        "narrowest": min(passed[network.is_pipe[passed]].tolist(), key=network.diameter.__getitem__, default=None),
        "fitting": min((link for link in passed.tolist() if gates[link]), key=openings.__getitem__, default=None),
        "pressure": float(heads[row, column] * fluid.density * fluid.gravity),
        "pressure_at": network.nodes[nodes[column]],
        "pressure_hour": hours[row]["hour"],
        "hull_fails_at": hull["pressure"] if hull else None,
        "closed": {
            network.links[link]: obstacles[link] or "the water is too slow to move it"
            for link in np.flatnonzero(ends.any(axis=0)).tolist()
        },
    }
    for name, words in (("narrowest", [f"{1000 * bore:.0f} mm" for bore in network.diameter]), ("fitting", gates)):
        if (link := facts[name]) is not None:
            facts[name] = f"{network.links[link]}, {words[link]}"
    return Screened(traveller, goes, (~moves).mean(axis=0), facts)


def _list_thresholds(traveller: Traveller, network: Network, flow: FloatArray, fits: BoolArray) -> FloatArray:
    """Return the speeds (m/s) from which the water of each link moves a body, by the direction of its flow, (steps, links)."""
    known = np.array(SLOPES)
    slopes = known[np.abs(network.slopes[:, None] - known).argmin(axis=1)]
    pipes = np.flatnonzero(network.is_pipe & fits & (network.diameter > traveller.width))
    kinds, kind = np.unique(np.column_stack([network.diameter.round(4), slopes])[pipes], axis=0, return_inverse=True)
    found = np.zeros((2, len(network.links)))
    for row, sign in enumerate((-1, 1)):
        speeds = np.array([moving_speed(traveller, bore, sign * slope) for bore, slope in kinds.tolist()])
        found[row, pipes] = speeds[kind]
    return np.asarray(np.where(flow > 0, found[1], found[0]))
