"""Where a body in a network is outside of the ranges of the formulas that fly it."""

from collections.abc import Iterable

import numpy as np

from driftform.motion.forces import list_limits
from driftform.types import FloatArray
from driftform.water import Pipe, Segment
from driftform_networks.flights.bodies import Traveller
from driftform_networks.flights.travelling import match_speed
from driftform_networks.hydraulics.network import Network


def warn_of_limits(traveller: Traveller, network: Network, seen: FloatArray, steps: Iterable[int]) -> list[str]:
    """Return a warning for each range that a body leaves in pipes through which it is flown, with the share of its distance there.

    Args:
        seen: expected share of each link that it passes, (links,).
        steps: hydraulic steps whose flows carry it.
    """
    flown: dict[tuple[float, float], set[int]] = {}
    for step in steps:
        speeds = np.abs(network.hydraulics.flow[step]) / np.where(network.is_pipe, network.area, np.inf)
        for link in np.flatnonzero((seen > 0) & (speeds > 0)).tolist():
            if not traveller.is_mixed(speeds[link]):
                flown.setdefault((float(network.diameter[link]), match_speed(speeds[link])), set()).add(link)
    found: dict[str, tuple[str, set[int]]] = {}
    for (bore, speed), links in sorted(flown.items()):
        pipe = Pipe(segments=(Segment(start=(0.0, 0.0, 0.0), end=(1.0, 0.0, 0.0), radius=bore / 2),))
        flow = traveller.scenario.flow.model_copy(update={"speed": speed})
        for line in list_limits(traveller.agent, traveller.scenario.model_copy(update={"pipe": pipe, "flow": flow})):
            where = f"in {1000 * bore:.0f} mm at about {speed:.2g} m/s"
            found.setdefault(line.partition(" = ")[0], (f"{where}: {line}", set()))[1].update(links)
    distance = network.length * seen
    return [
        f"warning: {traveller.name} {line}; so it is in {100 * distance[sorted(links)].sum() / distance.sum():.0f} % of what it sees"
        for line, links in found.values()
    ]
