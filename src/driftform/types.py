"""The values that cross the seams: frozen dataclasses, with their shapes, units and frames.

Conventions, stated once (``docs/conventions.md`` expands on them):

* SI units and radians throughout.
* World frame: x downstream along the pipe axis, z up, origin on the pipe axis at the inlet.
* Body frame: x along the axis of revolution, forward positive, origin at the core's centre; y and z
  complete a right-handed frame.
* Quaternions are ``(w, x, y, z)`` and turn body vectors into world vectors.
* 6-vectors are ordered surge, sway, heave, roll, pitch, yaw, in the body frame.
* Added mass is positive: it is the negative of the SNAME derivatives.

Arrays in these values are float64, C-contiguous and read-only.
"""

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from driftform.errors import WorkFailedError

FloatArray: TypeAlias = npt.NDArray[np.float64]
"""An array of double precision; docstrings tell its shape, unit and frame."""


def freeze(values: npt.ArrayLike, shape: tuple[int | None, ...], what: str) -> FloatArray:
    """Return a read-only float64 copy of ``values``, checked against ``shape`` (``None`` is any length).

    Raises
    ------
    ValueError
        where the shape is another; the message spells out both.
    """
    array = np.array(values, dtype=np.float64, order="C")
    fits = array.shape == shape or (
        array.ndim == len(shape) and all(n in (None, m) for n, m in zip(shape, array.shape, strict=True))
    )
    if not fits:
        wanted = ", ".join("n" if n is None else str(n) for n in shape)
        raise ValueError(f"{what} has shape {array.shape}, expected ({wanted})")
    array.setflags(write=False)
    return array


@dataclass(frozen=True)
class Genome:
    """A genotype: a flat tuple of symbols, whose structure only the named grammar knows."""

    grammar: str
    symbols: tuple[str, ...]


@dataclass(frozen=True)
class Module:
    """One conical frustum: ``length`` along the slant (m), ``tilt`` of the wall against the axis (rad).

    A positive tilt widens away from the core.
    """

    length: float
    tilt: float


@dataclass(frozen=True)
class Morphology:
    """The modules on either side of the core, ``fore`` and ``aft``, each side ordered from the core outward."""

    fore: tuple[Module, ...] = ()
    aft: tuple[Module, ...] = ()

    @property
    def modules(self) -> tuple[Module, ...]:
        """All modules from the aft end to the fore end."""
        return self.aft[::-1] + self.fore


@dataclass(frozen=True)
class Core:
    """The spherical control unit at the origin of the body frame: ``radius`` (m) and ``mass`` (kg)."""

    radius: float
    mass: float


@dataclass(frozen=True, eq=False)
class Body:
    """A body of revolution: its meridian section, what is inside, and what it is made of.

    Attributes
    ----------
    outer
        outer contour, (n, 2) of x and r in m, from the aft axis point to the fore axis point.
    cavity
        contour of the hollow inside, (m, 2), in the same order; (0, 2) for a solid body.
    joints
        the x (m) of the module joints from aft to fore, both ends included, (k,).
    core
        the sphere at the origin.
    wall
        nominal wall thickness, m.
    hull_density
        density of the hull's material, kg/m3.
    """

    outer: FloatArray
    cavity: FloatArray
    joints: FloatArray
    core: Core
    wall: float
    hull_density: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "outer", freeze(self.outer, (None, 2), "Body.outer"))
        object.__setattr__(self, "cavity", freeze(self.cavity, (None, 2), "Body.cavity"))
        object.__setattr__(self, "joints", freeze(self.joints, (None,), "Body.joints"))

    @property
    def length(self) -> float:
        """Overall length along the axis, m."""
        return float(self.outer[-1, 0] - self.outer[0, 0])

    @property
    def max_diameter(self) -> float:
        """Largest outer diameter, m."""
        return float(2 * self.outer[:, 1].max())


class FluidProperties(Protocol):
    """What buoyancy depends on; :class:`driftform.scenario.Fluid` has it."""

    @property
    def density(self) -> float:
        """Density, kg/m3."""

    @property
    def gravity(self) -> float:
        """Acceleration of gravity, m/s2."""


