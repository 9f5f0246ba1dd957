"""Flights of a body in a straight pipe: transfer between its bands, speed, and where it rests; and releases in any bore."""

from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from driftform.errors import WorkFailedError
from driftform.types import End, FloatArray, Trajectory
from driftform.util import rotations
from driftform.water import Scenario
from driftform_networks.cache import keep_result
from driftform_networks.flights.bodies import Traveller
from driftform_networks.flights.bore import BANDS, find_band, sample_band
from driftform_networks.hydraulics.network import IntArray

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

_SEED, _ATTITUDES = 20260, 60


@dataclass(frozen=True, eq=False)
class StraightFlights:
    """What flights through a straight pipe show.

    Attributes:
        cell: length of a cell, m.
        transfer: probability that a body in a band is in each band one cell later, (bands, bands); what is left of 1
            is the probability that it is held.
        slowness, scatter: mean and variance of the time for a cell from each band, relative to that of the water, (bands,).
        states: bodies at the ends of cells: band, place of the centre of the displaced water to the right and upward
            relative to the bore's radius, quaternion, velocity over ground in the body frame, (n, 13).
    """

    cell: float
    transfer: FloatArray
    slowness: FloatArray
    scatter: FloatArray
    states: FloatArray


@dataclass(frozen=True)
class StraightTask:
    """Flights to make: a body in a pipe of a bore (m), a mean speed (m/s), and a slope (rise over length).

    ``folder`` keeps the result.
    """

    traveller: Traveller
    folder: Path
    bore: float
    speed: float
    slope: float

    @property
    def path(self) -> Path:
        """File of the result."""
        return self.folder / self.traveller.name_file(straight=[self.bore, self.speed, self.slope])

    def __call__(self) -> StraightFlights:
        """Make the flights, or read them."""
        return keep_result(self.path, StraightFlights, partial(_fly_straight, self))


def _fly_straight(task: StraightTask) -> StraightFlights:
    """Return what flights of a body through a straight pipe show.

    Raises WorkFailedError if the simulator can fly none of them.
    """
    traveller, bore, speed = task.traveller, task.bore, task.speed
    cell = min(CELL_BORES * bore, CELL_S * speed)
    scenarios = _make_scenarios(traveller, bore, speed, task.slope, cell)
    if not scenarios:
        # It fits in no attitude: it is held at once.
        return StraightFlights(cell, np.zeros((BANDS, BANDS)), np.ones(BANDS), np.zeros(BANDS), np.zeros((0, 13)))
    flights = fly(traveller, scenarios, f"in a bore of {1000 * bore:.0f} mm")
    room = max(1 - traveller.agent.body.max_diameter / bore, 1e-3)
    counts, held = np.zeros((BANDS, BANDS)), np.zeros(BANDS)
    times, squares, states = np.zeros(BANDS), np.zeros(BANDS), []

    def count(before: int, after: int, time: float) -> None:
        counts[before, after] += 1
        times[before] += time
        squares[before] += time**2

    frame = scenarios[0].release_frame()
    for flight in flights:
        if flight is None or len(flight.t) < 2:
            continue
        rows = _cross_cells(flight, frame, _LEAD * bore, cell)
        middle = locate_middle(flight, rows, traveller.agent.mass.cob)
        # To the right and upward, relative to the bore's radius.
        where = (middle @ frame)[:, 1:] * (-1.0, 1.0) / (bore / 2)
        bands = find_band(where, room)
        for (before, start), (after, end) in pairwise(zip(bands, rows, strict=True)):
            count(before, after, flight.t[end] - flight.t[start])
        for row, band, place in list(zip(rows, bands, where, strict=True))[1:]:
            states.append([band, *place, *flight.quaternion[row], *flight.velocity[row]])
        if len(rows) <= CELLS and flight.end != End.OUTLET:
            # It has not passed its cells: it is held, or slow at the pace of its end.
            pace = measure_pace(flight, frame[:, 0])
            if pace < CREEP * speed:
                held[bands[-1]] += 1
            else:
                count(bands[-1], bands[-1], cell / pace)
    passed, water = counts.sum(axis=1), cell / speed
    total = passed + held
    with np.errstate(invalid="ignore", divide="ignore"):
        # A band in which no flight has been is like all others together.
        transfer = np.where(total[:, None] > 0, counts / total[:, None], counts.sum(axis=0) / total.sum())
        slowness = np.where(passed > 0, times / (passed * water), times.sum() / max(passed.sum() * water, 1e-9))
        scatter = np.where(passed > 1, squares / (passed * water**2) - slowness**2, 0.0)
    return StraightFlights(cell, transfer, slowness, np.maximum(scatter, 0.0), np.array(states).reshape(-1, 13))


