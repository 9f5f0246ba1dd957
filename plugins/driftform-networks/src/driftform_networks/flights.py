"""Flights of a body in a straight pipe, and what they say about its bands: transfer, speed, and where it rests."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.stats import qmc

from driftform.errors import WorkFailedError
from driftform.types import End, FloatArray, Trajectory
from driftform.water import Scenario
from driftform_networks.bodies import Traveller
from driftform_networks.bore import BANDS, find_band, sample_band
from driftform_networks.cache import keep_result
from driftform_networks.releasing import draw_attitude, locate_middle, measure_pace, release

CELLS = 3
"""Cells of a flight; the transfer from band to band is that through one cell."""

CELL_BORES, CELL_S = 8.0, 20.0
"""Length of a cell: that of so many bores, or that of so many seconds of the water's motion if that is less."""

PER_BAND = 3
"""Flights that begin in each band."""

PATIENCE = 1.5
"""Longest flight, relative to the time that the water takes."""

CREEP = 0.02
"""Speed at the end of such a flight, relative to that of the water, below which a body counts as held."""

_LEAD = 2.0
"""Distance of the release from the inlet, bores: a body may roll back at first."""

_SEED = 20260


@dataclass(frozen=True, eq=False)
class StraightFlights:
    """What flights through a straight pipe say.

    Attributes
    ----------
    cell
        length of a cell, m.
    transfer
        probability that a body in a band is in each band one cell later, (bands, bands); what is left of 1 is the
        probability that it is held.
    slowness
        time for a cell from each band, relative to that of the water, (bands,).
    states
        bodies at the ends of cells: band, place of the centre of the displaced water to the right and upward relative
        to the bore's radius, quaternion, velocity over ground in the body frame, (n, 13).
    failed
        share of the flights that the simulator could not fly.
    """

    cell: float
    transfer: FloatArray
    slowness: FloatArray
    states: FloatArray
    failed: float


@dataclass(frozen=True)
class StraightTask:
    """Flights to make: a body in a pipe of a bore (m), a mean speed (m/s), and a slope (rise over length).

    The worker process that makes them writes them to ``path``: what is finished is not lost with the others.
    """

    traveller: Traveller
    bore: float
    speed: float
    slope: float
    path: Path

    def __call__(self) -> StraightFlights:
        """Make the flights, or read them."""
        return keep_result(
            self.path,
            StraightFlights,
            lambda: fly_straight(self.traveller, self.bore, self.speed, self.slope),
        )


def fly_straight(traveller: Traveller, bore: float, speed: float, slope: float) -> StraightFlights:
    """Return what flights of a body through a straight pipe say.

    Raises
    ------
    WorkFailedError
        if the simulator can fly none of them.
    """
    cell = min(CELL_BORES * bore, CELL_S * speed)
    scenarios, _starts = _make_scenarios(traveller, bore, speed, slope, cell)
    if not scenarios:
        # It fits in no attitude: it is held at once.
        return StraightFlights(cell, np.zeros((BANDS, BANDS)), np.ones(BANDS), np.zeros((0, 13)), 0.0)
    agents = [traveller.agent] * len(scenarios)
    flights = traveller.simulator.screen_batch(agents, scenarios, lambda _, __: False)
    sound = [flight for flight in flights if not flight.end.failed and len(flight.t) > 1]
    if not sound:
        raise WorkFailedError(
            f"{traveller.name}: cannot be flown in a bore of {1000 * bore:.0f} mm: {flights[0].failure}"
        )
    room = max(1 - traveller.agent.body.max_diameter / bore, 1e-3)
    counts, held = np.zeros((BANDS, BANDS)), np.zeros(BANDS)
    times, passed = np.zeros(BANDS), np.zeros(BANDS)
    states = []
    for flight in sound:
        frame = scenarios[0].release_frame()
        rows = _cross_cells(flight, frame, _LEAD * bore, cell)
        middle = locate_middle(flight, rows, traveller.agent.mass.cob)
        where = _relative(middle @ frame, bore)
        bands = find_band(where, room)
        for before, after, start, end in zip(bands, bands[1:], rows, rows[1:], strict=False):
            counts[before, after] += 1
            times[before] += flight.t[end] - flight.t[start]
            passed[before] += 1
        for row, band, place in list(zip(rows, bands, where, strict=True))[1:]:
            states.append([band, *place, *flight.quaternion[row], *flight.velocity[row]])
        if len(rows) <= CELLS and flight.end != End.OUTLET:
            _count_slow(flight, frame, speed, cell, bands[-1], counts, held, times, passed)
    total = counts.sum(axis=1) + held
    water = cell / speed
    with np.errstate(invalid="ignore", divide="ignore"):
        # A band in which no flight has been is like all others together.
        transfer = np.where(total[:, None] > 0, counts / total[:, None], counts.sum(axis=0) / total.sum())
        slowness = np.where(
            passed > 0, times / (passed * water), times.sum() / max(passed.sum() * water, 1e-9)
        )
    return StraightFlights(
        cell, transfer, slowness, np.array(states).reshape(-1, 13), 1 - len(sound) / len(flights)
    )