@dataclass(frozen=True, eq=False)
class MassProperties:
    """What a rigid body weighs and displaces.

    Attributes
    ----------
    mass
        kg, hull and core.
    cog
        centre of gravity in the body frame, m, (3,).
    inertia
        about the centre of gravity, along the body axes, kg m2, (3, 3).
    volume
        displaced volume, m3.
    cob
        centre of buoyancy, the centroid of the displaced volume, in the body frame, m, (3,).
    """

    mass: float
    cog: FloatArray
    inertia: FloatArray
    volume: float
    cob: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "cog", freeze(self.cog, (3,), "MassProperties.cog"))
        object.__setattr__(self, "inertia", freeze(self.inertia, (3, 3), "MassProperties.inertia"))
        object.__setattr__(self, "cob", freeze(self.cob, (3,), "MassProperties.cob"))

    def net_buoyancy(self, fluid: FluidProperties) -> float:
        """Return the buoyancy of the submerged body less its weight, N, upward positive."""
        return (fluid.density * self.volume - self.mass) * fluid.gravity


@dataclass(frozen=True, eq=False)
class Drag:
    """Drag of a slender body: strips across its axis, and one resistance along it.

    A strip's force is ``-1/2 rho C_d(Re) factor d dx |v| v`` with the velocity v across the axis where the strip
    is, relative to the water there; ``C_d`` is that of a long cylinder
    (:func:`driftform.hydrodynamics.drag_coefficients.crossflow_coefficient`). Along the axis it is ``-1/2 rho (C_f(Re_L)
    friction_area + A) |u| u``, with A = ``ahead`` for motion towards +x and A = ``astern`` for motion towards -x.

    Attributes
    ----------
    strips
        x of the middle, diameter d, width dx (m each), and factor, (n, 4).
    friction_area
        wetted area times form factor, m2.
    length
        that the Reynolds number of friction refers to, m.
    ahead, astern
        drag areas of the ends (coefficient times area), m2.
    """

    strips: FloatArray
    friction_area: float = 0.0
    length: float = 1.0
    ahead: float = 0.0
    astern: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "strips", freeze(self.strips, (None, 4), "Drag.strips"))


@dataclass(frozen=True, eq=False)
class Coefficients:
    """Hydrodynamic coefficients about ``origin``, in body axes.

    The force of the fluid on a body with relative velocity nu is
    ``-M_A nu' - C_A(nu) nu - D_1 nu - D_2 |nu| nu`` (Fossen, with ``|nu| nu`` taken component by component).

    Attributes
    ----------
    added_mass
        M_A, (6, 6), symmetric, positive semi-definite; kg, kg m, kg m2.
    origin
        the point of the body frame that the matrices refer to, m, (3,).
    linear_damping
        D_1, (6, 6).
    quadratic_damping
        D_2, (6, 6).
    drag
        drag that these matrices cannot hold, ``None`` for none; its x is that of the body frame, not of
        ``origin``.
    """

    added_mass: FloatArray
    origin: FloatArray = field(default_factory=lambda: np.zeros(3))
    linear_damping: FloatArray = field(default_factory=lambda: np.zeros((6, 6)))
    quadratic_damping: FloatArray = field(default_factory=lambda: np.zeros((6, 6)))
    drag: Drag | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "origin", freeze(self.origin, (3,), "Coefficients.origin"))
        for name in ("added_mass", "linear_damping", "quadratic_damping"):
            object.__setattr__(self, name, freeze(getattr(self, name), (6, 6), f"Coefficients.{name}"))


@dataclass(frozen=True, eq=False)
class Agent:
    """An agent ready to fly: what a simulator, an exporter and a renderer receive.

    A simulator reads only ``mass`` and ``coefficients``, and ``body`` for its contact with walls.
    ``morphology`` and ``genome`` are ``None`` for a body that no grammar made.
    """

    body: Body
    mass: MassProperties
    coefficients: Coefficients
    morphology: Morphology | None = None
    genome: Genome | None = None


class End(StrEnum):
    """Why a flight ended."""

    OUTLET = "outlet"
    """The core's centre is past the downstream end of the pipe."""
    INLET = "inlet"
    """It is more than a radius upstream of the inlet."""
    HORIZON = "horizon"
    """The longest duration of a flight is over."""
    NON_FINITE = "non-finite"
    """It did not go on: position or velocity is no finite number any more."""
    STEP_LIMIT = "step limit"
    """The simulator took more steps than it may."""
    NOT_CONVERGED = "not converged"
    """The estimated error of the position is larger than what the simulator was asked for."""

    @property
    def failed(self) -> bool:
        """True where the flight is an error of the simulation and not a motion."""
        return self in (End.NON_FINITE, End.STEP_LIMIT, End.NOT_CONVERGED)


