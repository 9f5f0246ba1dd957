"""The attitude in which a body rests in still water or floats on it, and the eigenvalues of its motion about it."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from driftform.motion.forces.buoyancy import buoyancy, buoyant_energy
from driftform.motion.forces.equations import accelerations
from driftform.motion.forces.model import FlightModel
from driftform.types import FloatArray
from driftform.util.compiled import compiled
from driftform.util.rotations import rotation_from_vector
from driftform.util.small_vectors import Rotation, dot

_DIFFERENCE = 1e-6
"""Step of the central differences for the eigenvalues, m, rad, m/s and rad/s."""

_PITCHES = np.linspace(-math.pi / 2, math.pi / 2, 181)


@dataclass(frozen=True, eq=False)
class Rest:
    """An attitude of stable rest in still water, far from any wall.

    Attributes:
        pitch: of the body's axis, rad, positive nose down.
        height: of the body's origin above the surface (negative below), m; ``None`` if the body does not float: then
            only its attitude is at rest, and a body that is not neutral rises or sinks.
        model: of the body in still water without walls.
    """

    pitch: float
    height: float | None
    model: FlightModel

    @cached_property
    def eigenvalues(self) -> npt.NDArray[np.complex128]:
        """Eigenvalues of the motion about the rest, 1/s, (12,), largest first: of position and attitude, and their rates."""
        return eigenvalues(self.model, self.height or 0.0, self.pitch)

    @property
    def slowest_period(self) -> float | None:
        """Period (s) of the slowest oscillation; ``None`` if nothing oscillates."""
        speeds = self.eigenvalues.imag[self.eigenvalues.imag > 10 * math.sqrt(_DIFFERENCE)]
        return float(2 * math.pi / speeds.min()) if speeds.size else None


def stable_rest(model: FlightModel) -> Rest:
    """Return the stable rest of a body: afloat if there is a free surface and the body is lighter than water.

    A floating body rests at the minimum of the potential energy of weight and buoyancy. A body that does not float
    rests in the attitude to which it returns after a small turn. Currents and walls are ignored.
    """
    still = model._replace(numbers=model.numbers.copy(), pipe=np.empty((0, 8)))
    n = still.numbers[0]
    n["current"], n["is_steady"] = 0.0, 1.0
    floats = n["water_level"] < math.inf and n["body_mass"] < n["displaced_mass"]
    if not floats:
        n["water_level"] = math.inf
        lever = n["displaced_mass"] * n["cob"][0] - n["body_mass"] * n["cog"][0]
        net = n["displaced_mass"] - n["body_mass"]
        # With the fore end up, the moment turns a small pitch back, and so does the net force through the inertia that
        # couples heave with pitch; with the fore end down, their opposites do.
        back = n["inverse"][4, 4] * lever - n["inverse"][4, 2] * net
        pitch = -math.copysign(math.pi / 2, back) if back else 0.0
        return Rest(pitch, None, still)
    n["water_level"] = 0.0
    return Rest(*_find_rest_afloat(still, _PITCHES), still)


def eigenvalues(model: FlightModel, height: float, pitch: float) -> npt.NDArray[np.complex128]:
    """Return the eigenvalues (1/s, (12,)) of small motions about rest at a height (m) and a pitch (rad).

    The state is position, rotation vector after the pitch, and the rates of both. The derivatives are central
    differences of :func:`driftform.motion.forces.equations.accelerations`.
    """

    def rate(state: FloatArray) -> FloatArray:
        x, y, z, p, q, r = state[:6].tolist()
        a, b, c = (np.array(_rotation(pitch)) @ np.array(rotation_from_vector(p, q, r))).tolist()
        R = ((a[0], a[1], a[2]), (b[0], b[1], b[2]), (c[0], c[1], c[2]))
        vx, vy, vz, wx, wy, wz = state[6:].tolist()
        linear, angular = accelerations(0.0, (x, y, height + z), R, (vx, vy, vz), (wx, wy, wz), model)
        return np.array([*state[6:], *linear, *angular])

    columns = [(rate(h) - rate(-h)) / (2 * _DIFFERENCE) for h in _DIFFERENCE * np.eye(12)]
    values = np.linalg.eigvals(np.column_stack(columns))
    return np.asarray(values[np.argsort(-np.abs(values), kind="stable")], dtype=np.complex128)


@compiled
def _rotation(pitch: float) -> Rotation:
    return rotation_from_vector(0.0, pitch, 0.0)


@compiled
def _find_rest_afloat(model: FlightModel, pitches: FloatArray) -> tuple[float, float]:
    """Return pitch (rad) and height (m) of least potential energy: the best of the pitches, refined."""
    best, least = 0, math.inf
    for k in range(pitches.shape[0]):
        energy = _floating_energy(model, pitches[k])
        if energy < least:
            best, least = k, energy
    low, high = pitches[max(best - 1, 0)], pitches[min(best + 1, pitches.shape[0] - 1)]
    for _ in range(60):
        third = (high - low) / 3
        a, b = low + third, high - third
        if _floating_energy(model, a) < _floating_energy(model, b):
            high = b
        else:
            low = a
    pitch = (low + high) / 2
    return pitch, _floating_height(model, _rotation(pitch))


@compiled
def _floating_energy(model: FlightModel, pitch: float) -> float:
    """Return the potential energy (J) of the body at a pitch (rad), at the height where it floats."""
    n, R = model.numbers[0], _rotation(pitch)
    height = _floating_height(model, R)
    centre = (n.cob[0], n.cob[1], n.cob[2])
    lift = buoyant_energy(height, R, centre, 0.0, n.density * n.gravity, model.slices)
    cog = height + dot(R[2], (n.cog[0], n.cog[1], n.cog[2]))
    return float(lift + n.body_mass * n.gravity * cog)


@compiled
def _floating_height(model: FlightModel, R: Rotation) -> float:
    """Return the height (m) of the origin above the surface at which buoyancy equals the weight, by bisection."""
    n, slices = model.numbers[0], model.slices
    centre = (n.cob[0], n.cob[1], n.cob[2])
    farthest = widest = thickest = 0.0
    for k in range(slices.shape[0]):
        farthest = max(farthest, abs(slices[k, 0]))
        widest = max(widest, slices[k, 1])
        thickest = max(thickest, slices[k, 3])
    high = 2 * (farthest + widest + thickest)
    low = -high
    for _ in range(60):
        middle = (low + high) / 2
        _, volume, _ = buoyancy(middle, R, centre, 0.0, n.density * n.gravity, slices)
        if n.density * volume > n.body_mass:
            low = middle
        else:
            high = middle
    return (low + high) / 2