def _count_slow(
    flight: Trajectory,
    frame: FloatArray,
    speed: float,
    cell: float,
    band: int,
    counts: FloatArray,
    held: FloatArray,
    times: FloatArray,
    passed: FloatArray,
) -> None:
    """Count a flight that has not passed its cells: the body is held, or slow at the pace of the end of its flight."""
    pace = measure_pace(flight, frame[:, 0])
    if pace < CREEP * speed:
        held[band] += 1
    else:
        counts[band, band] += 1
        times[band] += cell / pace
        passed[band] += 1


def _make_scenarios(
    traveller: Traveller, bore: float, speed: float, slope: float, cell: float
) -> tuple[list[Scenario], FloatArray]:
    """Return the scenarios of the flights, with releases that fit into the pipe, and where they begin, (flights, 2)."""
    length = _LEAD * bore + CELLS * cell
    rise = length * slope
    document = traveller.scenario.model_dump(include={"fluid", "flow", "contact"})
    document["flow"] |= {"speed": max(speed, 1e-4)}
    document["pipe"] = {
        "segments": [
            {
                "start": (0.0, 0.0, 0.0),
                "end": (float(np.sqrt(length**2 - rise**2)), 0.0, float(rise)),
                "radius": bore / 2,
            }
        ]
    }
    document["flight"] = {"horizon": PATIENCE * CELLS * cell / speed}
    room = max(1 - traveller.agent.body.max_diameter / bore, 0.0)
    numbers = qmc.Sobol(4, rng=np.random.default_rng(_SEED)).random_base2(6)
    scenarios, starts = [], []
    for index in range(BANDS * PER_BAND):
        band = index // PER_BAND
        place = sample_band(band, room, numbers[index : index + 1, :2])[0]
        if document["flow"]["kind"] == "turbulent":
            document["flow"]["seed"] = index
        attitude = draw_attitude(numbers[index, 2:])
        found = release(traveller, document, _LEAD * bore, place * bore / 2, *attitude)
        if found is not None:
            scenarios.append(found)
            starts.append(place)
    return scenarios, np.array(starts)


def _cross_cells(flight: Trajectory, frame: FloatArray, start: float, cell: float) -> list[int]:
    """Return the samples at which a flight is first at the begin, and at the ends of its cells."""
    along = (flight.position @ frame)[:, 0] - start
    rows = [0]
    for number in range(1, CELLS + 1):
        beyond = np.flatnonzero(along >= number * cell - 1e-6)
        if not len(beyond):
            break
        rows.append(int(beyond[0]))
    return rows


def _relative(points: FloatArray, bore: float) -> FloatArray:
    """Return points of the pipe's frame to the right and upward, relative to the bore's radius, (n, 2)."""
    return np.column_stack([-points[:, 1], points[:, 2]]) / (bore / 2)
