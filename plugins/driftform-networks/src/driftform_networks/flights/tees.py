"""Fittings that bodies are flown through: the few tees, wyes, bends and reducers that stand for all, and the flights."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from driftform.types import FloatArray, Trajectory
from driftform.util import rotations
from driftform.water import Scenario
from driftform_networks.cache import keep_result
from driftform_networks.flights.bodies import Traveller
from driftform_networks.flights.bore import BANDS, find_band, smallest_share, spread_points
from driftform_networks.flights.junctions import Junction
from driftform_networks.flights.straight import StraightTask, draw_attitude, fly, locate_middle, release, spread_numbers
from driftform_networks.hydraulics.network import IntArray

RATIOS = {60.0: (0.5, 1.0), 90.0: (0.25, 0.5, 0.7, 1.0), 120.0: (0.5, 1.0)}
"""Angles between the branch and the run, degrees, and the bores of the branch over that of the main whose flow is stored.

A junction takes the nearest angle, and the nearest bore by factor; one with a narrow branch that of 90 degrees.
"""

NARROW_BRANCH = 0.35
"""Such a ratio below which a branch is narrow: between the two narrowest that are stored."""

MIN_RATIO = 0.2
"""Least such ratio of a junction that is flown: that of the narrowest branch whose flow driftform solves."""

MAX_LEAN_DEG = 45.0
"""Deviation of a branch from a right angle up to which it is flown, degrees."""

BENDS_DEG = (0.0, 22.5, 45.0, 90.0)
"""Turns of bends where two pipes meet, degrees; a turn takes the nearest."""

REDUCTIONS = (0.5, 0.7, 1.0, 1.4, 2.0)
"""Bore after a reducer over the bore before it; a change of bore takes the nearest by factor."""

RUN, BRANCH = range(2)
"""Outlets of a tee."""

SHARES = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95)
"""Shares of the water that the branch takes; a junction takes its two neighbours, weighted."""

MIN_MIXED_SPEED = 0.05
"""Least speed of flights of mixed bodies, m/s: slower water, which has no other way with them, takes these."""

NARROW = 0.1
"""Diameter of a mixed body over the bore of the main below which flights say what streamtubes say."""


@dataclass(frozen=True)
class Tee:
    """A tee or wye of these ladders; or a bend and a reducer, which have no branch.

    Attributes:
        bore: of the main, m.
        speed: mean speed in the main, m/s.
        ratio: bore of the branch, or after the reducer, over that of the main.
        angle_deg: between the branch and the run, or of the bend.
        clock_deg: side where branch or bend lead, as on a clock seen downstream: 0 at the top, 90 on the right.
        share: share of the water that the branch takes; ``None`` for a bend and a reducer.
    """

    bore: float
    speed: float
    ratio: float
    angle_deg: float
    clock_deg: float
    share: float | None


def find_branches(junction: Junction) -> tuple[list[int], str]:
    """Return the outlets that are branches of a tee, a wye or a cross which can be flown through, the largest share first.

    Without them, a few words say why streamtubes divide its bodies.
    """
    sideways = junction.directions.any(axis=1)
    branches = np.flatnonzero(sideways)
    ratios = junction.bores[branches] / max(junction.bore, 1e-9)
    turns = np.rad2deg(junction.turns[branches])
    reasons = (
        (junction.inlets != 1, "join"),
        (not junction.bore, "no bore upstream"),
        (len(junction.bores) > 3, "more branches"),
        ((~sideways).sum() != 1, "no straight run"),
        ((ratios > 1 + 1e-6).any(), "wide branch"),
        ((ratios < MIN_RATIO).any(), "narrow branch"),
        ((np.abs(turns - 90) > MAX_LEAN_DEG).any(), "steep branch"),
    )
    if reason := next((text for found, text in reasons if found), ""):
        return [], reason
    return sorted(branches.tolist(), key=lambda branch: -float(junction.shares[branch])), ""


def find_joint(junction: Junction, size: float) -> tuple[float, float]:
    """Return the turn of the bend, degrees, and the ratio of the reducer, that stand for two pipes which meet.

    They are 0 and 1 where there is neither. ``size`` is the diameter of the body over the bore upstream.
    """
    if junction.inlets != 1 or len(junction.bores) != 1 or not junction.bore * junction.bores[0]:
        return 0.0, 1.0
    ratio = match_ratio(float(junction.bores[0]) / junction.bore, size, REDUCTIONS)
    return match_angle(float(junction.turns[0]), BENDS_DEG), ratio


def match_angle(turn: float, angles: Sequence[float]) -> float:
    """Return the nearest of some angles, degrees, to a turn to either side, rad."""
    return min(angles, key=lambda known: abs(known - abs(float(np.rad2deg(turn)))))


def match_ratio(ratio: float, size: float, ratios: Sequence[float]) -> float:
    """Return the nearest of some ratios of bores; a wider one if a body of ``size`` fits into the branch, but not into that one.

    >>> [match_ratio(0.55, size, RATIOS[90]) for size in (0.1, 0.52, 0.7)]
    [0.5, 0.7, 0.5]
    """
    nearest = min(ratios, key=lambda known: abs(np.log(known / ratio)))
    if size <= ratio:
        return min((known for known in ratios if known >= nearest and size < 0.99 * known), default=nearest)
    return nearest


def weigh_shares(share: float, size: float) -> list[tuple[float, float]]:
    """Return the shares around one at which bodies are flown, with weights of the sum 1.

    The shares 0 and 1 stand for junctions where one outlet takes no body: that is where it takes less than the smallest
    share of streamtubes that a body of ``size``, its diameter over the bore, can follow; 0 for a body that is
    anywhere.

    >>> weigh_shares(0.125, 0.0)
    [(0.1, 0.75), (0.2, 0.25)]
    >>> weigh_shares(0.02, 0.2)
    [(0.0, 1.0)]
    """
    least = smallest_share(size)
    steps = [least, *(step for step in SHARES if least < step < 1 - least), 1 - least]
    names = [0.0, *steps[1:-1], 1.0]
    above = int(np.clip(np.searchsorted(steps, share), 1, len(steps) - 1))
    weight = float(np.clip((share - steps[above - 1]) / (steps[above] - steps[above - 1]), 0, 1))
    found = [(names[above - 1], round(1 - weight, 6)), (names[above], round(weight, 6))]
    return [(step, part) for step, part in found if part > 0]


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
        main = self.straight
        states, slope = (None, 0.0) if main is None else (main().states, main.slope)
        return fly_tee(self.traveller, self.tee, states, slope)


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
