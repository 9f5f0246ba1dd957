"""Where a body in a network is outside of the ranges of the formulas that fly it, and where its weight decides."""

from collections.abc import Iterable, Mapping

import numpy as np

from driftform.motion.forces import list_limits
from driftform.types import FloatArray
from driftform_networks.flights.bodies import Traveller
from driftform_networks.flights.travelling import match_speed
from driftform_networks.hydraulics.network import Network
from driftform_networks.passages.routing import TEE


def warn_of_limits(traveller: Traveller, network: Network, seen: FloatArray, steps: Iterable[int]) -> list[str]:
    """Return a warning for each range that a body leaves in pipes through which it is flown, with the share of its distance there.

    Args:
        seen: expected share of each link that it passes, (links,).
        steps: hydraulic steps whose flows carry it.
    """
    flown: dict[tuple[float, float], set[int]] = {}
    for speeds in network.find_speeds(steps):
        for link in np.flatnonzero((seen > 0) & (speeds > 0)).tolist():
            if not all(one.is_mixed(speeds[link]) for one in traveller.drawn):
                flown.setdefault((float(network.diameter[link]), match_speed(speeds[link])), set()).add(link)
    found: dict[str, tuple[str, set[int]]] = {}
    for (bore, speed), links in sorted(flown.items()):
        for line in list_limits(traveller.agent, traveller.place(bore, speed)):
            where = f"in {1000 * bore:.0f} mm at about {speed:.2g} m/s"
            found.setdefault(line.partition(" = ")[0], (f"{where}: {line}", set()))[1].update(links)
    distance = network.length * seen
    return [
        f"warning: {traveller.name} {line}; so it is in {100 * distance[sorted(links)].sum() / distance.sum():.0f} % of what it sees"
        for line, links in found.values()
    ]


def word_weight(traveller: Traveller, network: Network, passings: Mapping[int, str], steps: Iterable[int]) -> list[str]:
    """Return a line with the net weights that are drawn for a body, and the tees on its way at which a tenth of a gram decides."""
    tees = [node for node, how in passings.items() if how == TEE]
    speeds, gravity = network.find_speeds(steps).max(axis=0), traveller.scenario.fluid.gravity
    # The greatest speed beside a tee leaves a body the most room.
    fastest = (speeds[(network.start == node) | (network.end == node)].max() for node in tees)
    milligrams = np.sort([1e6 * traveller.mixing_limit(speed) / gravity for speed in fastest])
    weights = [f"{-1000 * one.net_buoyancy / gravity:.2g} g" for one in traveller.drawn]
    drawn = f"half of the bodies weigh {' in the water, half '.join(weights)}" if len(weights) > 1 else ""
    if not len(milligrams):
        return [drawn] * bool(drawn)
    return [
        f"{drawn and drawn + '; '}a tenth of a gram decides at {(milligrams < 100).sum()} of {len(tees)} tees and crosses: the water mixes bodies of at most "
        f"{round(milligrams[0], 3):.2g} to {milligrams[-1]:.2g} mg of net weight there, and others ride along the top or the bottom"
    ]
