"""Flights of a body through a fitting, and what they show: its outlet, the band there, and where it is held."""

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from driftform.types import FloatArray, Trajectory
from driftform.util import rotations
from driftform.water import Scenario
from driftform_networks.cache import keep_result
from driftform_networks.flights.bodies import Traveller
from driftform_networks.flights.bore import BANDS, find_band, spread_points
from driftform_networks.flights.straight import StraightTask, draw_attitude, fly, locate_middle, release, spread_numbers
from driftform_networks.flights.tees import BRANCH, RUN, Tee
from driftform_networks.hydraulics.network import IntArray

RINGS, AROUND = 7, 15
"""Releases of a body that is anywhere: so many rings of so many, each for the same area of the bore."""

STATES, MIN_STATES = 6, 2
"""Releases of another body: so many of the states at the ends of straight flights, from each band at least so many."""

HORIZON_BORES = 24.0
"""Longest flight: the time in which the water of the main passes so many bores."""

_LEAD, _START = 2.0, 0.25
"""Length of the straight before the tee, and distance of the release from its begin, in bores: its second half changes over
from the profile of a long pipe to the flow of the tee."""

_STUB = 0.5
"""Length of the straights after the tee, in bores of the main."""

_BEND = 1.5
"""Radius of a bend, in bores: that of long-radius elbows (ASME B16.9)."""

_SETTLED = 2.0
"""Distance from the end of a leg of the tee, in its radii, from which on a body is in that outlet: beyond the rounded edge."""

_SEED = 20261


@dataclass(frozen=True, eq=False)
class TeeFlights:
    """What flights through a tee show.

    Attributes:
        onward: probability of each outlet, :data:`~driftform_networks.flights.tees.RUN` and ``BRANCH``, and of the band in
            it, for each band of the main, (bands, 2, bands); what is left of 1 is the probability that the body is
            held.
        failed: share of the flights that the simulator could not fly.
    """

    onward: FloatArray
    failed: float


@dataclass(frozen=True)
class TeeTask:
    """Flights to make through a tee: of a body from the ends of straight flights, or from anywhere in the bore without them.

    ``folder`` keeps the result.
    """

    traveller: Traveller
    folder: Path
    tee: Tee
    straight: StraightTask | None

    @property
    def path(self) -> Path:
        """File of the result."""
        main = self.straight and [self.straight.bore, self.straight.speed, self.straight.slope]
        return self.folder / self.traveller.name_file(tee=[asdict(self.tee), main])

    def __call__(self) -> TeeFlights:
        """Make the flights, or read them."""
        return keep_result(self.path, TeeFlights, self._fly)

    def _fly(self) -> TeeFlights:
        if self.straight is None:
            return fly_tee(self.traveller, self.tee, None)
        return fly_tee(self.traveller, self.tee, self.straight().states, self.straight.slope)


def fly_tee(traveller: Traveller, tee: Tee, states: FloatArray | None, slope: float = 0.0) -> TeeFlights:
    """Return what flights of a body through a tee show.

    Args:
        states: of :class:`~driftform_networks.flights.straight.StraightFlights`, at the ends of flights through the main;
            ``None`` for a body that is anywhere in the bore, weighted by the water that passes there.
        slope: of the straight pipe of the states; the tee is level.

    Raises WorkFailedError if the simulator can fly none of them.
    """
    document, along = describe_pipe(traveller, tee), _START * tee.bore
    starts = _spread(traveller, tee) if states is None else _continue(traveller, tee, states, slope)
    releases = []
    for seed, (band, *start) in enumerate(starts):
        document["gusts"]["seed"] = seed
        releases.append((band, release(traveller, document, along, *start)))
    bands = [band for band, scenario in releases if scenario is not None]
    scenarios = [scenario for _, scenario in releases if scenario is not None]
    if not scenarios:
        return TeeFlights(np.zeros((BANDS, 2, BANDS)), 0.0)
    flights = fly(traveller, scenarios, f"through a tee of {1000 * tee.bore:.0f} mm")
    counts, total = np.zeros((BANDS, 2, BANDS)), np.zeros(BANDS)
    for band, scenario, flight in zip(bands, scenarios, flights, strict=True):
        if flight is None:
            continue
        # Bodies that are anywhere arrive as often as the water passes their places.
        weight = float(np.linalg.norm(flight.velocity[0, :3])) if states is None else 1.0
        total[band] += weight
        if (end := _find_end(traveller, tee, scenario, flight)) is not None:
            counts[band, *end] += weight
    mean = counts.sum(axis=0) / total.sum()
    known = (total > 0) & (states is not None)
    onward = np.where(known[:, None, None], counts / np.maximum(total, 1e-300)[:, None, None], mean)
    return TeeFlights(onward, flights.count(None) / len(flights))


