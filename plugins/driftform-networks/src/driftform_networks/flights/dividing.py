"""Where a body goes at a junction: by flights through it, or by the streamtubes of its bore."""

import numpy as np

from driftform.types import FloatArray
from driftform_networks.flights.bodies import Traveller
from driftform_networks.flights.bore import BANDS, MIXED
from driftform_networks.flights.fits import find_obstacle
from driftform_networks.flights.junctions import Junction
from driftform_networks.flights.streamtubes import divide_bore, divide_mixed
from driftform_networks.passages.routing import JOINT, TEE, RoutingTable

_HELD = {TEE: "held in a tee, where the flow divides", JOINT: "held in a bend or reducer"}


def divide_bodies(
    traveller: Traveller,
    junction: Junction,
    points: FloatArray | None,
    service_bore: float,
    onward: FloatArray | None = None,
    passing: str = "",
) -> RoutingTable:
    """Return where a body goes at a junction, by flights or by the streamtubes of its bore.

    Args:
        points: band and place of bodies at the end of the link, (n, 3); ``None`` for a body that is anywhere in the
            bore.
        service_bore: bore of service pipes, m.
        onward: probability of each outlet and of the band in it by flights, for each band, (bands, outlets, bands);
            ``None`` for streamtubes.
        passing: of the table.
    """
    outlets = len(junction.bores)
    nothing = np.zeros((BANDS, outlets))
    band = MIXED if points is None else np.eye(BANDS)[:, None, :]
    arrival = np.broadcast_to(band, (BANDS, outlets, BANDS))
    if junction.stores:
        return RoutingTable(nothing, arrival, np.ones(BANDS))
    leaves = junction.exit if traveller.width < service_bore else 0.0
    if not outlets:
        obstacle = f"a dead end: too wide for service pipes of {1000 * service_bore:.0f} mm"
        return RoutingTable(nothing, arrival, np.full(BANDS, 1.0 if leaves else 0.0), obstacle)
    obstacles = [
        find_obstacle(traveller.agent.body, junction.bore, float(bore), turn)
        for bore, turn in zip(junction.bores, junction.turns, strict=True)
    ]
    passes = np.array([not obstacle for obstacle in obstacles])
    obstacle = next(filter(None, obstacles), "")
    if onward is None:
        share = _choose(traveller, junction, points)
    else:
        share, obstacle = onward.sum(axis=2), obstacle or _HELD.get(passing, "")
        arrival = np.where(share[:, :, None] > 0, onward / np.maximum(share, 1e-300)[:, :, None], arrival)
    return RoutingTable(share * (1 - leaves) * passes, arrival, np.full(BANDS, leaves), obstacle, passing)


def _choose(traveller: Traveller, junction: Junction, points: FloatArray | None) -> FloatArray:
    """Return the share of the bodies in each band that the streamtubes carry into each outlet, (bands, outlets)."""
    outlets = len(junction.bores)
    if outlets == 1:
        return np.ones((BANDS, 1))
    bore = junction.bore or float(junction.bores.max())
    room = max(1 - traveller.width / bore, 1e-3)
    mixed = divide_mixed(junction.directions, junction.shares, room)
    if points is None or not len(points):
        return np.tile(mixed, (BANDS, 1))
    bands = points[:, 0].astype(np.int64)
    counts = np.zeros((BANDS, outlets))
    np.add.at(counts, bands, divide_bore(points[:, 1:], junction.directions, junction.shares))
    total = counts.sum(axis=1, keepdims=True)
    # In a band where no flight ended, a body is anywhere.
    return np.asarray(np.where(total > 0, counts / np.maximum(total, 1e-300), mixed))
