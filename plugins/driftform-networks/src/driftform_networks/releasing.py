"""Releases of a body in the bore of a pipe, and where it is in a bore later: what all flights in a network share."""

from typing import Any

import numpy as np

from driftform.errors import WorkFailedError
from driftform.types import End, FloatArray, Trajectory
from driftform.water import Scenario
from driftform_networks.bodies import Traveller
from driftform_networks.network import IntArray

_ATTITUDES = 60


def release(
    traveller: Traveller,
    document: dict[str, Any],
    along: float,
    place: FloatArray,
    pitch_deg: float,
    yaw_deg: float,
    velocity: FloatArray | None = None,
) -> Scenario | None:
    """Return the scenario of a release; its place moves to the axis, and its attitude along the pipe, until it fits.

    Args:
        document: the scenario without a release.
        along: distance from the inlet, m.
        place: of the core's centre to the right and upward, m, (2,).
        pitch_deg, yaw_deg: attitude relative to the pipe.
        velocity: relative to the pipe, m/s, (3,); ``None`` for that of the water.

    Returns:
        scenario: ``None`` if the body fits in no attitude.
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


def turn(quaternion: FloatArray, vector: FloatArray) -> FloatArray:
    """Return vectors of the body frame in the world frame, (n, 3)."""
    w, axis = quaternion[:, :1], quaternion[:, 1:]
    turned = np.cross(axis, vector)
    return np.asarray(vector + 2 * (w * turned + np.cross(axis, turned)))


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
    return np.asarray(flight.position[rows] + turn(flight.quaternion[rows], middle))


def measure_pace(flight: Trajectory, downstream: FloatArray) -> float:
    """Return the mean speed (m/s) along a direction in the last fifth of a flight."""
    late = flight.t >= 0.8 * flight.t[-1]
    along = flight.position[late] @ downstream
    return float((along[-1] - along[0]) / max(flight.t[-1] - flight.t[late][0], 1e-9))