@dataclass(frozen=True, eq=False)
class Trajectory:
    """One flight.

    Attributes
    ----------
    t
        time, s, (k,), strictly increasing from 0.
    position
        of the core's centre in the world frame, m, (k, 3).
    quaternion
        body to world, (k, 4).
    velocity
        over ground, in the body frame: surge, sway, heave (m/s), roll, pitch, yaw (rad/s), (k, 6).
    end
        why it ended.
    contact
        when a wall was first touched, s; ``None`` where none was.
    energy_drift
        largest change of the energy of body and water up to then, relative to the largest kinetic energy;
        ``None`` where nothing conserves it: with drag, and in water that is not of one velocity everywhere.
    error
        estimated error of the position, m, the largest along the flight; ``None`` where it was not estimated.
    """

    t: FloatArray
    position: FloatArray
    quaternion: FloatArray
    velocity: FloatArray
    end: End
    contact: float | None = None
    energy_drift: float | None = None
    error: float | None = None

    def __post_init__(self) -> None:
        k = np.shape(self.t)[0]
        object.__setattr__(self, "t", freeze(self.t, (k,), "Trajectory.t"))
        for name, width in (("position", 3), ("quaternion", 4), ("velocity", 6)):
            object.__setattr__(self, name, freeze(getattr(self, name), (k, width), f"Trajectory.{name}"))

    @property
    def failure(self) -> str | None:
        """When and why the flight failed, ``None`` for a sound one."""
        return f"the flight ended after {self.t[-1]:.3g} s: {self.end}" if self.end.failed else None

    def require_success(self, name: str) -> None:
        """Refuse a flight that failed.

        Raises
        ------
        WorkFailedError
            if it failed; the message begins with ``name``, that of the agent.
        """
        if self.failure is not None:
            raise WorkFailedError(f"{name}: {self.failure}")


@dataclass(frozen=True)
class Candidate:
    """A genome that a strategy asks to be evaluated, and where it comes from.

    Attributes
    ----------
    genome
        what to evaluate.
    parents
        indices of the evaluations it descends from, empty for a random one.
    generation
        counted from 0.
    target
        the target its population works for, ``""`` where it works for all.
    """

    genome: Genome
    parents: tuple[int, ...] = ()
    generation: int = 0
    target: str = ""


@dataclass(frozen=True, eq=False)
class Evaluation:
    """The outcome of one evaluation; a failure is an outcome too.

    Attributes
    ----------
    genome
        what was evaluated.
    fitness
        one value for each target of the scenario, in its order, (targets,); zeros for a failure.
    trajectory
        the flight, ``None`` where it never came to one.
    failure
        what went wrong, ``None`` for a sound evaluation.
    seconds
        how long it took.
    """

    genome: Genome
    fitness: FloatArray
    trajectory: Trajectory | None = None
    failure: str | None = None
    seconds: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "fitness", freeze(self.fitness, (None,), "Evaluation.fitness"))

    @classmethod
    def failed(
        cls, genome: Genome, targets: int, failure: str, trajectory: Trajectory | None = None
    ) -> "Evaluation":
        """The outcome of a genome that could not be evaluated: no fitness for any of the targets, and the reason."""
        return cls(genome, np.zeros(targets), trajectory, failure)


class State(StrEnum):
    """What a check came to."""

    PASS = "pass"
    """It is as it should be."""
    WARN = "warn"
    """It can be printed, and something is worth knowing."""
    FAIL = "fail"
    """It cannot be printed, or is not what was simulated."""
    SKIPPED = "skipped"
    """It could not be checked; the finding tells why."""


@dataclass(frozen=True)
class Finding:
    """What one check found.

    Attributes
    ----------
    check
        what was looked at, in a word or two: ``closed``.
    state
        what came of it; ``fail`` is for what makes a print useless, ``warn`` for what its maker ought to know.
    detail
        one line for people: the numbers, and the next step where something is amiss; for ``skipped`` the reason.
    part
        the piece it is about, ``""`` where it is about all of them.
    """

    check: str
    state: State
    detail: str
    part: str = ""


@dataclass(frozen=True)
class WrittenFile:
    """A file that an exporter or a renderer made: its ``format``, its ``path``, and facts worth telling."""

    format: str
    path: str
    facts: dict[str, Any] = field(default_factory=dict)
