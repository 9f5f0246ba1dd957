"""The values that plugins exchange: frozen dataclasses, with their shapes, units and frames.

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

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass, replace
from enum import StrEnum
from operator import index
from typing import Any, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

__all__ = [
    "Agent", "Body", "Candidate", "Coefficients", "Core", "Detail", "Drag", "End", "Evaluation", "Finding",
    "Fittings", "FloatArray", "Genome", "MassProperties", "Module", "Moments", "Morphology", "Pocket", "State",
    "Trajectory", "Verdict", "WrittenFile",
]  # fmt: skip

FloatArray: TypeAlias = npt.NDArray[np.float64]
"""An array of double precision; docstrings state its shape, unit and frame."""

BoolArray: TypeAlias = npt.NDArray[np.bool_]
"""An array of truth values."""


def freeze(values: npt.ArrayLike, shape: tuple[int | None, ...], what: str) -> FloatArray:
    """Return a read-only float64 copy of ``values``, checked against ``shape``, which may begin with ``None`` for any length.

    An array that is one already, and owns its memory, is returned itself.

    Raises:
        TypeError: if the values are not real numbers.
        ValueError: if the shapes differ; the message states both.
    """
    given = np.asarray(values)
    if given.dtype.kind not in "biuf":
        raise TypeError(f"{what} holds values of type {given.dtype}, expected real numbers")
    flags = given.flags
    is_frozen = flags.owndata and not flags.writeable and flags.c_contiguous and given.dtype == np.float64
    array = given if is_frozen else np.array(given, dtype=np.float64, order="C")
    first = int(shape[0] is None)
    if array.ndim != len(shape) or array.shape[first:] != shape[first:]:
        wanted = ", ".join("n" if n is None else str(n) for n in shape)
        raise ValueError(f"{what} has shape {array.shape}, expected ({wanted})")
    array.setflags(write=False)
    return array


def freeze_fields(value: object, **shapes: tuple[int | None, ...]) -> None:
    """Freeze fields of a frozen dataclass as :func:`freeze` does, each with its shape."""
    for name, shape in shapes.items():
        what = f"{type(value).__name__}.{name}"
        object.__setattr__(value, name, freeze(getattr(value, name), shape, what))


class ByContent:
    """A value that equals another of its class if their fields have the same content; see :func:`same_content`."""

    def __eq__(self, other: object) -> bool:
        return same_content(self, other) if type(self) is type(other) else NotImplemented

    def __hash__(self) -> int:
        # Arrays have no hash: values of one class are told apart by their content alone.
        return hash(type(self))


def same_content(a: Any, b: Any) -> bool:
    """Return whether two values have the same content.

    Arrays are compared element by element, and NaN equals NaN; dataclasses by their fields, mappings and sequences by
    their items, plugins by their class and options; anything else by ``==``.
    """
    if a is b or type(a) is not type(b):
        return a is b
    if isinstance(a, np.ndarray | float):
        return np.array_equal(a, b, equal_nan=np.asarray(a).dtype.kind in "fc")
    if is_dataclass(a):
        return all(same_content(getattr(a, field.name), getattr(b, field.name)) for field in fields(a))
    if isinstance(a, Mapping):
        return a.keys() == b.keys() and all(same_content(a[key], b[key]) for key in a)
    if isinstance(a, Sequence) and not isinstance(a, str | bytes):
        return len(a) == len(b) and all(map(same_content, a, b))
    options = getattr(a, "options", None)
    return bool(a == b) if options is None else same_content(options, b.options)


@dataclass(frozen=True)
class Genome:
    """A genotype: a flat tuple of symbols, and the one gene that is a number, the tuning of the body.

    Only the named grammar knows the structure of the symbols, and only the builder the meaning of the tuning, such as
    the mass of ballast; 0 leaves the body as it is without.
    """

    grammar: str
    symbols: tuple[str, ...]
    tuning: float = 0.0

    def __post_init__(self) -> None:
        if not isinstance(self.symbols, tuple):
            raise TypeError(f"Genome.symbols is a {type(self.symbols).__name__}, expected a tuple of texts")
        # Searches make many genomes, and nearly all hold nothing but plain texts.
        if {type(self.grammar), *map(type, self.symbols)} != {str}:
            for symbol in (self.grammar, *self.symbols):
                if not isinstance(symbol, str):
                    raise TypeError(
                        f"Genome holds {symbol!r}, a {type(symbol).__name__}, expected text, such as repr(number)"
                    )


@dataclass(frozen=True)
class Module:
    """One conical frustum: ``length`` along the slant (m), ``tilt`` of the wall against the axis (rad).

    With a positive tilt the frustum widens away from the core.
    """

    length: float
    tilt: float


@dataclass(frozen=True)
class Morphology:
    """The modules on the two sides of the core, ``fore`` and ``aft``, each ordered from the core outward; and the tuning."""

    fore: tuple[Module, ...] = ()
    aft: tuple[Module, ...] = ()
    tuning: float = 0.0

    @property
    def modules(self) -> tuple[Module, ...]:
        """All modules from the aft end to the fore end."""
        return self.aft[::-1] + self.fore


@dataclass(frozen=True)
class Moments:
    """Volume integrals of a solid of revolution about the x axis, for unit density, about the frame's origin.

    Attributes:
        volume: V, m3.
        first: integral of x dV, m4.
        second: integral of x^2 dV, m5.
        polar: integral of (y^2 + z^2) dV: the inertia about the axis, m5.
    """

    volume: float = 0.0
    first: float = 0.0
    second: float = 0.0
    polar: float = 0.0

    def __add__(self, other: "Moments") -> "Moments":
        return Moments(
            self.volume + other.volume, self.first + other.first, self.second + other.second, self.polar + other.polar
        )

    def __sub__(self, hole: "Moments") -> "Moments":
        return Moments(
            self.volume - hole.volume, self.first - hole.first, self.second - hole.second, self.polar - hole.polar
        )

    def scale(self, factor: float) -> "Moments":
        """Return those of the solid with all its lengths multiplied by a factor, about the same origin."""
        cube, fifth = factor**3, factor**5
        return Moments(cube * self.volume, cube * factor * self.first, fifth * self.second, fifth * self.polar)

    def matrix(self) -> FloatArray:
        """Return them as the integral of h h^T, h = (1, x, y, z), over a solid that is alike all round, (4, 4)."""
        found = np.diag([self.volume, self.second, self.polar / 2, self.polar / 2])
        found[0, 1] = found[1, 0] = self.first
        return found

    @property
    def centroid(self) -> float:
        """x of the centroid, m."""
        return self.first / self.volume

    @property
    def transverse(self) -> float:
        """Inertia about the y (or z) axis through the origin, for unit density, m5 (eq. 16)."""
        return self.polar / 2 + self.second


@dataclass(frozen=True)
class Core:
    """The control unit: a homogeneous sphere about the origin of the body frame, or a solid of revolution.

    Attributes:
        radius: greatest radius, m.
        mass: kg.
        contour: x and r in m, from the aft axis point to the fore axis point, of what it needs room for: widest at
            the origin, and nowhere wider again; empty for a sphere.
        solid: volume integrals of that solid; those of a sphere follow from its radius.
        cog: x of its centre of gravity, m. The inertia about it is that of even density about the centroid.
    """

    radius: float
    mass: float
    contour: tuple[tuple[float, float], ...] = ()
    solid: Moments = Moments()
    cog: float = 0.0

    @property
    def volume(self) -> float:
        """Volume, m3."""
        return self.solid.volume if self.contour else 4 / 3 * np.pi * self.radius**3

    @property
    def inertia(self) -> tuple[float, float]:
        """Moments of inertia about its centre of gravity, along the axis and across it, kg m2."""
        if not self.contour:
            return (0.4 * self.mass * self.radius**2,) * 2
        density, centroid = self.mass / self.volume, self.solid.centroid
        return density * self.solid.polar, density * (self.solid.transverse - self.volume * centroid**2)

    @property
    def ends(self) -> tuple[float, float]:
        """x of its aft and its fore end, m."""
        return (self.contour[0][0], self.contour[-1][0]) if self.contour else (-self.radius, self.radius)

    def radius_at(self, x: npt.ArrayLike) -> FloatArray:
        """Return its radius at each x, m; 0 beyond its ends."""
        at = np.asarray(x, dtype=np.float64)
        if not self.contour:
            return np.asarray(np.sqrt(np.maximum(self.radius**2 - at**2, 0.0)))
        along, radii = np.array(self.contour).T
        return np.asarray(np.interp(at, along, radii, left=0.0, right=0.0))


@dataclass(frozen=True, eq=False)
class Detail:
    """Solids that a hull has beside its body of revolution, such as an eyelet or the lugs of a bayonet.

    Attributes:
        name: of what it is.
        added: what is added, as a tree of ``driftform_frusta.csg``, or ``None``.
        removed: what is then cut out, likewise.
        material: integral of h h^T over the material that the hull gains, less that over what it loses, with h = (1, x, y, z)
            in m, (4, 4): its volume and moments.
        displaced: the same for what the body displaces.
        area: of its shadows along the three axes outside the hull, the root of the sum of their squares, m2.
    """

    name: str
    added: Any
    removed: Any
    material: FloatArray
    displaced: FloatArray = field(default_factory=lambda: np.zeros((4, 4)))
    area: float = 0.0

    def __post_init__(self) -> None:
        freeze_fields(self, material=(4, 4), displaced=(4, 4))

    @property
    def moments(self) -> Moments:
        """Volume integrals of its material about the axis."""
        (volume, first, *_), (_, second, *_), (_, _, yy, _), (*_, zz) = self.material.tolist()
        return Moments(volume, first, second, yy + zz)


@dataclass(frozen=True)
class Fittings:
    """What a hull has besides the wall of its section.

    Attributes:
        material: volume integrals of the material that a kit adds, such as that of its joints, less that which it removes.
        details: what is fitted to it, which these leave out.
        seals: the same integrals over the mass of its O-rings, in kg for m3.
        flooded: those over the room before its O-rings, which is open to water.
        glands: of each O-ring, as JSON, what it is and how it fits its groove, with a ``summary``.
    """

    material: Moments = Moments()
    details: tuple[Detail, ...] = ()
    seals: Moments = Moments()
    flooded: Moments = Moments()
    glands: tuple[Mapping[str, Any], ...] = ()

    def scale(self, factor: float) -> "Fittings":
        """Return those of the hull with all its lengths multiplied by a factor; solids are drawn, and O-rings bought, as before."""
        lengths = factor**3 * np.outer(h := np.array([1.0, factor, factor, factor]), h)
        details = (replace(d, material=lengths * d.material, displaced=lengths * d.displaced) for d in self.details)
        return replace(self, material=self.material.scale(factor), details=tuple(details))


@dataclass(frozen=True)
class Pocket:
    """A hole on the axis at an end of a hull, open to the water, in which putty trims the sealed print.

    Attributes:
        mouth: x of its open end, m.
        tip: x of its closed end, where it ends in a cone of 45 degrees, m.
        radius: of its bore, m.
        filled: share of its volume that the putty of the design fills, from the tip on.
        density: of the putty, kg/m3.
    """

    mouth: float
    tip: float
    radius: float
    filled: float
    density: float

    @property
    def volume(self) -> float:
        """Volume from mouth to tip, m3: the cone has that of a third of its length of bore."""
        return float(np.pi * self.radius**2 * (abs(self.mouth - self.tip) - 2 / 3 * self.radius))

    def contour(self, filled: float = 1.0) -> FloatArray:
        """Return the contour of the pocket, or of what fills a share of its volume from the tip on, (4, 2) of x and r, m."""
        r, way = self.radius, 1 if self.mouth > self.tip else -1
        level = 2 / 3 * r + filled * (abs(self.mouth - self.tip) - 2 / 3 * r)
        x = self.tip + way * np.array([0.0, r, level, level])
        return np.column_stack((x, [0.0, r, r, 0.0]))[::way]


@dataclass(frozen=True, eq=False)
class Body:
    """A body of revolution: its meridian section, core and material.

    Attributes:
        outer: outer contour, (n, 2) of x and r in m, from the aft axis point to the fore axis point.
        cavity: contour of the cavity, x and r in m, (m, 2), in the same order; (0, 2) for a solid body.
        joints: x of the module joints, m, from aft to fore, including both ends, (k,).
        core: what the hull encloses, at the origin of the body frame.
        wall: nominal wall thickness, m.
        hull_density: density of the hull's material, kg/m3.
        fittings: what the hull has besides the wall between both contours.
        ballast: volume integrals of the ball of ballast that lies inside the hull, on its axis. What holds it counts
            as a part of it, so that the hull does not depend on it.
        ballast_density: density of the ballast, kg/m3.
        expansion: coefficient of thermal expansion of the hull's material, linear, 1/K.
        squeeze: share of its volume that the hull loses under the pressure that it is built for.
        pockets: trim pockets, which the outer contour does not show.
    """

    outer: FloatArray
    cavity: FloatArray
    joints: FloatArray
    core: Core
    wall: float
    hull_density: float
    fittings: Fittings = Fittings()
    ballast: Moments = Moments()
    ballast_density: float = 0.0
    expansion: float = 0.0
    squeeze: float = 0.0
    pockets: tuple[Pocket, ...] = ()

    def __post_init__(self) -> None:
        freeze_fields(self, outer=(None, 2), cavity=(None, 2), joints=(None,))

    @property
    def length(self) -> float:
        """Overall length along the axis, m."""
        return float(self.outer[-1, 0] - self.outer[0, 0])

    @property
    def max_diameter(self) -> float:
        """Largest outer diameter, m."""
        return float(2 * self.outer[:, 1].max())

    def trim_range(self, water: float) -> tuple[float, float]:
        """Return the net weight (kg) in water of a density (kg/m3) that emptying all trim pockets adds, and filling them up."""
        whole = [(pocket.volume * (pocket.density - water), pocket.filled) for pocket in self.pockets]
        return sum(-full * filled for full, filled in whole), sum(full * (1 - filled) for full, filled in whole)


class FluidProperties(Protocol):
    """The properties of a fluid that buoyancy depends on, as :class:`driftform.water.Fluid` has them."""

    @property
    def density(self) -> float:
        """Density, kg/m3."""

    @property
    def gravity(self) -> float:
        """Acceleration of gravity, m/s2."""


@dataclass(frozen=True, eq=False)
class MassProperties:
    """Mass, displaced volume, their centres, and the inertia of a rigid body.

    Attributes:
        mass: mass of hull and core, kg.
        cog: centre of gravity in the body frame, m, (3,).
        inertia: inertia tensor about the centre of gravity, in body axes, kg m2, (3, 3).
        volume: displaced volume, m3.
        cob: centre of buoyancy, the centroid of the displaced volume, in the body frame, m, (3,).
    """

    mass: float
    cog: FloatArray
    inertia: FloatArray
    volume: float
    cob: FloatArray

    def __post_init__(self) -> None:
        freeze_fields(self, cog=(3,), inertia=(3, 3), cob=(3,))

    def net_buoyancy(self, fluid: FluidProperties) -> float:
        """Return the buoyancy of the submerged body less its weight, N, upward positive."""
        return (fluid.density * self.volume - self.mass) * fluid.gravity


@dataclass(frozen=True, eq=False)
class Drag:
    """What the water's viscosity does to a body of revolution; with C_d and C_f see :mod:`driftform.motion.forces.drag`.

    A strip's force is ``-1/2 rho C_d(Re) factor d dx |v| v`` with the velocity v across the axis at the
    strip, relative to the water there; C_d is that of a long cylinder, without what creeping motion adds. Along the axis it is
    ``-1/2 rho (C_f(Re_L) friction_area + A) |u| u``, with A = ``ahead`` for motion towards +x and A = ``astern`` for
    motion towards -x. The part of the body that counts as a sphere has the force ``-1/2 rho C_d(Re) round_area |v| v`` of
    a sphere at ``centre``, again without creeping. The whole body creeps with the forces ``-mu k v`` at ``centre``.

    Attributes:
        strips: x of the middle, diameter d, width dx (m each), and factor of each strip, (n, 4).
        friction_area: wetted area, for skin friction, times the form factor of a streamlined body, m2.
        length: length in the Reynolds number Re_L of skin friction, m.
        ahead, astern: drag areas of the ends (coefficient times area), m2.
        round_area: frontal area times the share to which the body is a sphere, m2.
        diameter: greatest diameter, in the Reynolds numbers of sphere and spin, m.
        centre: x of the centre of the displaced volume, m.
        wake_ahead, wake_astern: x (m) and lift area (m2) of the tail, for motion towards +x and towards -x.
        spin: integral of 2 pi r^4 dx, for the friction of a spin about the axis, m5.
        shear_volume: volume times lift coefficient in a shear flow, m3.
        spread: variance of the displaced volume across the axis (in each direction) and along it, m2: the water's
            velocity is a mean over the body.
        blocking: diameter that narrows the bore, m; 0 if the drag is that in open water.
        creeping: k of Stokes flow: along the axis and across it (m), and of a turn about a transverse axis (m3); and
            the share of the water's curl with which the axis turns, b^2 / (a^2 + b^2) of a spheroid.
        rubbing: factor on the friction of strips, in addition to that of each strip.
    """

    strips: FloatArray
    friction_area: float = 0.0
    length: float = 1.0
    ahead: float = 0.0
    astern: float = 0.0
    round_area: float = 0.0
    diameter: float = 0.0
    centre: float = 0.0
    wake_ahead: tuple[float, float] = (0.0, 0.0)
    wake_astern: tuple[float, float] = (0.0, 0.0)
    spin: float = 0.0
    shear_volume: float = 0.0
    spread: tuple[float, float] = (0.0, 0.0)
    blocking: float = 0.0
    creeping: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    rubbing: float = 1.0

    def __post_init__(self) -> None:
        freeze_fields(self, strips=(None, 4))

    def scale(self, axial: float, across: float | None = None) -> "Drag":
        """Return the drag with the resistances times ``axial`` along the axis, and times ``across`` across it.

        Without ``across`` both are the same. The friction of a spin is that along the axis; a sphere's drag counts as
        drag across it. Lift and carrying speed are unchanged.
        """
        across = axial if across is None else across
        along, aside, turning, curl = self.creeping
        return replace(
            self,
            strips=self.strips * (1.0, 1.0, 1.0, across),
            friction_area=axial * self.friction_area,
            ahead=axial * self.ahead,
            astern=axial * self.astern,
            round_area=across * self.round_area,
            spin=axial * self.spin,
            creeping=(axial * along, across * aside, across * turning, curl),
        )


@dataclass(frozen=True, eq=False, repr=False)
class Coefficients:
    """Hydrodynamic coefficients about ``origin``, in body axes.

    The force of the fluid on a body with relative velocity nu is
    ``-M_A nu' - C_A(nu) nu - D_1 nu - D_2 |nu| nu`` (Fossen, with ``|nu| nu`` taken component by component).

    Attributes:
        added_mass: M_A, (6, 6), symmetric, positive semi-definite; kg, kg m, kg m2.
        origin: reference point of the matrices in the body frame, m, (3,).
        linear_damping: D_1, (6, 6); N s/m, N s, N m s.
        quadratic_damping: D_2, (6, 6).
        drag: drag that these matrices cannot express, ``None`` without such drag; its x is measured in the body
            frame, not from ``origin``.
    """

    added_mass: FloatArray
    origin: FloatArray = field(default_factory=lambda: np.zeros(3))
    linear_damping: FloatArray = field(default_factory=lambda: np.zeros((6, 6)))
    quadratic_damping: FloatArray = field(default_factory=lambda: np.zeros((6, 6)))
    drag: Drag | None = None

    def __post_init__(self) -> None:
        freeze_fields(self, origin=(3,), added_mass=(6, 6), linear_damping=(6, 6), quadratic_damping=(6, 6))

    def __repr__(self) -> str:
        along, across = self.added_mass[0, 0], self.added_mass[2, 2]
        return f"<Coefficients: added mass {along:.4g} kg along, {across:.4g} kg across{', drag' if self.drag else ''}>"

    def scale_damping(self, axial: float, across: float | None = None) -> "Coefficients":
        """Return the coefficients with damping and drag times ``axial`` along the axis, and ``across`` across it.

        Without ``across`` both are the same. Surge and roll are along the axis; what couples them with other motions has
        the geometric mean.
        """
        across = axial if across is None else across
        each = np.array([axial, across, across, axial, across, across])
        factors = np.sqrt(np.outer(each, each))
        return replace(
            self,
            linear_damping=factors * self.linear_damping,
            quadratic_damping=factors * self.quadratic_damping,
            drag=None if self.drag is None else self.drag.scale(axial, across),
        )


@dataclass(frozen=True, eq=False, repr=False)
class Agent(ByContent):
    """An agent that can fly: what a simulator and a renderer receive, and an exporter in its job.

    A simulator reads only ``mass``, ``coefficients`` and, for contact with walls, ``body``. ``morphology`` and
    ``genome`` are ``None`` for a body that was not made by a grammar.
    """

    body: Body
    mass: MassProperties
    coefficients: Coefficients
    morphology: Morphology | None = None
    genome: Genome | None = None

    def __repr__(self) -> str:
        return f"<Agent: {self.body.length:.3f} m long, {self.body.max_diameter:.3f} m wide, {self.mass.mass:.4f} kg>"


class End(StrEnum):
    """Why a flight ended."""

    OUTLET = "outlet"
    """The core's centre has passed the downstream end of the pipe."""
    INLET = "inlet"
    """The core's centre is more than a pipe radius upstream of the inlet."""
    EDGE = "edge of the grid"
    """The core's centre has left the grid of velocities, in open water."""
    HORIZON = "horizon"
    """The flight has lasted as long as the scenario allows."""
    NON_FINITE = "non-finite"
    """The position or the velocity is no longer finite."""
    STEP_LIMIT = "step limit"
    """The simulator has taken the largest number of steps that it may take."""
    NOT_CONVERGED = "not converged"
    """The estimated error of the position is larger than the accuracy that the simulator must reach."""

    @property
    def failed(self) -> bool:
        """True if the simulation failed, so that the trajectory is not a result."""
        return self in (End.NON_FINITE, End.STEP_LIMIT, End.NOT_CONVERGED)


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory:
    """The motion of an agent during one flight.

    Attributes:
        t: time, s, (k,), strictly increasing from 0.
        position: position of the core's centre in the world frame, m, (k, 3).
        quaternion: attitude, from body to world, (k, 4).
        velocity: velocity over ground, in the body frame: surge, sway, heave (m/s), roll, pitch, yaw (rad/s), (k, 6).
        end: why the flight ended.
        contact: time of the first contact with a wall, s; ``None`` without contact.
        energy_drift: largest change of the energy of body and water before the first contact, relative to the largest
            kinetic energy; ``None`` if energy is not conserved: with drag, or if the velocity of the water varies.
        error: largest estimated error of the position along the flight, m; ``None`` if it was not estimated: an
            unchecked flight.
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
        freeze_fields(self, t=(k,), position=(k, 3), quaternion=(k, 4), velocity=(k, 6))
        for name in ("contact", "energy_drift", "error"):
            if (value := getattr(self, name)) is not None:
                object.__setattr__(self, name, float(value))

    def __repr__(self) -> str:
        return f"<Trajectory: {len(self.t)} samples, {self.t[-1]:.2f} s to the {self.end}>"

    @property
    def failure(self) -> str | None:
        """When and why the flight failed, ``None`` for a sound one."""
        return f"the flight ended after {self.t[-1]:.3g} s: {self.end}" if self.end.failed else None


@dataclass(frozen=True)
class Candidate:
    """A genome that a strategy wants evaluated, and its origin.

    Attributes:
        genome: the genome to evaluate.
        parents: indices of the evaluations of its parents, empty for a random genome.
        generation: number of the generation, from 0.
        target: the target that its population is bred for, ``""`` if bred for all targets.
        threshold: for each target the fitness (%) that the candidate must exceed to matter to its strategy,
            (targets,); ``None`` if every fitness matters. It is neither stored nor compared.
    """

    genome: Genome
    parents: tuple[int, ...] = ()
    generation: int = 0
    target: str = ""
    threshold: tuple[float, ...] | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        # What is stored is compared with it, so integers of NumPy and lists become what is read back.
        object.__setattr__(self, "parents", tuple(index(parent) for parent in self.parents))
        object.__setattr__(self, "generation", index(self.generation))


@dataclass(frozen=True, eq=False, repr=False)
class Evaluation:
    """The outcome of one evaluation, successful or failed.

    Attributes:
        genome: the genome that was evaluated.
        fitness: fitness for each target of the scenario, %, in its order, (targets,); zeros for a failed evaluation.
        trajectory: the trajectory, ``None`` if the evaluation failed before the flight.
        failure: the reason of the failure in one line, ``None`` for a successful evaluation.
        seconds: duration of the evaluation, s.
        offsets: vector from each target to the closest approach, m, (targets, 3), NaN where the flight failed before,
            of a flight of a run, whose trajectory is compressed or, if it was disturbed, not kept; otherwise ``None``.
        measures: what was measured of agent and flight by name, besides the fitness; those of driftform are listed by
            :func:`driftform.agent.measure_evaluation`. Empty for a disturbed flight, and where it failed before.
        violations: by how much each constraint is missed, by name; 0 is feasible. Empty where there is no body.
    """

    genome: Genome
    fitness: FloatArray
    trajectory: Trajectory | None = None
    failure: str | None = None
    seconds: float = 0.0
    offsets: FloatArray | None = None
    measures: Mapping[str, float] = field(default_factory=dict)
    violations: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        freeze_fields(self, fitness=(None,))
        if self.offsets is not None:
            freeze_fields(self, offsets=(None, 3))

    def __repr__(self) -> str:
        found = (
            f"failed, {self.failure}" if self.failure else f"fitness {np.max(self.fitness, initial=0):.2f} % at most"
        )
        return f"<Evaluation of {len(self.genome.symbols)} symbols: {found}>"

    @classmethod
    def failed(cls, genome: Genome, targets: int, failure: str, trajectory: Trajectory | None = None) -> "Evaluation":
        """Return a failed evaluation: zero fitness for every target, and the reason."""
        return cls(genome, np.zeros(targets), trajectory, failure)


class Verdict(StrEnum):
    """What a fitness says of its target."""

    REACHED = "reached"
    """The agent does what it is for."""
    NEAR = "near"
    """The agent almost does."""
    MISSED = "missed"
    """The agent does not."""


class State(StrEnum):
    """The result of a check."""

    PASS = "pass"
    """The check found no fault."""
    WARN = "warn"
    """The part can be printed, but the maker should read the finding."""
    FAIL = "fail"
    """The part cannot be printed, or differs from the simulated one."""
    SKIPPED = "skipped"
    """The check could not be made; the finding gives the reason."""


@dataclass(frozen=True)
class Finding:
    """The finding of one check.

    Attributes:
        check: name of the check, one or two words such as ``closed``.
        state: result of the check; ``fail`` if it makes a print useless, ``warn`` if the maker should know.
        detail: one line of text: the numbers, and the next step after a fault; for ``skipped`` the reason.
        part: the part that was checked, ``""`` for all parts.
    """

    check: str
    state: State
    detail: str
    part: str = ""


@dataclass(frozen=True)
class WrittenFile:
    """A file that a plugin wrote: its ``format``, its ``path``, and ``facts`` about its content."""

    format: str
    path: str
    facts: dict[str, Any] = field(default_factory=dict)