def describe_pipe(traveller: Traveller, tee: Tee) -> dict[str, Any]:
    """Return the scenario of a fitting without a release: a level main, with the flow of straight pipes."""
    radius, stub = tee.bore / 2, _STUB * tee.bore
    document = traveller.scenario.model_dump(include={"fluid", "contact", "flow", "gusts"})
    document["flow"] |= {"speed": tee.speed}
    document["flight"] = {"horizon": HORIZON_BORES * tee.bore / tee.speed}
    lead, end = {"length": _LEAD * tee.bore}, {"length": stub, "outlet": "run"}
    if tee.share is None:
        bend = {"kind": "bend", "angle_deg": tee.angle_deg, "radius": _BEND * tee.bore, "roll_deg": tee.clock_deg}
        reducer = {"kind": "reducer", "length": max(1, tee.ratio) * tee.bore, "radius": tee.ratio * radius}
        turned = [*[bend] * (tee.angle_deg > 0), *[reducer] * (tee.ratio != 1)]
        return document | {"pipe": {"radius": radius, "parts": [lead, *turned, end]}}
    junction = {
        "kind": "tee" if tee.angle_deg == 90 else "wye",
        "branch_radius": tee.ratio * radius,
        "share": tee.share,
        "roll_deg": tee.clock_deg,
        "branch": [{"length": stub, "outlet": "branch"}],
    }
    if junction["kind"] == "wye":
        junction["angle_deg"] = tee.angle_deg
    # The pressure of ideal flow presses bodies onto edges where real water separates: friction would hold them there.
    document["contact"] |= {"friction": 0.0}
    return document | {"pipe": {"radius": radius, "parts": [lead, junction, end]}}


def _spread(traveller: Traveller, tee: Tee) -> Iterator[tuple[Any, ...]]:
    """Yield band, place, pitch and yaw of releases from anywhere; those nearest to the wall are as near as they can be."""
    room = max(1 - traveller.agent.body.max_diameter / tee.bore, 0.0)
    places = spread_points(1.0, RINGS, AROUND)
    # The thousandth keeps the releases off the wall.
    places = places * np.minimum(1.0, 0.999 * room / np.linalg.norm(places, axis=1))[:, None]
    numbers = spread_numbers(len(places), 2, _SEED)
    for band, place, pair in zip(find_band(places, room).tolist(), places, numbers, strict=False):
        yield band, place * tee.bore / 2, *draw_attitude(pair)


def _continue(traveller: Traveller, tee: Tee, states: FloatArray, slope: float) -> Iterator[tuple[Any, ...]]:
    """Yield band, place, pitch, yaw and velocity of releases as at the ends of straight flights."""
    picked = states[_pick_states(states[:, 0].astype(np.int64))]
    x, z = np.sqrt(1 - slope**2), slope
    pipe = np.array([[x, 0.0, z], [0.0, 1.0, 0.0], [-z, 0.0, x]])
    turned = pipe @ rotations.matrix_from_quaternion(picked[:, 3:7])
    ahead, middle = turned[..., 0], turned @ traveller.agent.mass.cob
    velocity = np.einsum("nij,nj->ni", turned, picked[:, 7:10])
    # The states have the place of the centre of the displaced water, and a release that of the core.
    places = picked[:, 1:3] * tee.bore / 2 - np.column_stack([-middle[:, 1], middle[:, 2]])
    pitch = -np.rad2deg(np.arcsin(np.clip(ahead[:, 2], -1, 1)))
    yaw = np.rad2deg(np.arctan2(ahead[:, 1], ahead[:, 0]))
    bands = picked[:, 0].astype(np.int64)
    yield from zip(bands.tolist(), places, pitch.tolist(), yaw.tolist(), velocity, strict=True)


def _pick_states(bands: IntArray) -> IntArray:
    """Return rows of states, as many from each band that there is."""
    known = np.unique(bands)
    most = max(MIN_STATES, STATES // max(len(known), 1))
    rows = [np.flatnonzero(bands == band) for band in known]
    picked = [row[np.linspace(0, len(row) - 1, min(most, len(row))).round().astype(int)] for row in rows]
    return np.concatenate(picked) if picked else np.zeros(0, np.int64)


def _find_end(traveller: Traveller, tee: Tee, scenario: Scenario, flight: Trajectory) -> tuple[int, int] | None:
    """Return the outlet in which a flight has ended, and the band there; ``None`` if it has ended in neither."""
    layout, clock = scenario.pipe.layout, np.deg2rad(tee.clock_deg)
    middle = locate_middle(flight, [-1], traveller.agent.mass.cob)[0]
    openings = {outlet.name: outlet.opening for outlet in layout.outlets}
    left, up = layout.inlet.axes[1:]
    # A branch is seen as if it left at the right: what rolls it there turns its upward direction too.
    rolled = np.cos(clock) * left + np.sin(clock) * up
    for outlet, name, upward in ((RUN, "run", up), (BRANCH, "branch", rolled)):
        if name not in openings:
            continue
        opening = openings[name]
        beyond, downstream = middle - opening.centre, opening.axes[0]
        place = np.array([beyond @ np.cross(downstream, upward), beyond @ upward]) / opening.radius
        settled = beyond @ downstream > -(_STUB * tee.bore + _SETTLED * opening.radius * (tee.share is not None))
        if settled and np.linalg.norm(place) <= 1:
            room = max(1 - traveller.agent.body.max_diameter / (2 * opening.radius), 1e-3)
            return outlet, int(find_band(place[None], room)[0])
    return None
