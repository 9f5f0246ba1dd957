"""The attitude in which a body hangs in still water or floats on it, and the eigenvalues of its motion about it."""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from driftform.dynamics.buoyancy import buoyancy, buoyant_energy
from driftform.dynamics.equations import accelerations
from driftform.dynamics.model import (
    BODY_MASS,
    COB,
    COG,
    CURRENT,
    DENSITY,
    DISPLACED_MASS,
    GRAVITY,
    INVERSE,
    STEADY,
    WATER_LEVEL,
    FlightModel,
)
from driftform.dynamics.rotations import rotation_from_vector
from driftform.dynamics.vectors import Rotation, Vector
from driftform.types import FloatArray

_STEP = 1e-6
"""Of the differences that the eigenvalues are computed from, m, rad, m/s and rad/s."""

_PITCHES = np.linspace(-math.pi / 2, math.pi / 2, 181)


@dataclass(frozen=True, eq=False)
class Rest:
    """An attitude of stable rest in still water, far from any wall.

    Attributes
    ----------
    pitch
        of the body's axis, rad, positive nose down.
    height
        of the body's origin below (negative) or above the surface, m; ``None`` where the body does not float on one,
        and only its attitude is at rest: what is not neutral rises or sinks.
    eigenvalues
        of the motion about it, 1/s, (12,), sorted by their size: position and attitude, and their rates.
    """

    pitch: float
    height: float | None
    eigenvalues: npt.NDArray[np.complex128]

    @property
    def slowest_period(self) -> float | None:
        """Period (s) of the slowest oscillation; ``None`` where nothing oscillates."""
        speeds = self.eigenvalues.imag[self.eigenvalues.imag > 10 * math.sqrt(_STEP)]
        return float(2 * math.pi / speeds.min()) if speeds.size else None


def stable_rest(model: FlightModel) -> Rest:
    """Return how the body comes to rest; with a free surface and a body that is lighter than water, floating on it.

    A floating body rests where the potential energy of weight and buoyancy is least. What does not float is released
    at rest, and rests in the attitude that small turns come back to. Currents and walls are left out.
    """
    still = _in_still_open_water(model)
    table = still.table
    floats = table[WATER_LEVEL] < math.inf and table[BODY_MASS] < table[DISPLACED_MASS]
    if not floats:
        table[WATER_LEVEL] = math.inf
        lever = table[DISPLACED_MASS] * table[COB, 0] - table[BODY_MASS] * table[COG, 0]
        net = table[DISPLACED_MASS] - table[BODY_MASS]
        # Fore end up, a small pitch is turned back by the moment and, through the inertia that couples heave with
        # pitch, by the net force; fore end down, by their opposites.
        back = table[INVERSE + 4, 4] * lever - table[INVERSE + 4, 2] * net
        pitch = -math.copysign(math.pi / 2, back) if back else 0.0
        return Rest(pitch, None, eigenvalues(still, 0.0, pitch))
    table[WATER_LEVEL] = 0.0
    energies = [_energy(still, _floating_height(still, pitch), pitch) for pitch in _PITCHES]
    best = int(np.argmin(energies))
    low, high = _PITCHES[max(best - 1, 0)], _PITCHES[min(best + 1, len(_PITCHES) - 1)]
    for _ in range(60):
        third = (high - low) / 3
        a, b = low + third, high - third
        if _energy(still, _floating_height(still, a), a) < _energy(still, _floating_height(still, b), b):
            high = b
        else:
            low = a
    pitch = float(low + high) / 2
    height = _floating_height(still, pitch)
    return Rest(pitch, height, eigenvalues(still, height, pitch))


def eigenvalues(model: FlightModel, height: float, pitch: float) -> npt.NDArray[np.complex128]:
    """Return the eigenvalues (1/s, (12,)) of small motions about rest at a height (m) and a pitch (rad).

    The state is position, rotation vector on top of the pitch, and the rates of both; its derivatives are those of
    :func:`driftform.dynamics.equations.accelerations`, differenced.
    """

    def rate(state: FloatArray) -> FloatArray:
        x, y, z, p, q, r = state[:6].tolist()
        a, b, c = (np.array(_attitude(pitch)) @ np.array(rotation_from_vector(p, q, r))).tolist()
        R = ((a[0], a[1], a[2]), (b[0], b[1], b[2]), (c[0], c[1], c[2]))
        vx, vy, vz, wx, wy, wz = state[6:].tolist()
        linear, angular = accelerations(0.0, (x, y, height + z), R, (vx, vy, vz), (wx, wy, wz), model)
        return np.array([*state[6:], *linear, *angular])

    columns = [(rate(h) - rate(-h)) / (2 * _STEP) for h in _STEP * np.eye(12)]
    values = np.linalg.eigvals(np.column_stack(columns))
    return np.asarray(values[np.argsort(-np.abs(values), kind="stable")], dtype=np.complex128)


def _in_still_open_water(model: FlightModel) -> FlightModel:
    table = model.table.copy()
    table[CURRENT, :3] = 0.0
    table[STEADY] = 1.0
    return model._replace(table=table, pipe=np.empty((0, 8)))


def _attitude(pitch: float) -> Rotation:
    return rotation_from_vector(0.0, pitch, 0.0)


def _floating_height(model: FlightModel, pitch: float) -> float:
    """Height of the origin above the surface at which buoyancy carries the weight, m, by bisection."""
    table = model.table
    weight = table[DENSITY] * table[GRAVITY]
    reach = float(np.abs(model.slices[:, 0]).max() + model.slices[:, 1].max() + model.slices[:, 3].max())
    low, high = -2 * reach, 2 * reach
    for _ in range(60):
        middle = (low + high) / 2
        _, volume, _ = buoyancy(middle, _attitude(pitch), _centre(model), 0.0, weight, model.slices)
        if table[DENSITY] * volume > table[BODY_MASS]:
            low = middle
        else:
            high = middle
    return (low + high) / 2


def _energy(model: FlightModel, height: float, pitch: float) -> float:
    table, R = model.table, _attitude(pitch)
    lift = buoyant_energy(height, R, _centre(model), 0.0, table[DENSITY] * table[GRAVITY], model.slices)
    return float(lift + table[BODY_MASS] * table[GRAVITY] * (height + np.dot(R[2], table[COG, :3])))


def _centre(model: FlightModel) -> Vector:
    x, y, z = model.table[COB, :3].tolist()
    return x, y, z