def _make_scenarios(traveller: Traveller, bore: float, speed: float, slope: float, cell: float) -> list[Scenario]:
    """Return the scenarios of the flights, with releases that fit into the pipe."""
    length = _LEAD * bore + CELLS * cell
    rise = length * slope
    document = traveller.scenario.model_dump(include={"fluid", "flow", "gusts", "contact"})
    document["flow"] |= {"speed": max(speed, 1e-4)}
    end = (float(np.sqrt(length**2 - rise**2)), 0.0, float(rise))
    document["pipe"] = {"segments": [{"start": (0.0, 0.0, 0.0), "end": end, "radius": bore / 2}]}
    document["flight"] = {"horizon": PATIENCE * CELLS * cell / speed}
    room = max(1 - traveller.agent.body.max_diameter / bore, 0.0)
    numbers = spread_numbers(BANDS * PER_BAND, 4, _SEED)
    scenarios = []
    for index in range(BANDS * PER_BAND):
        band = index // PER_BAND
        place = sample_band(band, room, numbers[index : index + 1, :2])[0]
        document["gusts"]["seed"] = index
        attitude = draw_attitude(numbers[index, 2:])
        scenarios.append(release(traveller, document, _LEAD * bore, place * bore / 2, *attitude))
    return [scenario for scenario in scenarios if scenario is not None]


def _cross_cells(flight: Trajectory, frame: FloatArray, start: float, cell: float) -> list[int]:
    """Return the samples at which a flight is first at the begin, and at the ends of its cells."""
    along = (flight.position @ frame)[:, 0] - start
    beyond = (np.flatnonzero(along >= number * cell - 1e-6) for number in range(1, CELLS + 1))
    return [0, *(int(rows[0]) for rows in beyond if len(rows))]


def release(
    traveller: Traveller,
    document: dict[str, Any],
    along: float,
    place: FloatArray,
    pitch_deg: float,
    yaw_deg: float,
    velocity: FloatArray | None = None,
) -> Scenario | None:
    """Return the scenario of a release, ``None`` if the body fits in no attitude.

    Its place moves to the axis, and its attitude along the pipe, until it fits.

    Args:
        document: the scenario without a release.
        along: distance from the inlet, m.
        place: of the core's centre to the right and upward, m, (2,).
        pitch_deg, yaw_deg: attitude relative to the pipe.
        velocity: relative to the pipe, m/s, (3,); ``None`` for that of the water.
    """
    # An end may lead: the body keeps its head or its tail downstream.
    turned = yaw_deg if abs(yaw_deg) <= 90 else yaw_deg - np.copysign(180, yaw_deg)
    for number in range(_ATTITUDES):
        share = 1 - number / _ATTITUDES
        right, up = share * place
        start: dict[str, Any] = {
            # To the right of the stream is -y.
            "position": (along, float(-right), float(up)),
            "pitch_deg": float(share * pitch_deg),
            "yaw_deg": float(share * turned + (yaw_deg - turned)),
        }
        if velocity is not None:
            start["velocity"] = tuple(velocity.tolist())
        scenario = Scenario.model_validate(document | {"release": start})
        if scenario.find_misfit(traveller.agent.body) is None:
            return scenario
    return None


def spread_numbers(count: int, columns: int, seed: int) -> FloatArray:
    """Return numbers in [0, 1) that fill the unit cube evenly, (at least count, columns): a scrambled Sobol sequence."""
    from scipy.stats import qmc

    return np.asarray(qmc.Sobol(columns, rng=np.random.default_rng(seed)).random_base2((count - 1).bit_length()))


def draw_attitude(numbers: FloatArray) -> tuple[float, float]:
    """Return pitch and yaw, degrees, of an axis that points anywhere alike, from two numbers in [0, 1)."""
    return float(np.rad2deg(np.arcsin(2 * numbers[0] - 1))), float(360 * numbers[1] - 180)


def fly(traveller: Traveller, scenarios: list[Scenario], pipe: str) -> list[Trajectory | None]:
    """Return the flights of a body, ``None`` for those that the simulator cannot fly.

    A flight that has taken all its steps counts as one at its horizon: gusts shake a body where an edge holds it.

    Raises WorkFailedError if the simulator can fly none of them; ``pipe`` says where.
    """
    agents = [traveller.agent] * len(scenarios)
    flights = traveller.simulator.screen_batch(agents, scenarios, lambda _, __: False)
    found = [flight if flight.end is End.STEP_LIMIT or not flight.end.failed else None for flight in flights]
    if all(flight is None for flight in found):
        raise WorkFailedError(f"{traveller.name}: cannot be flown {pipe}: {flights[0].failure}")
    return found


def locate_middle(flight: Trajectory, rows: list[int] | IntArray, middle: FloatArray) -> FloatArray:
    """Return where the centre of the displaced water is: the core may lie at one end of a long body, (rows, 3) in m."""
    return np.asarray(flight.position[rows] + rotations.matrix_from_quaternion(flight.quaternion[rows]) @ middle)


def measure_pace(flight: Trajectory, downstream: FloatArray) -> float:
    """Return the mean speed (m/s) along a direction in the last fifth of a flight."""
    late = flight.t >= 0.8 * flight.t[-1]
    along = flight.position[late] @ downstream
    return float((along[-1] - along[0]) / max(flight.t[-1] - flight.t[late][0], 1e-9))
